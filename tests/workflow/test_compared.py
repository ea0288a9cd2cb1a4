"""A comparison in the hand: what it shows, tells and writes."""

import json
import pickle

import pytest
from tests.comparison.machine import log, sine
from tests.report.pages import Page

import bristle as br
from bristle.core.errors import InputError
from bristle.figures import as_csv, numbers_of


@pytest.fixture(scope="module")
def found():
    return br.compare(log(1, sine(9)), log(2, sine(8), gain=0.7, friction=7.0))


def test_it_is_shown_in_a_few_lines_with_the_answer_first(found):
    lines = repr(found).splitlines()
    assert len(lines) <= 30
    assert "It helped: the following error is lower." in lines[0]
    assert [line for line in lines if "Friction level" in line and line.endswith("lower")]
    assert "<table>" in found._repr_html_()


def test_its_numbers_are_plain_data(found):
    told = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    rms = told["following_error"]["rms"]
    assert rms["change"] == pytest.approx(rms["after"] - rms["before"])
    assert rms["interval"][0] < rms["change"] < rms["interval"][1] < 0.0
    assert rms["interval_percent"][0] == pytest.approx(100.0 * rms["interval"][0] / rms["before"])
    assert told["helped"] is True
    assert told["reversals"]["window"] == found.window
    assert told["shared"]["cycles_before"] == 8
    assert [one["code"] for one in told["diagnostics"]] == [one.code for one in found.diagnostics]


def test_a_data_frame_has_a_row_for_each_quantity(found):
    frame = found.to_dataframe()
    assert list(frame["quantity"]) == list(found.changes)
    assert (frame["low"] <= frame["change"]).all()
    assert (frame["change"] <= frame["high"]).all()
    assert set(frame["unit"]) == {"m", "N"}


def test_what_is_less_by_less_than_anybody_minds_helped_hardly():
    told = br.compare(log(1, sine(12), scatter=0.0), log(2, sine(12), scatter=0.0, gain=0.97))
    assert told.changes["following_error.rms"].verdict == "lower"
    assert told.sentences[0] == "It hardly helped: the following error is lower, by less than 5 %."


def test_the_report_is_one_page_with_a_figure(found, tmp_path):
    page = Page(found.report(tmp_path / "report.html").read_text(encoding="utf-8"))
    assert not page.unbalanced
    assert page.named("svg")
    assert "It helped" in page.words
    assert "bristle.compare('before', 'after')" in page.words
    for change in ("lower", "95 % interval", "Friction at the same speeds"):
        assert change in page.words


def test_a_report_without_reference_or_effort_has_its_figure_too(tmp_path):
    pairs = ({"reference": None}, {"effort": None})
    for number, left_out in enumerate(pairs):
        told = br.compare(log(1, sine(9), **left_out), log(2, sine(9), **left_out))
        assert not Page(told.report(tmp_path / f"{number}.html").read_text(encoding="utf-8")).unbalanced


def test_it_is_kept_in_a_folder_once(found, tmp_path):
    folder = found.save(tmp_path / "compared")
    assert json.loads((folder / "summary.json").read_text()) == found.to_dict()
    assert (folder / "report.html").is_file()
    with pytest.raises(InputError):
        found.save(folder)


def test_it_travels(found):
    again = pickle.loads(pickle.dumps(found))
    assert again.to_dict() == found.to_dict()


def test_the_numbers_that_the_figure_draws_are_those_of_the_changes(found):
    drawn = [as_csv(panel) for panel in numbers_of(found.plot())]
    assert len(drawn) == 6
    rows = [line for line in drawn[-1].splitlines() if ",change,points," in line]
    assert [float(row.split(",")[5]) for row in rows] == pytest.approx([change.change_percent for change in found.changes.values()])
