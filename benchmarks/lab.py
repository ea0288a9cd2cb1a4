"""From a slider of the lab to the loop of 20 000 samples drawn, in Chromium without a window."""

import tempfile
from pathlib import Path

from tests.lab.browser import browser

from bristle.friction import MODELS
from bristle.lab import lab_page

MOVES = 120
MEASURE = """
(async (moves) => {
  const canvas = document.getElementById("loop"), context = canvas.getContext("2d");
  const slider = document.querySelector("#cards input[type=range]:not(:disabled)");
  const times = [];
  for (let k = 0; k < moves; k++) {
    slider.value = 900 + (k * 37) % 200;
    const before = performance.now();
    slider.dispatchEvent(new Event("input"));
    context.getImageData(0, 0, 1, 1);  // everything drawn so far is drawn now
    times.push(performance.now() - before);
    await new Promise((done) => requestAnimationFrame(() => setTimeout(done, 0)));
  }
  return times;
})(MOVES)
"""


def measured(folder):
    """Return, for each model, the milliseconds of each move."""
    page = Path(folder) / "lab.html"
    page.write_text(lab_page(), encoding="utf-8")
    times = {}
    with browser(Path(folder) / "profile") as tab:
        for name in MODELS:
            tab.open("about:blank")
            tab.open(f"{page.as_uri()}#model={name}")
            times[name] = sorted(tab.run(MEASURE.replace("MOVES", str(MOVES))))
    return times


def main():
    with tempfile.TemporaryDirectory() as folder:
        for name, times in measured(folder).items():
            print(f"{name:20s} median {times[MOVES // 2]:5.1f} ms, 95 % {times[int(0.95 * MOVES)]:5.1f} ms")


if __name__ == "__main__":
    main()
