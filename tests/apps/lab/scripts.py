"""The scripts of the page in node, without what draws."""

import json
import re
import shutil
import subprocess
from importlib import resources

import pytest

from bristle.apps.targets.page.packing import unpacked

SLOTS = ("position", "periodic", "load", "temperature", "asymmetry")
NODE = shutil.which("node")
NAMES = (
    "physics.js",
    "loop.js",
    "paths.js",
    "certificates.js",
    "controls.js",
    "slots.js",
    "plot.js",
)
needs_node = pytest.mark.skipif(NODE is None, reason="needs node")


def printed(folder, names, *parts):
    """Return what scripts of the page print in node, as JSON: those of these names, and the parts behind them."""
    templates = resources.files("bristle.apps.lab").joinpath("templates")
    texts = [templates.joinpath(name).read_text(encoding="utf-8") for name in names]
    (folder / "run.js").write_text("\n".join([*texts, *parts]), encoding="utf-8")
    ran = subprocess.run(
        [NODE, str(folder / "run.js")], capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


def node(folder, models, script):
    """Return what a script prints, as JSON; `models` are those of the page, `say` prints."""
    values = f"const models = {json.dumps(models)};\nconst say = (v) => console.log(JSON.stringify(v));\n"
    return printed(folder, NAMES, values, f"(async () => {{\n{script}\n}})();")


def data_of(page):
    """Return the data of a page as its scripts read it."""
    data = json.loads(
        re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1]
    )
    return json.loads(unpacked(data["code"]))
