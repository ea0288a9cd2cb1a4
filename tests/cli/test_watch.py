"""``bristle identify --each`` and ``bristle watch``: rows, pages, JSON, exit codes."""

import json
import re
import shutil

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


@pytest.fixture(scope="module")
def hall(tmp_path_factory):
    """A folder with logs of two axes, one of which changes, and a log that is cut off."""
    folder = tmp_path_factory.mktemp("hall")
    (folder / "axis.toml").write_text(AXIS)
    rng = np.random.default_rng(8)
    for name in ("left", "right"):
        for day in range(1, 17):
            size = 5.0 * (1.0 + 0.01 * rng.standard_normal()) * (1.2 if name == "right" and day >= 11 else 1.0)
            write_log(folder / "logs" / name / f"{name}_2026-03-{day:02d}.csv", size, seed=day, rows=1500)
    (folder / "logs" / "left" / "left_2026-03-17.csv").write_text("time,position\n0.0")
    return folder


@pytest.fixture
def at(hall, monkeypatch):
    monkeypatch.chdir(hall)
    return hall


def test_each_log_is_a_row_and_the_watch_tells_what_changed(at, capsys):
    assert main([*EACH, "--out", "fleet"]) == 0
    said = capsys.readouterr()
    assert "32 of 33 logs were fitted, 1 failed." in said.out
    assert "left_2026-03-17.csv" in said.out
    assert "next: bristle watch fleet" in said.err
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

    assert main(["watch", "fleet", "--out", "watched", "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert told["alarm"] is True
    alarm = told["axes"]["right"]["quantities"]["friction.F_C"]["alarm"]
    assert alarm["onset"] == "2026-03-11"
    assert alarm["course"] == "step"
    assert alarm["change_percent"] == pytest.approx(20.0, abs=3.0)
    assert told["axes"]["left"]["failed"] == 1
    assert all(entry["alarm"] is None for entry in told["axes"]["left"]["quantities"].values())
    page = Page((at / "watched" / "report.html").read_text())
    assert page.unbalanced == []
    assert re.search(r"rose at once: (19|2[01])\b", page.words)
    assert "since 2026-03-11" in page.words
    assert json.loads((at / "watched" / "summary.json").read_text()) == told

    assert main(["watch", "fleet", "--track", "friction.F_v"]) == 0
    assert "None of 2 axes changed, at a rate of 1 in 1000 axis-days" in capsys.readouterr().out
    pattern = "(?P<axis>left)_(?P<date>[-0-9]+)|(?P<rest>right)"
    assert main(["watch", "fleet", "--axis-from", pattern]) == 2
    assert "does not fit the pattern" in capsys.readouterr().err


def test_a_dry_run_tells_what_there_is_and_writes_nothing(at, capsys):
    assert main([*EACH, "--dry-run", "--json"]) == 0
    cost = json.loads(capsys.readouterr().out)
    assert (cost["logs"], cost["with_time"], cost["status"], cost["workers"]) == (33, 33, "ok", 1)
    assert cost["seconds"] == pytest.approx(33 * cost["seconds_per_log"])
    assert not (at / "out").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (EACH, "needs a folder to write into"),
        ((*EACH, "--out", "x", "--force"), "is gone on with, never replaced"),
        ((*EACH, "--out", "x", "--format", "svg"), "a fleet has no figures. Read its rows"),
        (("identify", "logs/left/left_2026-03-01.csv", "--workers", "2"), "is for many logs, each by itself"),
        (("identify", "logs/left/left_2026-03-01.csv", "--dry-run"), "is for many logs, each by itself"),
        (("watch", "."), "holds no fleet"),
        (("watch", "logs"), "holds no fleet"),
        (("watch", "gone"), "there is no such folder"),
    ],
)
def test_what_does_not_go_together_is_refused(at, capsys, monkeypatch, options, message):
    monkeypatch.chdir(at / "logs" / "left") if options[:2] == ("watch", ".") else None
    assert main([*options]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--since", "soon"), "is no date"),
        (("--since", "2026-01-01; rm"), "is no date"),
        (("--false-alarms", "rarely"), "is no rate"),
        (("--false-alarms", "1 in 90000000 days"), "a rate that was not simulated"),
        (("--track", "friction.F_S"), "is no quantity of this fleet"),
    ],
)
def test_what_a_watch_cannot_use_is_refused(at, capsys, options, message):
    main([*EACH, "--out", "fleet"])
    assert main(["watch", "fleet", *options]) == 2
    assert message in capsys.readouterr().err


def test_a_fleet_none_of_whose_logs_is_fitted_ends_with_1(at, capsys):
    (at / "bad").mkdir()
    for day in (1, 2):
        (at / "bad" / f"bad_2026-03-0{day}.csv").write_text("time,position\n0.0")
    assert main(["identify", "bad", *EACH[2:], "--out", "none"]) == 1
    assert "0 of 2 logs were fitted, 2 failed." in capsys.readouterr().out


def test_a_link_to_nowhere_does_not_end_a_fleet(at, capsys):
    (at / "linked").mkdir()
    shutil.copy(next((at / "logs").rglob("*.csv")), at / "linked" / "good_2026-03-01.csv")
    (at / "linked" / "gone_2026-03-02.csv").symlink_to(at / "nowhere.csv")
    assert main(["identify", "linked", *EACH[2:], "--out", "links"]) == 0
    assert "1 of 2 logs were fitted, 1 failed." in capsys.readouterr().out
