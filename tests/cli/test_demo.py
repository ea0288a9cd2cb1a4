"""``bristle demo``: the main job, start to finish, openly on a simulated axis."""

import json
import os
import re
import signal
from pathlib import Path

import pytest
from tests.cli.conftest import written_in
from tests.docs.conftest import ROOT

from bristle.core.diagnostic import BestSoFar
from bristle.files.results import results_folder


@pytest.mark.slow
def test_the_main_job_from_one_command(bristle, here):
    shown = bristle("demo")
    assert shown.code == 0
    assert "simulated" in shown.out
    assert "bristle identify YOUR.csv" in shown.out
    folder = Path("bristle-demo")
    assert written_in(folder) == {
        "axis.toml",
        "log.csv",
        "unseen.csv",
        "model.toml",
        "summary.json",
        "report.html",
        "drive_table.csv",
        "friction_curve.csv",
        "draws.parquet",
        "traces.parquet",
        "experiment.toml",
        "loop.csv",
    }
    assert "A simulated axis." in (folder / "report.html").read_text()
    assert json.loads((folder / "summary.json").read_text())["simulated"] is True
    assert "passive" in json.loads((folder / "summary.json").read_text())["certificates"]
    assert "Certificates of" in (folder / "report.html").read_text()

    # What the page on compensation tells of it is what it found.
    page = (ROOT / "docs" / "theory" / "compensation.md").read_text().replace("\n", " ")
    message = re.search(r"`bristle demo`.*?from ([\d.]+) mm as recorded to ([\d.]+) µm with .*?, and to ([\d.]+) µm", page)
    loops = json.loads((folder / "summary.json").read_text())["compensation"]
    result = [loops[name]["following_error"]["peak_to_peak"] for name in ("as_recorded", "feedforward", "compensated")]
    assert result == pytest.approx([1e-3 * float(message[1]), 1e-6 * float(message[2]), 1e-6 * float(message[3])], rel=0.02)

    # What it wrote serves the other commands, and they agree with it.
    draws = json.loads((folder / "summary.json").read_text())["resampling"]["draws"]
    again = bristle("identify", folder / "log.csv", "--axis", folder / "axis.toml", "--draws", str(draws), "--json").data
    values, values_again = (
        {model["name"]: {name: parameter["value"] for name, parameter in model["parameters"].items()} for model in summary["models"]}
        for summary in (json.loads((folder / "summary.json").read_text()), again)
    )
    assert values == values_again
    predicted = bristle(
        "predict", folder / "model.toml", folder / "unseen.csv", "--axis", folder / "axis.toml", "--mode", "closed-loop", "--json"
    )
    summary = json.loads((folder / "summary.json").read_text())
    assert predicted.data["metrics"] == summary["prediction"]["metrics"]


def test_a_place_that_was_named_is_kept_without_force(bristle, here):
    with results_folder("mine") as folder:
        folder.write("summary.json", "{}")
    ended = bristle("demo", "--out", "mine")
    assert ended.code == 2
    assert "--force" in ended.err
    assert (here / "mine" / "summary.json").read_text() == "{}"


@pytest.mark.slow
def test_an_interruption_of_its_identification_ends_it(bristle, here, monkeypatch):
    def interrupted(*values):
        os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(BestSoFar, "see", interrupted)
    outside = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        ended = bristle("demo")
    finally:
        signal.signal(signal.SIGTERM, outside)
    assert (ended.code, list(here.iterdir())) == (143, [])
