"""``bristle log``: what is in a log, and every problem."""

from pathlib import Path

import numpy as np
import pytest
from tests.cli.conftest import written_in
from tests.logs.exports import EXPORTS, motion

from bristle.logs import readers

pytestmark = pytest.mark.usefixtures("undrawn")


def test_tables_for_people(bristle, place):
    result = bristle("log", "log.csv", "--axis", "axis.toml", code=0, shown=("position", "1000 samples a second", "Motion of the log"))
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
def test_a_log_is_read_once_for_its_axis_its_numbers_and_its_report(bristle, place, monkeypatch, axis):
    read, kinds = readers._read, []
    monkeypatch.setattr(readers, "_read", lambda kind, *rest: kinds.append(kind.name) or read(kind, *rest))
    assert bristle("log", "log.csv", *axis, "--out", "contents").code == 0
    assert kinds == ["csv"]
    assert written_in("contents") == {"summary.json", "report.html"}
    page = Path("contents/report.html").read_text()
    assert "Contents" in page
    assert "<svg" in page


def test_contradictions_in_a_log_are_reported(bristle, place):
    Path("axis.toml").write_text(Path("axis.toml").read_text().replace('column = "u"', 'column = "u", sign = -1'))
    shown = bristle("log", "log.csv", "--axis", "axis.toml", code=0, shown="(sign_reversed)")
    assert "the sign of the effort seems reversed" in " ".join(shown.out.lower().split())


@pytest.mark.parametrize("name", ["twincat, full", "records", "drive, German"])
def test_a_log_of_another_program_needs_two_values_at_most(bristle, here, name):
    export = EXPORTS[name]
    path = export.write(here, motion()).name
    result = bristle("log", path, "--write", "axis.toml", "--json", code=0)
    assert result.data["proposal"]["missing"] == [*export.filled]
    assert [f"bristle: fill in: {key}" in result.err for key in export.filled] == [True] * len(export.filled)
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
    bristle("log", "noise.csv", "--write", "axis.toml", code=1, said="has no column with a usual name of a position")
    assert not Path("axis.toml").exists()


@pytest.fixture
def nameless(tmp_path, monkeypatch):
    """Write a log of two joints without names: time, both angles, both efforts."""
    monkeypatch.chdir(tmp_path)
    t = 2e-3 * np.arange(4000)
    angles = [np.sin(0.9 * t) + 0.4 * np.sin(2.3 * t), 0.7 * np.sin(1.4 * t + 1.0) + 0.3 * np.sin(3.1 * t)]
    efforts = [np.sign(np.gradient(q)) + 3.0 * np.sin(q) + 0.01 * np.random.default_rng(0).normal(size=t.size) for q in angles]
    np.savetxt("arm.txt", np.column_stack([t, *angles, *efforts]), fmt="%.7f")


def test_columns_without_names_get_proposed_roles_and_the_accepted_file_shows_every_joint(bristle, nameless):
    shown = bristle("log", "arm.txt", "--write", "axis.toml", code=0, shown="Proposed roles")
    assert [f"{role} {joint}" in shown.out for role in ("position", "effort") for joint in (1, 2)] == [True] * 4
    assert "Channels of the axis" not in shown.out
    text = Path("axis.toml").read_text(encoding="utf-8")
    assert bristle("log", "arm.txt", "--axis", "axis.toml").code == 2
    text = text.replace('"?"', '"deg"', 1).replace('"?"', '"N*m"', 1)
    Path("axis.toml").write_text(text, encoding="utf-8")
    accepted = bristle("log", "arm.txt", "--axis", "axis.toml", code=0)
    assert ["Joint joint_1" in accepted.out, "Joint joint_2" in accepted.out] == [True, True]
    assert bristle("log", "arm.txt", "--axis", "axis.toml", "--json").code == 2
    bristle("identify", "arm.txt", "--out", "results", code=2, said="bristle log LOG --write AXIS.toml")
    Path("axis.toml").write_text(text.replace("column_3", "column_9"), encoding="utf-8")
    bristle("log", "arm.txt", "--axis", "axis.toml", code=1, said="problem of joint_2")
