"""The result of a comparison: card, data, report and folder."""

import json
import pickle
from types import SimpleNamespace as Some

import pytest
from tests.comparison.machine import log, sine
from tests.report.pages import Page

import bristle as br
from bristle.comparison import Comparison
from bristle.core.errors import InputError
from bristle.figures import as_csv, numbers_of
from bristle.identification import identify as fitted
from bristle.report import compared
from bristle.report.compared import compared_as
from bristle.report.identified import Outcome, _call, _model_name, signature


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
    assert pickle.loads(pickle.dumps(result)).to_dict() == result.to_dict()


def test_figure_draws_the_numbers_of_the_changes(result):
    drawn = [as_csv(panel) for panel in numbers_of(result.plot())]
    assert len(drawn) == 6
    rows = [line for line in drawn[-1].splitlines() if ",change,points," in line]
    assert [float(row.split(",")[5]) for row in rows] == pytest.approx([change.change_percent for change in result.changes.values()])


# --- The call that repeats a result, with the names of its logs and models, and its options


def log_named(name="", source="<columns>"):
    return Some(origin=Some(name=name), source=Some(name=source))


@pytest.mark.parametrize(
    ("logs", "model", "axes", "options", "call"),
    [
        ([log_named("a.csv")], "lugre", [None], {}, "bristle.identify('a.csv', 'lugre')"),
        (
            [log_named("a.csv"), log_named("b.csv")],
            ["dahl", Some(name="own")],
            [None, 1],
            {},
            "bristle.identify(['a.csv', 'b.csv'], 'dahl,own', axis=axis)",
        ),
        ([log_named()], "lugre", [1], {"draws": 0}, "bristle.identify('columns', 'lugre', axis=axis, draws=0)"),
        ([log_named(source="<>")], "lugre", [None], {"draws": 1000}, "bristle.identify('log', 'lugre')"),
    ],
)
def test_call_of_an_identification_has_the_non_default_options(logs, model, axes, options, call):
    parameters = signature(fitted)
    usual = parameters.parameters["draws"].default
    options = {name: usual if value == 1000 else value for name, value in options.items()}
    assert _call(logs, model, axes, options, parameters) == call


def test_models_have_their_names_in_the_call():
    assert _model_name(("a", Some(name="b"), ["c"])) == "a,b,c"
    assert _model_name(3) == "3"


@pytest.fixture
def sides(monkeypatch):
    """Comparisons of logs that are not read."""
    fields = dict.fromkeys(Comparison.__dataclass_fields__)
    seen = []
    monkeypatch.setattr(compared, "sides_compared", lambda *arguments: seen.append(arguments) or Some(**fields))
    monkeypatch.setattr(compared, "axes_for", lambda axes, count: [*axes, *[axes[-1]] * (count - len(axes))])
    monkeypatch.setattr(compared, "log_and_axis", lambda log, axis: (log, axis))
    return seen


def test_call_of_a_comparison_has_both_sides(sides):
    first, second, third = log_named("a.csv"), log_named("b.csv"), log_named(source="<c.csv>")
    whole = compared_as([first, second], third, axis=Some(name="stage"), window=0.1)
    assert whole.call == "bristle.compare(['a.csv', 'b.csv'], 'c.csv', axis=axis, window=0.1)"
    assert whole.axis_name == "stage"
    before, after, window = sides[0]
    assert ([item for item, _ in before], [item for item, _ in after], window) == ([first, second], [third], 0.1)
    plain = compared_as(first, log_named(source="<>"))
    assert plain.call == "bristle.compare('a.csv', 'after')"
    assert (plain.axis_name, plain.read, plain.figures) == ("columns", {}, ())
    named_call = compared_as(first, third, call="mine", name="press", read={"axis": 1}, figures=[1])
    assert (named_call.call, named_call.axis_name, named_call.read, named_call.figures) == ("mine", "press", {"axis": 1}, (1,))


def test_side_without_a_log_is_refused(sides):
    with pytest.raises(InputError, match="after: names no log"):
        compared_as([log_named()], [])


def test_unreadable_log_names_its_side(sides, monkeypatch):
    def fails(log, axis):
        raise InputError("is wrong", path=log)

    monkeypatch.setattr(compared, "log_and_axis", fails)
    for path, reported in (("log", "before: is wrong"), ("a.csv", "a.csv: is wrong")):
        with pytest.raises(InputError, match=reported):
            compared_as([path], [path])


def test_axis_file_is_written_once(monkeypatch):
    texts = {"a": b"one", "b": b"one", "c": b"two", "d": None}
    monkeypatch.setattr("bristle.report.identified.axis_text", lambda axis, log: texts[axis])
    identification = Some(log=1, further_logs=(2, 3, 4), axes=("a", "b", "c", "d"))
    fields = dict.fromkeys(Outcome.__dataclass_fields__)
    assert Outcome(**fields | {"identification": identification})._axis_texts == (b"one", b"two")
