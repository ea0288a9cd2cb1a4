"""``bristle excite``: from an axis file to a motion, and to what its log would tell."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from tests.cli.conftest import written_in

from bristle.report import excitation as report

AXIS = """
schema = 1
name = "stage"
kind = "translational"

[columns]
time = { column = "t", unit = "s" }
position = { column = "q", unit = "um" }
effort = { column = "u", unit = "N" }

[effort]
limit = "700 N"

[plant]
mass = "28 kg"
presliding = "7 um"

[encoder]
resolution = "0.05 um"

[timing]
sample_time = "2 ms"

[limits]
velocity = "100 mm/s"
acceleration = "2 m/s^2"
stroke = ["-50 mm", "50 mm"]
"""


@pytest.fixture
def drawn(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("axis.toml").write_text(AXIS)
    return tmp_path


@pytest.fixture
def folder(drawn, undrawn):
    return drawn


@pytest.mark.slow
def test_a_motion_is_written_with_the_intervals_that_its_log_would_give(bristle, drawn):
    result = bristle("excite", "axis.toml", "--out", "motion", "--duration", "16 s", "--for", "stribeck", "--json")
    assert result.code == 0
    assert written_in(drawn / "motion") == {"motion.csv", "moves.csv", "motion.nc", "axis.toml", "summary.json", "report.html"}
    table = np.loadtxt("motion/motion.csv", delimiter=",", skiprows=1)
    assert Path("motion/motion.csv").read_text().splitlines()[0].startswith("t [s],q [um],velocity [um/s],")
    assert np.abs(table[:, 1]).max() <= 50_000.0
    assert table[-1, 0] == pytest.approx(result.data["motion"]["duration"], abs=0.003)
    assert result.data["parameters"]["F_C"]["status"] == "identified"
    assert abs(result.data["parameters"]["F_C"]["error_percent"]) < 10.0
    assert result.data["identify"].split()[:4] == ["bristle", "identify", "LOG", "--axis"]
    assert [item["purpose"] for item in result.data["pieces"]] == ["stribeck"] * 10
    again = bristle("excite", "axis.toml", "--out", "motion", "--duration", "16 s", "--for", "stribeck")
    assert again.code == 2
    assert "--force" in again.err
    replaced = bristle("excite", "axis.toml", "--out", "motion", "--duration", "16 s", "--for", "stribeck", "--force", "--format", "svg")
    assert replaced.code == 0
    assert {item.name for item in Path("motion/figures").glob("*.svg")} == {"motion.svg", "expected.svg"}
    assert "constant velocity" in replaced.out
    assert "Verdict: Run it" in replaced.out


@pytest.fixture
def log(folder):
    """A log of the axis: a swing with the inertia of its mass and with Coulomb friction of 50 N."""
    time = 2e-3 * np.arange(2000)
    phase = 2.0 * np.pi * time
    effort = -28.0 * 0.02 * (2.0 * np.pi) ** 2 * np.sin(phase) + 50.0 * np.tanh(200.0 * np.cos(phase))
    columns = np.column_stack([time, 1e6 * 0.02 * np.sin(phase), effort])
    np.savetxt("log.csv", columns, delimiter=",", header="t,q,u", comments="")
    return folder / "log.csv"


@pytest.mark.slow
def test_a_log_gives_the_friction_of_the_rehearsal(bristle, log, monkeypatch):
    monkeypatch.setattr(report, "excite", partial(report.excite, draws=0))
    measured = bristle("excite", "axis.toml", "--log", "log.csv", "--duration", "10 s", "--for", "stribeck", "--json")
    assert measured.code == 0
    assert measured.data["assumed"] == []
    assert measured.data["model"] == "dahl"
    assert measured.data["parameters"]["F_C"]["put_in"] == pytest.approx(50.0, rel=0.1)
    assert measured.data["provenance"]["log"] == "log.csv"
