"""``bristle excite``: from an axis file to a motion, and to what its log would tell."""

from pathlib import Path

import numpy as np
import pytest
from tests.cli.conftest import written_in

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


def test_an_axis_file_without_limits_is_refused_with_advice(bristle, folder):
    Path("axis.toml").write_text(AXIS.replace('velocity = "100 mm/s"\n', ""))
    result = bristle("excite", "axis.toml", "--for", "stribeck")
    assert result.code == 2
    assert "Write velocity under [limits]" in result.err
    assert "Traceback" not in result.err


def test_bad_limits_name_their_key(bristle, folder):
    Path("axis.toml").write_text(AXIS.replace('"2 m/s^2"', '"2 m/s"'))
    result = bristle("excite", "axis.toml")
    assert result.code == 2
    assert "limits.acceleration" in result.err
