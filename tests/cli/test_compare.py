"""``bristle compare``: before and after, in the terminal, as JSON and as a report."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from tests.cli.conftest import written_in
from tests.comparison.machine import log, sine

QUIET = ("compare", "before.csv", "after.csv", "--axis", "axis.toml")


def write(name, recorded, columns=("time", "position", "reference", "effort")):
    signals = np.column_stack([getattr(recorded, column).values for column in columns])
    heads = {"time": "t", "position": "q", "reference": "r", "effort": "u"}
    np.savetxt(name, signals, delimiter=",", header=",".join(heads[column] for column in columns), comments="", fmt="%.9g")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Logs from before a change and after it."""
    folder = tmp_path_factory.mktemp("recorded")
    write(folder / "before.csv", log(1, sine(9)))
    write(folder / "after.csv", log(2, sine(9), gain=0.7, friction=7.0))
    return folder


@pytest.fixture
def logs(place, recorded):
    axis = Path("axis.toml").read_text()
    Path("axis.toml").write_text(axis.replace('"100 Hz"', '"25 Hz"').replace('"0.1 um"', '"1 nm"'))
    shutil.copytree(recorded, place, dirs_exist_ok=True)
    return place


def test_the_answer_is_printed_first_and_yes_exits_with_0(bristle, logs):
    result = bristle(*QUIET)
    assert result.code == 0
    assert result.out.startswith("It helped: the following error is lower.")
    assert "Friction level" in result.out
    assert "bristle compared 8 cycles before and 8 after" in " ".join(result.out.split())


def test_no_help_is_the_exit_code_of_no(bristle, logs):
    write("again.csv", log(3, sine(9)))
    result = bristle("compare", "before.csv", "again.csv", "--axis", "axis.toml")
    assert result.code == 1
    assert "do not show" in result.out


def test_results_in_a_folder(bristle, logs, undrawn):
    result = bristle(*QUIET, "--out", "compared")
    assert result.code == 0
    assert written_in("compared") == {"summary.json", "report.html"}
    page = Path("compared/report.html").read_text()
    assert "bristle compare before.csv after.csv --axis axis.toml" in page
    assert "bench: before and after" in page


def test_further_logs_of_a_side(bristle, logs):
    write("more.csv", log(5, sine(5)))
    result = bristle(*QUIET, "--before", "more.csv", "--json")
    assert [item["name"] for item in result.data["logs"]["before"]] == ["before.csv", "more.csv"]
    assert result.data["shared"]["cycles_before"] == 12
    assert result.data["provenance"]["before_2"] == "more.csv"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("compare", "before.csv"), "AFTER"),
        (("compare", "before.csv", "gone.csv", "--axis", "axis.toml"), "gone.csv: there is no such file"),
        (("compare", "before.csv", "before.csv", "--axis", "axis.toml"), "is also the log from before the change"),
        ((*QUIET, "--axis", "axis.toml", "--axis", "axis.toml"), "3 axis files for 2 logs"),
        ((*QUIET, "--format", "png"), "--out"),
        (("compare", "before.csv", "gap.csv", "--axis", "axis.toml"), "gap.csv: column 'u': has NaN"),
    ],
)
def test_incomparable_logs_are_refused_in_one_line(bristle, logs, arguments, words):
    lines = Path("after.csv").read_text().splitlines()
    lines[100] = lines[100].rpartition(",")[0] + ",nan"
    Path("gap.csv").write_text("\n".join(lines))
    result = bristle(*arguments)
    assert result.code == 2
    assert words in result.err
    assert len(result.err.splitlines()) == 1
