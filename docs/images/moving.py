"""Take the pictures of the first screen of a report and of the widget: ``python docs/images/moving.py``, from anywhere."""

import base64
import json
import sys
import tempfile
from pathlib import Path

from PIL import Image

import bristle as br
from bristle.apps.lab import Widget
from bristle.cli.demonstration import run
from bristle.files.results import results_folder

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))
from tests.apps.lab.browser import browser  # noqa: E402
from tests.apps.lab.test_widget import STUB  # noqa: E402

COLOURS = 64  # enough for lines and text
READY = """
(async () => {
  while (document.body.dataset.alive !== "ready") await new Promise((done) => setTimeout(done, 50));
  return [8, 752];
})()
"""
MOUNTED = """
(async () => {
  const module = await import(URL.createObjectURL(new Blob([esm], { type: "text/javascript" })));
  const el = document.createElement("div");
  document.body.append(el);
  await module.default.render({ model: stub(state), el });
  await new Promise((done) => setTimeout(done, 300));
  const { y, height } = el.getBoundingClientRect();
  return [y, height];
})()
"""


def taken(tab, y, height, file, width):
    """Save a part of a page as a picture of few colours."""
    clip = {"x": 0, "y": max(y - 8, 0), "width": width, "height": height + 16, "scale": 1}
    picture = tab.call("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)
    file.write_bytes(base64.b64decode(picture["data"]))
    Image.open(file).convert("RGB").quantize(COLOURS).save(file, optimize=True)


with tempfile.TemporaryDirectory() as place:
    with results_folder(Path(place) / "demo") as folder:
        run(folder, command="bristle demo")
    with browser(Path(place) / "first", width=1366, height=768) as tab:
        tab.open((Path(place) / "demo" / "report.html").as_uri())
        taken(tab, *tab.run(READY), Path(__file__).with_name("report.png"), 1366)
    model = br.friction.lugre(F_C="20 N", F_S="28 N", v_S="2 mm/s", sigma_0="10 N/um")
    widget, page = Widget(model), Path(place) / "notebook.html"
    page.write_text("<!DOCTYPE html><title>a notebook</title>", encoding="utf-8")
    with browser(Path(place) / "second", width=1000, height=900) as tab:
        tab.open(page.as_uri())
        state = {name: widget.get_state()[name] for name in ("_values", "_described", "_problem")}
        tab.run(
            f"{STUB} window.esm = {json.dumps(widget._esm)}; window.state = {json.dumps(state)}; 0"
        )
        taken(tab, *tab.run(MOUNTED), Path(__file__).with_name("widget.png"), 1000)
