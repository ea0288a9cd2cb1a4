"use strict";
// Unpack deflated data (RFC 1951) synchronously, unlike a stream of the browser.

const LENGTHS = [3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 15, 17, 19, 23, 27, 31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258];
const DISTANCES = [1, 2, 3, 4, 5, 7, 9, 13, 17, 25, 33, 49, 65, 97, 129, 193, 257, 385, 513, 769, 1025, 1537, 2049, 3073, 4097,
  6145, 8193, 12289, 16385, 24577];
const ORDER = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];

function lengthBits(i) { return i === 28 || i < 4 ? 0 : (i >> 2) - 1; }
function distanceBits(i) { return i < 2 ? 0 : (i >> 1) - 1; }

// A code from the lengths of its words: the count of words of each length, and their symbols in order.
function codeOf(lengths) {
  const counts = new Array(16).fill(0), symbols = [];
  for (let length = 1; length < 16; length++) {
    lengths.forEach((each, symbol) => { if (each === length) { symbols.push(symbol); counts[length]++; } });
  }
  return { counts, symbols };
}

// `before` is the preceding data that the text may refer to.
function inflated(source, size, before = new Uint8Array()) {
  const target = new Uint8Array(before.length + size);
  let at = 0, bits = 0, held = 0, written = before.length, last = false;
  target.set(before);
  const take = (count) => {
    for (; held < count; held += 8) bits |= source[at++] << held;
    const value = bits & ((1 << count) - 1);
    bits >>>= count;
    held -= count;
    return value;
  };
  const symbolIn = ({ counts, symbols }) => {
    let code = 0, first = 0, index = 0;
    for (let length = 1; length < 16; length++) {
      code |= take(1);
      if (code - first < counts[length]) return symbols[index + code - first];
      index += counts[length];
      first = (first + counts[length]) << 1;
      code <<= 1;
    }
    throw new Error("the module is damaged");
  };
  const codes = () => {
    const literals = take(5) + 257, distances = take(5) + 1, count = take(4) + 4;
    const short = new Array(19).fill(0), lengths = [];
    for (let i = 0; i < count; i++) short[ORDER[i]] = take(3);
    const code = codeOf(short);
    while (lengths.length < literals + distances) {
      const symbol = symbolIn(code);
      if (symbol < 16) lengths.push(symbol);
      else {
        const value = symbol === 16 ? lengths.at(-1) : 0;
        const times = symbol === 16 ? 3 + take(2) : symbol === 17 ? 3 + take(3) : 11 + take(7);
        for (let i = 0; i < times; i++) lengths.push(value);
      }
    }
    return [codeOf(lengths.slice(0, literals)), codeOf(lengths.slice(literals))];
  };
  const fixed = () => [
    codeOf(Array.from({ length: 288 }, (_, i) => (i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8))), codeOf(new Array(30).fill(5)),
  ];
  while (!last) {
    last = take(1) === 1;
    const kind = take(2);
    if (kind === 0) {
      bits = held = 0;
      const count = source[at] + 256 * source[at + 1];
      target.set(source.subarray(at + 4, at + 4 + count), written);
      at += 4 + count;
      written += count;
      continue;
    }
    const [literals, distances] = kind === 1 ? fixed() : codes();
    for (let symbol = symbolIn(literals); symbol !== 256; symbol = symbolIn(literals)) {
      if (symbol < 256) target[written++] = symbol;
      else {
        const length = LENGTHS[symbol - 257] + take(lengthBits(symbol - 257)), place = symbolIn(distances);
        const back = DISTANCES[place] + take(distanceBits(place));
        for (let i = 0; i < length; i++, written++) target[written] = target[written - back];
      }
    }
  }
  return target.subarray(before.length);
}
