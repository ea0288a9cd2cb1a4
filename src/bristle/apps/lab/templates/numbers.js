// Columns of numbers, unpacked.

// Return a function that takes the next `count` integers and undoes `sums` differences. Python packs integers with zigzag
// signs, and bytes grouped by significance.
async function columnsOf({ code, count: all }) {
  const bytes = await inflated(code), numbers = Int32Array.from({ length: all }, (_, k) => {
    const folded = (bytes[k] | bytes[k + all] << 8 | bytes[k + 2 * all] << 16 | bytes[k + 3 * all] << 24) >>> 0;
    return (folded >>> 1) ^ -(folded & 1);
  });
  let at = 0;
  return (count, sums, step = 1) => {
    const values = Float64Array.from(numbers.subarray(at, at + count));
    at += count;
    for (let i = 0; i < sums; i++) for (let k = 1; k < count; k++) values[k] += values[k - 1];
    return values.map((value) => value * step);
  };
}
