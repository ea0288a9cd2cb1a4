"""Names of files and folders: bytes that are no letters are shown escaped, and results name no folders."""

from __future__ import annotations

import json
import os
import shutil
import tomllib
from pathlib import Path

import pytest
from tests.attack.yard import build
from tests.fleet.conftest import write_log

import bristle as br
from bristle.cli.main import main
from bristle.core.typography import escaped, printable
from bristle.logs import read_log

pytestmark = pytest.mark.usefixtures("undrawn")

ODD = os.fsdecode(b"press_\xff")
SHOWN = r"press_\xff"


@pytest.fixture
def odd(tmp_path, monkeypatch):
    """A log of such a name in a folder of such a name."""
    monkeypatch.chdir(tmp_path)
    try:
        write_log(Path(ODD) / f"{ODD}.csv", rows=1500)
    except OSError:
        pytest.skip("this file system takes letters alone")
    return Path(ODD) / f"{ODD}.csv"


def assert_can_be_written(result):
    assert result.code == 0, result.err
    (result.out + result.err).encode()  # no half of a letter among them


def test_a_log_and_its_proposed_axis_file(bristle, odd):
    result = bristle("log", str(odd), "--write", "axis.toml", "--json", "--out", "contents")
    assert_can_be_written(result)
    assert result.data["file"] == f"{SHOWN}.csv"
    text = Path("axis.toml").read_text(encoding="utf-8")
    assert text.startswith(f"# Proposed by bristle from {SHOWN}.csv")
    assert tomllib.loads(text)["name"] == SHOWN
    summary = json.loads(Path("contents/summary.json").read_bytes())
    assert summary["file"] == summary["provenance"]["log"] == f"{SHOWN}.csv"
    assert f"{SHOWN}.csv" in summary["provenance"]["command"]
    assert f"{SHOWN}.csv" in Path("contents/report.html").read_text(encoding="utf-8")


def test_an_identification_without_an_axis_file_writes_files_that_can_be_read(bristle, odd):
    result = bristle("identify", str(odd), "--model", "coulomb_viscous", "--draws", "0", "--out", "results")
    assert_can_be_written(result)
    assert "\\udcff" not in result.out + result.err
    for path in Path("results").glob("*.toml"):
        tomllib.loads(path.read_text(encoding="utf-8"))
    assert SHOWN in Path("results/report.html").read_text(encoding="utf-8")
    assert json.loads(Path("results/summary.json").read_bytes())["provenance"]["log"] == f"{SHOWN}.csv"


def test_a_fleet_continues_with_such_logs(bristle, odd):
    command = ("identify", ODD, "--each", "--draws", "0", "--workers", "1", "--out", "fleet")
    assert_can_be_written(bristle(*command))
    write_log(Path(ODD) / f"second_{ODD}.csv", seed=1, rows=1500)
    again = bristle(*command, "--json")
    assert_can_be_written(again)
    study = json.loads(Path("fleet/study.json").read_bytes())
    assert [(log["folder"], log["log"]) for log in study["logs"]] == [(SHOWN, f"{SHOWN}.csv"), (SHOWN, f"second_{SHOWN}.csv")]


def test_a_log_that_cannot_be_used_is_refused_by_its_escaped_name(bristle, odd):
    odd.write_text("time,position\n0.0")
    bristle("log", str(odd), code=2, said=f"{SHOWN}/{SHOWN}.csv")
    with pytest.raises(br.core.InputError) as caught:
        read_log(odd)
    assert SHOWN in str(caught.value)
    assert str(caught.value).isprintable()


def test_an_axis_file_is_refused_by_its_escaped_name(odd):
    path = Path(f"{ODD}.toml")
    path.write_text("schema = 1\nkind = 3\n")
    with pytest.raises(br.core.InputError, match=r"press_\\xff\.toml"):
        br.read_axis(path)


def test_bytes_that_are_not_letters_are_shown_as_numbers():
    assert escaped(os.fsdecode(b"a\xff\xc3\xa4\n")) == "a\\xff\u00e4\n"
    assert printable(os.fsdecode(b"a\xff\n\x1b")) == "a\\xff  "


# --- results are passed on: they never name the folders in which a person keeps them ---------------------------------


TELLING = "customer_secret"
RESULTS = {
    "identify": "identify {0}/log.csv --axis {0}/axis.toml --model coulomb_viscous --draws 20",
    "identify a model of one's own": "identify {0}/log.csv --axis {0}/axis.toml --model {0}/own.py --draws 0",
    "identify curves": "identify {0}/log.csv --axis {0}/curves.toml",
    "log": "log {0}/log.csv --axis {0}/axis.toml",
    "log with problems": "log {0}/nan.csv --axis {0}/axis.toml",
    "log without a column": "log {0}/nan.csv --axis {0}/bare.toml",
    "predict": "predict {0}/model.toml {0}/log.csv --axis {0}/axis.toml",
    "predict curves": "predict {0}/operator.toml {0}/log.csv --axis {0}/curves.toml",
    "run": "run {0}/experiment.toml",
    "design": "design {0}/experiment.toml",
    "excite": "excite {0}/axis.toml --duration 15s",
    "paper": "paper --figure 1 --from {0}",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("whereabouts") / TELLING / "rig"
    place.mkdir(parents=True)
    build(place)
    rows = (place / "log.csv").read_text().splitlines()
    rows[300] = rows[300].rpartition(",")[0] + ",nan"
    (place / "nan.csv").write_text("\n".join(rows) + "\n")
    (place / "bare.toml").write_text((place / "axis.toml").read_text().replace('column = "u"', 'column = "torque"'))
    return place


LONG = ("identify", "identify a model of one's own", "identify curves", "design", "excite")


@pytest.mark.parametrize("command", [pytest.param(command, marks=pytest.mark.slow if command in LONG else ()) for command in RESULTS])
def test_results_name_no_folder(folder, command, capsys):
    out = folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    assert main([*RESULTS[command].format(folder).split(), "--out", str(out), "--json"]) in (0, 1)
    assert TELLING not in capsys.readouterr().out
    written = [path for path in out.rglob("*") if path.is_file()]
    assert len(written) >= 2
    assert [path.name for path in written if TELLING.encode() in path.read_bytes()] == []


def test_results_of_checks_name_no_folder(folder, capsys):
    for name in ("model.toml", "own.py", "operator.toml"):
        assert main(["check", str(folder / name), "--json"]) in (0, 1)
        assert TELLING not in capsys.readouterr().out


@pytest.mark.slow
def test_terminal_messages_name_the_full_path(folder, capsys):
    shutil.rmtree(folder / "out", ignore_errors=True)
    assert main(["excite", str(folder / "axis.toml"), "--duration", "15s", "--out", str(folder / "out")]) == 0
    assert f"--axis {folder}/out/axis.toml" in capsys.readouterr().out.replace("\n", "")
