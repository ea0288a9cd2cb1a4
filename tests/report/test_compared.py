"""The result of a comparison: card, data, report and folder."""

import json
import pickle

import pytest
from tests.comparison.machine import log, sine
from tests.report.pages import Page

import bristle as br
from bristle.core.errors import InputError
from bristle.figures import as_csv, numbers_of


@pytest.fixture(scope="module")
def result():
    return br.compare(log(1, sine(9)), log(2, sine(8), gain=0.7, friction=7.0))


def test_card_has_the_verdict_first(result):
    lines = repr(result).splitlines()
    assert len(lines) <= 30
    assert "It helped: the following error is lower." in lines[0]
    assert [line for line in lines if "Friction level" in line and line.endswith("lower")]
    assert "<table>" in result._repr_html_()


def test_comparison_is_plain_data(result):
    message = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    rms = message["following_error"]["rms"]
    assert rms["change"] == pytest.approx(rms["after"] - rms["before"])
    assert rms["interval"][0] < rms["change"] < rms["interval"][1] < 0.0
    assert rms["interval_percent"][0] == pytest.approx(100.0 * rms["interval"][0] / rms["before"])
    assert message["helped"] is True
    assert message["reversals"]["window"] == result.window
    assert message["shared"]["cycles_before"] == 8
    assert [diagnostic["code"] for diagnostic in message["diagnostics"]] == [diagnostic.code for diagnostic in result.diagnostics]


def test_data_frame_has_a_row_for_each_quantity(result):
    frame = result.to_dataframe()
    assert list(frame["quantity"]) == list(result.changes)
    assert ((frame["low"] <= frame["change"]) & (frame["change"] <= frame["high"])).all()
    assert set(frame["unit"]) == {"m", "N"}


def test_small_reduction_hardly_helped():
    message = br.compare(log(1, sine(12), scatter=0.0), log(2, sine(12), scatter=0.0, gain=0.97))
    assert message.changes["following_error.rms"].verdict == "lower"
    assert message.sentences[0] == "It hardly helped: the following error is lower, by less than 5 %."


@pytest.mark.usefixtures("undrawn")
def test_report_of_a_comparison_has_verdict_changes_and_command(result, tmp_path):
    page = Page(result.report(tmp_path / "report.html").read_text(encoding="utf-8"))
    assert not page.unbalanced
    for told in ("It helped", "bristle.compare('before', 'after')", "lower", "95 % interval", "Friction at the same speeds"):
        assert told in page.words


@pytest.mark.slow
@pytest.mark.parametrize("left_out", ["reference", "effort"])
def test_report_without_reference_or_effort_has_a_figure(left_out, tmp_path):
    message = br.compare(log(1, sine(9), **{left_out: None}), log(2, sine(9), **{left_out: None}))
    page = Page(message.report(tmp_path / "report.html").read_text(encoding="utf-8"))
    assert page.named("svg")
    assert not page.unbalanced


def test_comparison_is_saved_once(result, tmp_path):
    folder = result.save(tmp_path / "compared")
    assert json.loads((folder / "summary.json").read_text()) == result.to_dict()
    assert (folder / "report.html").is_file()
    with pytest.raises(InputError):
        result.save(folder)


def test_comparison_survives_pickle(result):
    again = pickle.loads(pickle.dumps(result))
    assert again.to_dict() == result.to_dict()


def test_figure_draws_the_numbers_of_the_changes(result):
    drawn = [as_csv(panel) for panel in numbers_of(result.plot())]
    assert len(drawn) == 6
    rows = [line for line in drawn[-1].splitlines() if ",change,points," in line]
    assert [float(row.split(",")[5]) for row in rows] == pytest.approx([change.change_percent for change in result.changes.values()])
