// Columns of numbers, unpacked.

// Integers packed by Python: zigzag signs, bytes grouped by significance.
async function unpackedNumbers({ code, count }) {
  const bytes = await inflated(code), numbers = new Int32Array(count);
  for (let k = 0; k < count; k++) {
    const folded = (bytes[k] | bytes[k + count] << 8 | bytes[k + 2 * count] << 16 | bytes[k + 3 * count] << 24) >>> 0;
    numbers[k] = (folded >>> 1) ^ -(folded & 1);
  }
  return numbers;
}

// The next `count` integers; undo `sums` differences.
async function columnsOf(packed) {
  const numbers = await unpackedNumbers(packed);
  let at = 0;
  return (count, sums, step = 1) => {
    const values = Float64Array.from(numbers.subarray(at, at + count));
    at += count;
    for (let i = 0; i < sums; i++) for (let k = 1; k < count; k++) values[k] += values[k - 1];
    return values.map((value) => value * step);
  };
}
