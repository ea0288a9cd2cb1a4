"""The note on the source paper runs, two programs agree, and its sentences hold."""

import io
import json
import re
from contextlib import redirect_stdout

import pytest
from tests.docs.conftest import ROOT
from tests.examples.data import values_of

pytestmark = pytest.mark.timeout(3000)

FOLDER = ROOT / "examples" / "source_paper"
NOTE = FOLDER / "note.ipynb"


def cells(kind):
    return [
        "".join(one["source"])
        for one in json.loads(NOTE.read_text(encoding="utf-8"))["cells"]
        if one["cell_type"] == kind
    ]


def test_the_note_is_stripped_and_its_second_program_knows_nothing_of_bristle():
    assert all(
        not one.get("outputs") for one in json.loads(NOTE.read_text(encoding="utf-8"))["cells"]
    )
    assert "bristle" not in re.sub(
        r'""".*?"""', "", (FOLDER / "independent.py").read_text(encoding="utf-8"), flags=re.DOTALL
    )


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """What the note prints, and the folder that it writes."""
    folder, text = tmp_path_factory.mktemp("note"), io.StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(text):
        patch.chdir(folder)
        patch.syspath_prepend(FOLDER)
        values_of(NOTE)
    return text.getvalue(), folder / "source-paper"


@pytest.mark.slow
def test_two_programs_agree(printed):
    rows = re.findall(
        r"^([AC]) (\w+) +bristle +([\d.]+) ± [\d.]+ +second program +([\d.]+).*effort ([\d.]+) and ([\d.]+)",
        printed[0],
        re.M,
    )
    assert [row[:2] for row in rows] == [
        (label, name) for label in "AC" for name in ("none", "printed", "position")
    ]
    for row in rows:
        first, second, effort, other = map(float, row[2:])
        assert second == pytest.approx(first, rel=0.05), row
        assert other == pytest.approx(effort, rel=0.01), row
    errors = {row[:2]: float(row[2]) for row in rows}
    for label in "AC":
        assert errors[label, "printed"] < 0.5 * errors[label, "none"]
    with_limits_of_the_present = float(
        re.search(r"limits of the present direction: ([\d.]+) µm", printed[0])[1]
    )
    assert with_limits_of_the_present < 0.85 * errors["A", "none"]


@pytest.mark.slow
def test_the_compensator_helps_on_rigs_of_another_kind(printed):
    shares = [
        float(one) for one in re.findall(r"error +[\d.]+ um or urad, +([\d.]+) %", printed[0])
    ]
    assert len(shares) == 6
    for none, paper, identified in (shares[:3], shares[3:]):
        assert none == 100.0
        assert paper < 50.0
        assert identified < 0.5 * paper


@pytest.mark.slow
def test_the_figures_and_numbers_of_the_note_are_written(printed):
    assert sorted(path.name for path in printed[1].iterdir()) == [
        "following-error.svg",
        "two-programs.csv",
    ]
    assert len((printed[1] / "two-programs.csv").read_text().splitlines()) == 7
