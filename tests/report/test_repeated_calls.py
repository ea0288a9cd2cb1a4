"""The call that repeats a result, with the names of its logs and models, and its options."""

from types import SimpleNamespace as Some

import pytest

from bristle.comparison import Comparison
from bristle.core import InputError
from bristle.identification import identify as fitted
from bristle.report import compared
from bristle.report.compared import compared_as
from bristle.report.identified import Outcome, _call, _model_name, signature


def log(name="", source="<columns>"):
    return Some(origin=Some(name=name), source=Some(name=source))


@pytest.mark.parametrize(
    ("logs", "model", "axes", "options", "call"),
    [
        ([log("a.csv")], "lugre", [None], {}, "bristle.identify('a.csv', 'lugre')"),
        (
            [log("a.csv"), log("b.csv")],
            ["dahl", Some(name="own")],
            [None, 1],
            {},
            "bristle.identify(['a.csv', 'b.csv'], 'dahl,own', axis=axis)",
        ),
        ([log()], "lugre", [1], {"draws": 0}, "bristle.identify('columns', 'lugre', axis=axis, draws=0)"),
        ([log(source="<>")], "lugre", [None], {"draws": 1000}, "bristle.identify('log', 'lugre')"),
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
    first, second, third = log("a.csv"), log("b.csv"), log(source="<c.csv>")
    whole = compared_as([first, second], third, axis=Some(name="stage"), window=0.1)
    assert whole.call == "bristle.compare(['a.csv', 'b.csv'], 'c.csv', axis=axis, window=0.1)"
    assert whole.axis_name == "stage"
    before, after, window = sides[0]
    assert ([item for item, _ in before], [item for item, _ in after], window) == ([first, second], [third], 0.1)
    plain = compared_as(first, log(source="<>"))
    assert plain.call == "bristle.compare('a.csv', 'after')"
    assert (plain.axis_name, plain.read, plain.figures) == ("columns", {}, ())
    named_call = compared_as(first, third, call="mine", name="press", read={"axis": 1}, figures=[1])
    assert (named_call.call, named_call.axis_name, named_call.read, named_call.figures) == ("mine", "press", {"axis": 1}, (1,))


def test_side_without_a_log_is_refused(sides):
    with pytest.raises(InputError, match="after: names no log"):
        compared_as([log()], [])


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
