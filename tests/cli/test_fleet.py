"""``bristle identify --each``: rows, pages, JSON, exit codes."""

import json

import numpy as np
import pytest
from tests.fleet.conftest import write_log
from tests.report.pages import Page

from bristle.cli.main import main

AXIS = """
schema = 1
name = "press"
kind = "translational"
columns.time = { column = "time", unit = "s" }
columns.position = { column = "position", unit = "m" }
columns.effort = { column = "effort", unit = "N" }
columns.temperature = { column = "temperature", unit = "K" }
plant.mass = "12 kg"
"""
EACH = ("identify", "logs", "--each", "--axis", "axis.toml", "--draws", "0", "--workers", "1")


@pytest.fixture
def at(tmp_path, monkeypatch):
    """A folder with an axis file, a log, and a log that is cut off."""
    (tmp_path / "axis.toml").write_text(AXIS)
    write_log(tmp_path / "logs/left/left_2026-03-01.csv", rows=1500)
    (tmp_path / "logs/left/left_2026-03-17.csv").write_text("time,position\n0.0")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
def test_each_log_is_a_row_and_the_axis_that_differs_is_named(at, capsys):
    rng = np.random.default_rng(8)
    for name in ("left", "right"):
        for day in range(1, 17):
            size = 5.0 * (1.0 + 0.01 * rng.standard_normal()) * (1.2 if name == "right" and day >= 11 else 1.0)
            write_log(at / "logs" / name / f"{name}_2026-03-{day:02d}.csv", size, seed=day, rows=1500)
    assert main([*EACH, "--out", "fleet"]) == 0
    text = capsys.readouterr()
    assert "32 of 33 logs were identified, 1 failed." in text.out
    assert "left_2026-03-17.csv" in text.out
    summary = json.loads((at / "fleet" / "summary.json").read_text())
    assert (summary["logs"], summary["done"], summary["statuses"]) == (33, 33, {"ok": 32, "refused": 1})
    level = summary["parameters"]["friction.F_C"]
    assert level["count"] == 32
    assert level["median"] == pytest.approx(5.0, rel=0.03)
    assert {entry["folder"] for entry in level["apart"]} == {"right"}
    page = Page((at / "fleet" / "report.html").read_text())
    assert page.unbalanced == []
    assert "left_2026-03-17.csv" in page.words
    assert "friction.F_C" in page.words
    named = next(line for line in text.out.splitlines() if line.startswith("Outliers among the logs"))
    assert "from right in friction.F_C" in named
    assert "of left in friction.F_C" not in named


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (EACH, "needs a folder to write into"),
        ((*EACH, "--out", "x", "--force"), "cannot replace the results of --each"),
        ((*EACH, "--out", "x", "--format", "svg"), "with --each, the results have no figures. Read the rows"),
        (("identify", "logs/left/left_2026-03-01.csv", "--workers", "2"), "applies to --each only"),
        (("watch", "fleet", "--out", "watched"), "bristle watch was removed. Use bristle identify LOGS --each"),
    ],
)
def test_conflicting_options_are_refused(at, capsys, options, message):
    assert main([*options]) == 2
    assert message in capsys.readouterr().err


def test_a_fleet_without_a_fitted_log_exits_with_1(at, capsys):
    (at / "logs/left/left_2026-03-01.csv").unlink()
    assert main([*EACH, "--out", "none"]) == 1
    assert "0 of 1 logs were identified, 1 failed." in capsys.readouterr().out


def test_a_broken_link_does_not_end_a_fleet(at, capsys):
    (at / "logs/left/left_2026-03-02.csv").symlink_to(at / "nowhere.csv")
    assert main([*EACH, "--out", "links"]) == 0
    assert "1 of 3 logs were identified, 2 failed." in capsys.readouterr().out
