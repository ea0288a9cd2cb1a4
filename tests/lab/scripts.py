"""The scripts of the page in node, without what draws."""

import json
import re
import shutil
import subprocess
from importlib import resources

import pytest

from bristle.exports.page.packing import unpacked

SLOTS = ("position", "periodic", "load", "temperature", "asymmetry")
NODE = shutil.which("node")
NAMES = ("physics.js", "loop.js", "paths.js", "certificates.js", "controls.js", "slots.js", "plot.js")
needs_node = pytest.mark.skipif(NODE is None, reason="needs node")


def node(folder, models, script):
    """Return what a script prints, as JSON; `models` are those of the page, `say` prints."""
    templates = resources.files("bristle.lab").joinpath("templates")
    parts = [templates.joinpath(name).read_text(encoding="utf-8") for name in NAMES]
    parts.append(f"const models = {json.dumps(models)};\nconst say = (v) => console.log(JSON.stringify(v));\n")
    file = folder / "run.js"
    file.write_text("\n".join([*parts, f"(async () => {{\n{script}\n}})();"]), encoding="utf-8")
    ran = subprocess.run([NODE, str(file)], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


def data_of(page):
    """Return the data of a page as its scripts read it."""
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1])
    return json.loads(unpacked(data["code"]))
