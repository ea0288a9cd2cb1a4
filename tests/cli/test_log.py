"""``bristle log``: what is in a log, and every problem; names of files and folders, whatever their bytes."""

from __future__ import annotations

import json
import os
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from tests.apps.study.fleet.conftest import write_log
from tests.attack.yard import build
from tests.cli.conftest import written_in
from tests.identification.test_explain import simulated as columns_of, spring
from tests.logs.exports import EXPORTS, motion

import bristle as br
from bristle.cli.main import main
from bristle.core.typography import escaped, printable
from bristle.logs import read_log, readers

pytestmark = pytest.mark.usefixtures("undrawn")


def test_tables_for_people(bristle, place):
    result = bristle(
        "log",
        "log.csv",
        "--axis",
        "axis.toml",
        code=0,
        shown=("position", "1000 samples a second", "Motion of the log"),
    )
    assert "(sign_reversed)" not in result.out


def test_every_problem_is_reported_and_the_exit_code_is_1(bristle, place):
    lines = Path("log.csv").read_text().splitlines()
    for row, column in ((100, 1), (300, 3)):
        cells = lines[row].split(",")
        lines[row] = ",".join([*cells[:column], "nan", *cells[column + 1 :]])
    Path("log.csv").write_text("\n".join(lines))
    result = bristle("log", "log.csv", "--axis", "axis.toml", "--json", "--out", "contents", code=1)
    assert written_in("contents") == {"summary.json"}
    assert len(result.data["problems"]) == 2
    assert result.err.count("bristle: problem: ") == len(result.data["problems"])


def test_control_characters_in_a_name_are_removed(bristle, place):
    text = Path("log.csv").read_text()
    Path("log.csv").write_text(text.replace("t,q,r,u", "t,q,r,\x1b[31m[bold]u", 1))
    result = bristle("log", "log.csv", shown="[bold]u")
    assert "\x1b" not in result.out + result.err


def test_an_unknown_unit_is_shown_as_in_the_file_and_requested(bristle, place):
    text = Path("log.csv").read_text()
    Path("log.csv").write_text(text.replace("t,q,r,u", "t [s],q [Skt],r [Skt],u [N]", 1))
    result = bristle(
        "log",
        "log.csv",
        "--write",
        "proposed.toml",
        "--out",
        "contents",
        code=0,
        said="fill in: columns.position.unit",
        shown="Skt (unknown)",
    )
    assert "Channels of the axis" not in result.out
    assert "report.html" not in result.err
    assert written_in("contents") == {"summary.json"}


@pytest.mark.parametrize("axis", [(), ("--axis", "axis.toml")], ids=["untold", "told"])
def test_a_log_is_read_once_for_its_axis_its_numbers_and_its_report(
    bristle, place, monkeypatch, axis
):
    read, kinds = readers._read, []
    monkeypatch.setattr(
        readers, "_read", lambda kind, *rest: kinds.append(kind.name) or read(kind, *rest)
    )
    assert bristle("log", "log.csv", *axis, "--out", "contents").code == 0
    assert kinds == ["csv"]
    assert written_in("contents") == {"summary.json", "report.html"}
    page = Path("contents/report.html").read_text()
    assert "Contents" in page
    assert "<svg" in page


def test_contradictions_in_a_log_are_reported(bristle, place):
    Path("axis.toml").write_text(
        Path("axis.toml").read_text().replace('column = "u"', 'column = "u", sign = -1')
    )
    shown = bristle("log", "log.csv", "--axis", "axis.toml", code=0, shown="(sign_reversed)")
    assert "the sign of the effort seems reversed" in " ".join(shown.out.lower().split())


@pytest.mark.parametrize("name", ["twincat, full", "records", "drive, German"])
def test_a_log_of_another_program_needs_two_values_at_most(bristle, here, name):
    export = EXPORTS[name]
    path = export.write(here, motion()).name
    result = bristle("log", path, "--write", "axis.toml", "--json", code=0)
    assert result.data["proposal"]["missing"] == [*export.filled]
    assert [f"bristle: fill in: {key}" in result.err for key in export.filled] == [True] * len(
        export.filled
    )
    text = Path("axis.toml").read_text(encoding="utf-8")
    assert text == result.data["proposal"]["text"]
    if export.filled:
        bristle("log", path, "--axis", "axis.toml", code=2, said="is not filled in")
    for value in export.filled.values():
        text = text.replace('"?"', f'"{value}"', 1)
    Path("axis.toml").write_text(text, encoding="utf-8")
    bristle("log", path, "--write", "axis.toml", code=0, said="already exists")
    assert Path("axis.toml").read_text(encoding="utf-8") == text


def test_a_log_without_a_position_column_is_reported(bristle, here):
    rows = np.random.default_rng(1).normal(size=(300, 3))
    np.savetxt("noise.csv", rows, delimiter=",", header="a1,b1,c1", comments="")
    bristle(
        "log",
        "noise.csv",
        "--write",
        "axis.toml",
        code=1,
        said="has no column with a usual name of a position",
    )
    assert not Path("axis.toml").exists()


@pytest.fixture
def nameless(tmp_path, monkeypatch):
    """Write a log of two joints without names: time, both angles, both efforts."""
    monkeypatch.chdir(tmp_path)
    t = 2e-3 * np.arange(4000)
    angles = [
        np.sin(0.9 * t) + 0.4 * np.sin(2.3 * t),
        0.7 * np.sin(1.4 * t + 1.0) + 0.3 * np.sin(3.1 * t),
    ]
    efforts = [
        np.sign(np.gradient(q))
        + 3.0 * np.sin(q)
        + 0.01 * np.random.default_rng(0).normal(size=t.size)
        for q in angles
    ]
    np.savetxt("arm.txt", np.column_stack([t, *angles, *efforts]), fmt="%.7f")


@pytest.mark.slow
def test_columns_without_names_get_proposed_roles_and_the_accepted_file_shows_every_joint(
    bristle, nameless
):
    shown = bristle("log", "arm.txt", "--write", "axis.toml", code=0, shown="Proposed roles")
    assert [
        f"{role} {joint}" in shown.out for role in ("position", "effort") for joint in (1, 2)
    ] == [True] * 4
    assert "Channels of the axis" not in shown.out
    text = Path("axis.toml").read_text(encoding="utf-8")
    assert bristle("log", "arm.txt", "--axis", "axis.toml").code == 2
    text = text.replace('"?"', '"deg"', 1).replace('"?"', '"N*m"', 1)
    Path("axis.toml").write_text(text, encoding="utf-8")
    accepted = bristle("log", "arm.txt", "--axis", "axis.toml", code=0)
    assert ["Joint joint_1" in accepted.out, "Joint joint_2" in accepted.out] == [True, True]
    assert bristle("log", "arm.txt", "--axis", "axis.toml", "--json").code == 2
    bristle(
        "identify", "arm.txt", "--out", "results", code=2, said="bristle log LOG --write AXIS.toml"
    )
    Path("axis.toml").write_text(text.replace("column_3", "column_9"), encoding="utf-8")
    bristle("log", "arm.txt", "--axis", "axis.toml", code=1, said="problem of joint_2")


# --- names of files that are bytes and no letters, and folders that results never name -------------------------------


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
    result = bristle(
        "identify", str(odd), "--model", "coulomb_viscous", "--draws", "0", "--out", "results"
    )
    assert_can_be_written(result)
    assert "\\udcff" not in result.out + result.err
    for path in Path("results").glob("*.toml"):
        tomllib.loads(path.read_text(encoding="utf-8"))
    assert SHOWN in Path("results/report.html").read_text(encoding="utf-8")
    assert (
        json.loads(Path("results/summary.json").read_bytes())["provenance"]["log"] == f"{SHOWN}.csv"
    )


@pytest.mark.slow
def test_a_fleet_continues_with_such_logs(bristle, odd):
    command = ("identify", ODD, "--each", "--draws", "0", "--workers", "1", "--out", "fleet")
    assert_can_be_written(bristle(*command))
    write_log(Path(ODD) / f"second_{ODD}.csv", seed=1, rows=1500)
    again = bristle(*command, "--json")
    assert_can_be_written(again)
    study = json.loads(Path("fleet/study.json").read_bytes())
    assert [(log["folder"], log["log"]) for log in study["logs"]] == [
        (SHOWN, f"{SHOWN}.csv"),
        (SHOWN, f"second_{SHOWN}.csv"),
    ]


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
    (place / "bare.toml").write_text(
        (place / "axis.toml").read_text().replace('column = "u"', 'column = "torque"')
    )
    return place


LONG = ("identify", "identify a model of one's own", "identify curves", "design", "excite")


@pytest.mark.parametrize(
    "command",
    [
        pytest.param(command, marks=pytest.mark.slow if command in LONG else ())
        for command in RESULTS
    ],
)
def test_results_name_no_folder(folder, command, capsys):
    out = folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    assert main([*RESULTS[command].format(folder).split(), "--out", str(out), "--json"]) in (0, 1)
    assert TELLING not in capsys.readouterr().out
    written = [path for path in out.rglob("*") if path.is_file()]
    assert len(written) >= 2
    assert [path.name for path in written if TELLING.encode() in path.read_bytes()] == []


@pytest.mark.slow
def test_results_of_checks_name_no_folder(folder, capsys):
    for name in ("model.toml", "own.py", "operator.toml"):
        assert main(["check", str(folder / name), "--json"]) in (0, 1)
        assert TELLING not in capsys.readouterr().out


@pytest.mark.slow
def test_terminal_messages_name_the_full_path(folder, capsys):
    shutil.rmtree(folder / "out", ignore_errors=True)
    assert (
        main(
            ["excite", str(folder / "axis.toml"), "--duration", "15s", "--out", str(folder / "out")]
        )
        == 0
    )
    assert f"--axis {folder}/out/axis.toml" in capsys.readouterr().out.replace("\n", "")


@pytest.fixture(scope="module")
def sprung(tmp_path_factory):
    """A log of an axis with a spring, as a file."""
    columns = columns_of(12.0, further=spring)
    file = tmp_path_factory.mktemp("sprung") / "sprung.csv"
    table = np.column_stack([columns[name] for name in ("time", "position", "effort")])
    head = "time [s],position [m],effort [N]"
    np.savetxt(file, table, delimiter=",", header=head, comments="", fmt="%.9g")
    return file


def test_explain_prints_the_shares_first_and_the_numbers(bristle, sprung):
    result = bristle("log", str(sprung), "--explain", code=0)
    first = result.out.splitlines()[0]
    assert first.startswith("Effort: ")
    assert "% Coulomb" in first
    assert "% spring" in first
    assert "Coulomb friction, mean over the motion" in result.out


def test_explain_adds_its_keys_to_the_json_and_a_section_to_the_report(bristle, sprung, place):
    result = bristle("log", str(sprung), "--explain", "--json", "--out", "explained", code=0)
    explanation = result.data["explanation"]
    names = {part["name"] for part in explanation["parts"] if part["gain"] is not None}
    assert names == {"spring"}
    assert explanation["numbers"]["F_C"]["value"] == pytest.approx(22.0, rel=0.02)
    assert json.loads(Path("explained/summary.json").read_text())["explanation"] == explanation
    assert 'id="explanation"' in Path("explained/report.html").read_text()


def test_explain_needs_known_units_and_an_effort(bristle, place):
    rows = "\n".join(f"{k / 1e3},{0.1 * np.sin(k / 1e2):.6f}" for k in range(999))
    Path("silent.csv").write_text(f"time [s],position [m]\n{rows}\n")
    bristle("log", "silent.csv", "--explain", code=2, said="has no effort")
    Path("unknown.csv").write_text(f"time [s],position [Skt]\n{rows}\n")
    bristle("log", "unknown.csv", "--explain", code=2, said="--write AXIS.toml")


def test_explain_reports_the_problems_of_a_log_that_it_cannot_explain(bristle, place):
    Path("short.csv").write_text("time [s],position [m],effort [N]\n0,0,1\n0.001,nan,1\n")
    bristle("log", "short.csv", "--explain", code=1, said="problem: ")
