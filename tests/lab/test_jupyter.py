"""The widget in JupyterLab, in a browser: its slider moves the model of Python, and Python moves its slider."""

import json
import os
import re
import shutil
import subprocess
import sys
import time

import pytest

JUPYTER = shutil.which("jupyter-lab", path=os.path.dirname(sys.executable))
CELLS = (
    "import bristle as br\nfrom bristle.lab import Widget\n"
    'widget = Widget(br.friction.lugre(F_C="20 N", F_S="28 N", v_S="2 mm/s", sigma_0="10 N/um"))\nwidget',
    'open("from_slider.txt", "w").write(str(widget.model.F_C))',
    'widget.parameters = {"F_C": "23 N"}',
)
# The widget's root is closed off in the page: nothing in a document finds what is in a shadow but through its host.
HOST = "[...document.querySelectorAll('*')].find((each) => each.shadowRoot?.getElementById('loop'))"
SLIDER = f"{HOST}.shadowRoot.querySelector('input[type=range][name=F_C]')"
FIELD = f"{SLIDER}.closest('.card').querySelector('.number input')"
DRAWN = (
    f"(() => {{ const canvas = {HOST}?.shadowRoot.getElementById('loop');"
    " if (!canvas?.width) return 0;"
    " const points = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;"
    " return new Set(new Uint32Array(points.buffer)).size; })()"
)
COMMANDS = "window.jupyterapp.commands"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(JUPYTER is None, reason="needs jupyterlab"),
    pytest.mark.skipif(shutil.which("chromium") is None, reason="needs chromium"),
]


def cell(source):
    return {"cell_type": "code", "source": source, "metadata": {}, "outputs": [], "execution_count": None}


@pytest.fixture
def server(tmp_path):
    """Give the address of a JupyterLab that has a notebook, and where its files are."""
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    notebook = {"cells": list(map(cell, CELLS)), "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 4}
    (tmp_path / "bench.ipynb").write_text(json.dumps(notebook), encoding="utf-8")
    settings = ["--ServerApp.port=0", "--ServerApp.open_browser=False", "--LabApp.expose_app_in_browser=True"]
    environment = os.environ | {"JUPYTER_CONFIG_DIR": str(tmp_path / "config"), "JUPYTER_RUNTIME_DIR": str(tmp_path)}
    command = [JUPYTER, "--allow-root", "--notebook-dir", str(tmp_path), *settings]
    with open(tmp_path / "said.txt", "wb") as text:
        process = subprocess.Popen(command, env=environment, stdout=text, stderr=subprocess.STDOUT)
    try:
        yield _address(process, tmp_path / "said.txt"), tmp_path
    finally:
        process.terminate()
        process.wait(30)


def _address(process, message):
    until = time.monotonic() + 60.0
    while time.monotonic() < until:
        text = message.read_text(encoding="utf-8")
        address = re.search(r"http://127\.0\.0\.1:\d+/lab\?token=\w+", text)
        if address:
            return address[0]
        assert process.poll() is None, text
        time.sleep(0.2)
    raise AssertionError(message.read_text(encoding="utf-8"))


def run_cell(tab, number):
    """Run one cell of the notebook, and wait until it has run."""
    notebook = "window.jupyterapp.shell.currentWidget.content"
    tab.run(f"{notebook}.activeCellIndex = {number}")
    tab.run(f"{COMMANDS}.execute('notebook:run-cell').then(() => true)")


def test_a_widget_in_jupyterlab_works_both_ways(server, shown):
    address, folder = server
    tab = shown(address.replace("/lab?", "/lab/tree/bench.ipynb?"), complains=True, width=1400, height=1300)
    tab.waits(f"{COMMANDS}.isEnabled('notebook:run-cell')")
    tab.waits("window.jupyterapp.shell.currentWidget.sessionContext.session.kernel.status === 'idle'")
    run_cell(tab, 0)
    assert tab.waits(f"{DRAWN} > 20 && {DRAWN}") > 20
    assert float(tab.run(f"{FIELD}.value")) == 20.0
    tab.run(f"{SLIDER}.value = 900")
    tab.run(f"{SLIDER}.dispatchEvent(new Event('input', {{ bubbles: true }}))")
    value = float(tab.waits(f"{FIELD}.value !== '20' && {FIELD}.value"))
    time.sleep(1.0)
    run_cell(tab, 1)
    from_slider = float((folder / "from_slider.txt").read_text(encoding="utf-8"))
    assert from_slider == pytest.approx(value, rel=1e-3)
    assert from_slider != 20.0
    run_cell(tab, 2)
    assert float(tab.waits(f"{FIELD}.value === '23' && {FIELD}.value")) == 23.0
