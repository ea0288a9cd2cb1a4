"""Take the picture of the lab as it is served, in Chromium without a window: ``python docs/images/serve.py``."""

import base64
import sys
import tempfile
import time
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.apps.lab.browser import browser
from tests.apps.lab.server.mouse import Person
from tests.apps.lab.server.yard import served
from tests.cli.conftest import EXPERIMENT

from bristle.files import read_experiment
from bristle.simulation import simulate

COLOURS, WIDTH = 128, 1100
RATED = 250.0  # [N]
STEPS = ("step-1", "step-2", "step-5")  # those that are seen
SEEN = """
document.querySelectorAll("main > section, footer").forEach((part) => { part.hidden = !%s.includes(part.id); });
document.querySelectorAll("#verdict .tools, #verdict > p.note").forEach((part) => { part.hidden = true; });
document.querySelector("#report iframe").style.height = "660px";
"""


def recorded(folder: Path) -> Path:
    """Return the log of a simulated axis, as a drive exports it."""
    (folder / "experiment.toml").write_text(EXPERIMENT)
    run = simulate(read_experiment(folder / "experiment.toml")).variants["none"]
    columns = np.column_stack((run.time, 1e3 * run.measured, 100.0 * run.effort / RATED))
    head = f"Rated force: {RATED:g} N\ntime [s],position [mm],force [%]"
    np.savetxt(folder / "axis.csv", columns, delimiter=",", header=head, comments="", fmt="%.9g")
    return folder / "axis.csv"


with tempfile.TemporaryDirectory() as name, served() as server:
    folder = Path(name)
    with browser(folder / "profile", width=WIDTH, height=900) as tab:
        person = Person(tab, folder)
        tab.open(server.address)
        person.waits("state")
        person.chooses(recorded(folder))
        person.identifies("coulomb_viscous")
        person.waits("document.querySelector('#report iframe')")
        tab.run(SEEN % list(STEPS))
        time.sleep(1.0)
        height = tab.run("document.documentElement.scrollHeight")
        # A frame beyond the window is not drawn.
        tab.call(
            "Emulation.setDeviceMetricsOverride",
            width=WIDTH,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )
        time.sleep(4.0)
        clip = {"x": 0, "y": 0, "width": WIDTH, "height": height, "scale": 1}
        shot = tab.call(
            "Page.captureScreenshot", format="png", captureBeyondViewport=True, clip=clip
        )
    picture = Image.open(BytesIO(base64.b64decode(shot["data"]))).convert("RGB").quantize(COLOURS)
    picture.save(Path(__file__).with_suffix(".png"), optimize=True)
