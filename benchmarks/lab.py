"""From a slider of the lab to the loop drawn, in Chromium: while it moves, and with all of its 20 000 samples."""

import tempfile
from pathlib import Path
from urllib.parse import urlencode

from tests.apps.lab.browser import browser

from bristle.apps.lab import lab_page
from bristle.models.friction import MODELS

MOVES = 120
MEASURE = """
(async (moves) => {
  const canvas = document.getElementById("loop"), context = canvas.getContext("2d");
  const slider = document.querySelector("#cards input[type=range]:not(:disabled)");
  const moving = [], all = [];
  let whole = 0;
  for (let k = 0; k < moves; k++) {
    slider.value = 900 + (k * 37) % 200;
    const before = performance.now();
    slider.dispatchEvent(new Event("input"));
    context.getImageData(0, 0, 1, 1);  // everything drawn so far is drawn now
    moving.push(performance.now() - before);
    whole += lab.samples === SAMPLES;
    // As the slider is let go, what was drawn with fewer samples is drawn with all.
    slider.dispatchEvent(new Event("change"));
    context.getImageData(0, 0, 1, 1);
    all.push(performance.now() - before);
    await new Promise((done) => requestAnimationFrame(() => setTimeout(done, 0)));
  }
  return [moving, all, whole];
})(MOVES)
"""


def measured(folder):
    """Return, by model and slots, the milliseconds of each move, and until all is drawn, and what share was whole."""
    page = Path(folder) / "lab.html"
    page.write_text(lab_page(), encoding="utf-8")
    times = {}
    with browser(Path(folder) / "profile") as tab:
        for name in MODELS:
            for slots in ("", "asymmetry", "position ripple asymmetry"):
                tab.open("about:blank")
                tab.open(f"{page.as_uri()}#{urlencode({'model': name, 'slots': slots})}")
                moving, every, whole = tab.run(MEASURE.replace("MOVES", str(MOVES)))
                times[name, slots] = sorted(moving), sorted(every), whole / MOVES
    return times


def told(times):
    """Return in words what half of the times and 95 % of them are within."""
    return f"median {times[MOVES // 2]:5.1f} ms, 95 % {times[int(0.95 * MOVES)]:5.1f} ms"


def main():
    with tempfile.TemporaryDirectory() as folder:
        for (name, slots), (moving, every, whole) in measured(folder).items():
            print(
                f"{name:20s} {slots:26s} moving: {told(moving)}, all samples drawn in {whole:4.0%}; all samples: {told(every)}"
            )


if __name__ == "__main__":
    main()
