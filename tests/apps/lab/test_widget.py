"""The widget: values go both ways, in Python and in a browser; its script computes the bits of Python."""

import json
import os
import re
import shutil
import subprocess
import sys
import time

import pytest
from tests.apps.lab.browser import awaited
from tests.report.known import columns

import bristle as br
from bristle.apps.lab import Widget
from bristle.apps.targets.page import described, packing
from bristle.core.errors import InputError, MissingExtraError


@pytest.fixture
def lugre():
    return br.friction.lugre(F_C="20 N", F_S="28 N", v_S="2 mm/s", sigma_0="10 N/um")


def come(widget, **values):
    """Hand values to a widget as a page does."""
    widget.set_state({"_values": widget._values | values})


def test_slider_and_python_set_each_other(lugre):
    widget, seen = Widget(lugre), []
    widget.observe(lambda change: seen.append(change["new"].F_C), "model")
    assert widget.get_state()["_values"]["v_d"] == ["Infinity"]
    come(widget, F_C=[21.5])
    assert widget.model.F_C == widget.parameters["F_C"] == 21.5
    widget.parameters = {"F_C": "23 N", "v_S": 0.003}
    assert [widget._values[name] for name in ("F_C", "v_S")] == [[23.0], [0.003]]
    widget.model = lugre
    assert widget._values["F_C"] == [20.0]
    assert seen == [21.5, 23.0, 20.0]


def test_a_refused_value_keeps_the_last_valid_model(lugre):
    widget = Widget(lugre)
    come(widget, F_C=[-3.0])
    assert (widget.model, widget._values["F_C"]) == (lugre, [-3.0])
    assert re.search("F_C.*out of range", widget._problem)
    come(widget, F_C=[19.0])
    assert (widget.model.F_C, widget._problem) == (19.0, "")
    with pytest.raises(InputError, match="no such parameter"):
        widget.parameters = {"F_c": 1.0}
    for wrong in (3, br.plants.inertia(M=1.0)):
        with pytest.raises(InputError, match=r"must be a .*friction model"):
            Widget(wrong)
        with pytest.raises(InputError, match=r"must be a .*friction model"):
            widget.model = wrong
    assert widget.model.F_C == 19.0


def test_a_new_model_is_described_again_and_a_new_value_is_not(lugre):
    widget = Widget(lugre, uncertainty={"F_C": {"interval": (19.0, 21.0), "status": "identified"}})
    first = widget._described
    assert next(row["interval"] for row in first["variables"] if row["name"] == "F_C") == [
        19.0,
        21.0,
    ]
    widget.parameters = {"F_C": 22.0}
    assert widget._described is first
    gms = described.example_named("gms")
    widget.model = gms
    assert widget._described["model"] == "gms"
    assert "F_v" not in widget._values or widget._values["nu_i"] == gms.values["nu_i"].tolist()
    come(widget, nu_i=widget._values["nu_i"][::-1])
    assert widget.model.nu_i == pytest.approx(gms.nu_i[::-1])
    json.dumps(widget.get_state()["_described"], allow_nan=False)


@pytest.mark.slow
def test_an_identification_shows_its_model_with_its_intervals():
    identification = br.identify(columns(), "coulomb_viscous", draws=0, blocks=0)
    widget = identification.widget()
    assert widget.model == identification.model
    low, high = next(
        row["interval"] for row in widget._described["variables"] if row["name"] == "F_C"
    )
    assert low < identification.parameters["F_C"].value < high
    assert "<script" not in identification._repr_html_()


def test_without_anywidget_the_install_command_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "anywidget", None)
    monkeypatch.delitem(sys.modules, "bristle.apps.lab.widget")
    with pytest.raises(MissingExtraError, match=r'pip install "bristle\[notebook\]"'):
        br.apps.lab.Widget  # noqa: B018


STUB = """
window.stub = (state) => {
  const heard = {}, saved = [];
  return {
    saved,
    get: (name) => state[name],
    set(name, value) {
      state[name] = value;
      (heard[`change:${name}`] ?? []).forEach((listener) => listener());
    },
    save_changes() { saved.push(structuredClone(state._values)); },
    on(event, listener) { (heard[event] ??= []).push(listener); },
    off(event, listener) { heard[event] = heard[event].filter((each) => each !== listener); },
    listeners: () => Object.values(heard).flat().length,
  };
};
"""
MOUNTED = """
(async () => {
  window.module = await import(URL.createObjectURL(new Blob([esm], { type: "text/javascript" })));
  window.el = document.createElement("div");
  document.body.append(el);
  window.model = stub(state);
  window.gone = await module.default.render({ model, el });
  window.root = el.firstChild.shadowRoot;
  window.still = () => new Promise((done) => setTimeout(done, 150));
  window.drawn = (name) => root.getElementById(name).toDataURL();
  window.field = (name) => root.querySelector(`.card:has([name="${name}"]) input[type=text]`).value;
  await still();
  return await module.walked(proven);
})()
"""
SLIDE = """
(async () => {
  const before = drawn("loop"), slider = root.querySelector('[name="F_S"]');
  slider.value = Number(slider.value) + 200;
  slider.dispatchEvent(new Event("input"));
  await still();
  return [before !== drawn("loop"), model.saved, Number(field("F_S"))];
})()
"""
SET = """
(async () => {
  const before = [drawn("loop"), drawn("speed")];
  model.set("_values", { ...model.get("_values"), F_C: [12.5], sigma_0: [1e6] });
  await still();
  return [before[0] !== drawn("loop"), before[1] !== drawn("speed"), field("F_C"), model.saved.length];
})()
"""
DARK = """
(async () => {
  const before = drawn("loop"), seen = [];
  for (const isLight of [false, true]) {
    document.body.dataset.jpThemeLight = isLight;
    await still();
    seen.push([getComputedStyle(el.firstChild).colorScheme, before !== drawn("loop")]);
  }
  return seen;
})()
"""
OTHER = """
(async () => {
  model.set("_values", other._values);
  model.set("_described", other._described);
  await still();
  const names = [...root.querySelectorAll(".cards input[type=range]")].map(({ name }) => name);
  model.set("_problem", "F_C: out of range");
  const told = root.querySelector(".problem").textContent;
  gone();
  return [names, told, el.children.length, model.listeners()];
})()
"""


@pytest.mark.slow
@pytest.mark.parametrize("width", [360, 1366])
def test_a_widget_in_a_browser_draws_and_follows_python(lugre, tmp_path, width, shown):
    widget, other = Widget(lugre), Widget(described.example_named("maxwell_slip"))
    synced = ("_values", "_described", "_problem")
    state, rest = ({name: item.get_state()[name] for name in synced} for item in (widget, other))
    page = tmp_path / "notebook.html"
    page.write_text(
        "<!DOCTYPE html><title>a notebook</title><link rel=icon href='data:,'>", encoding="utf-8"
    )
    tab = shown(page.as_uri(), width=width)
    values = {
        "esm": widget._esm,
        "state": state,
        "other": rest,
        "proven": packing.plain(described.model_described(described.example_named("lugre"))),
    }
    for name, value in values.items():
        tab.run(f"window.{name} = {json.dumps(value)}; 0")
    tab.run(STUB + "0")
    assert tab.run(MOUNTED) == {"differ": 0, "of": 21}
    moves, saved, slid = tab.run(SLIDE)
    assert (moves, saved[-1]["F_S"], saved[-1]["v_d"]) == (True, [slid], ["Infinity"])
    come(widget, **saved[-1])
    assert widget.model.F_S == slid > 28.0
    assert tab.run(SET) == [True, True, "12.5", len(saved)]
    assert tab.run("document.documentElement.scrollWidth <= innerWidth")
    assert tab.run(DARK) == [["dark", True], ["light", False]]
    names, *rest = tab.run(OTHER)
    assert "k_i[2]" in names
    assert rest == ["F_C: out of range", 0, 0]
    assert {
        address for address in tab.asked_for() if not address.startswith(("blob:", "data:"))
    } == {page.as_uri()}


# --- The widget in JupyterLab, in a browser: its slider moves the model of Python, and Python moves its slider


JUPYTER = shutil.which("jupyter-lab", path=os.path.dirname(sys.executable))
CELLS = (
    "import bristle as br\nfrom bristle.apps.lab import Widget\n"
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


def cell(source):
    return {
        "cell_type": "code",
        "source": source,
        "metadata": {},
        "outputs": [],
        "execution_count": None,
    }


@pytest.fixture
def server(tmp_path):
    """Give the address of a JupyterLab that has a notebook, and where its files are."""
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    notebook = {
        "cells": list(map(cell, CELLS)),
        "metadata": {"kernelspec": kernel},
        "nbformat": 4,
        "nbformat_minor": 4,
    }
    (tmp_path / "bench.ipynb").write_text(json.dumps(notebook), encoding="utf-8")
    settings = [
        "--ServerApp.port=0",
        "--ServerApp.open_browser=False",
        "--LabApp.expose_app_in_browser=True",
    ]
    environment = os.environ | {
        "JUPYTER_CONFIG_DIR": str(tmp_path / "config"),
        "JUPYTER_RUNTIME_DIR": str(tmp_path),
    }
    command = [JUPYTER, "--allow-root", "--notebook-dir", str(tmp_path), *settings]
    with open(tmp_path / "said.txt", "wb") as text:
        process = subprocess.Popen(command, env=environment, stdout=text, stderr=subprocess.STDOUT)
    try:
        yield _address(tmp_path / "said.txt"), tmp_path
    finally:
        process.terminate()
        process.wait(30)


def _address(message):
    pattern = r"http://127\.0\.0\.1:\d+/lab\?token=\w+"
    return awaited(lambda: re.search(pattern, message.read_text(encoding="utf-8")), 60.0, message)[
        0
    ]


def run_cell(tab, number):
    """Run one cell of the notebook, and wait until it has run."""
    notebook = "window.jupyterapp.shell.currentWidget.content"
    tab.run(f"{notebook}.activeCellIndex = {number}")
    tab.run(f"{COMMANDS}.execute('notebook:run-cell').then(() => true)")


@pytest.mark.slow
@pytest.mark.skipif(JUPYTER is None, reason="needs jupyterlab")
def test_a_widget_in_jupyterlab_works_both_ways(server, shown):
    address, folder = server
    tab = shown(
        address.replace("/lab?", "/lab/tree/bench.ipynb?"), complains=True, width=1400, height=1300
    )
    tab.waits(f"{COMMANDS}.isEnabled('notebook:run-cell')")
    tab.waits(
        "window.jupyterapp.shell.currentWidget.sessionContext.session.kernel.status === 'idle'"
    )
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
