"""Tables of files: what must stand in them, and what is told where that is missing."""

from pathlib import Path

import pytest

from bristle.core.axis import Axis, Column
from bristle.core.errors import InputError
from bristle.core.variable import Variable
from bristle.files import components
from bristle.files.components import (
    check_keys,
    check_schema,
    choice_at,
    controller_from,
    in_effort,
    key_of,
    kind_at,
    model_from,
    name_of,
    number_at,
    numbers_in,
    open_in,
    refuse_open,
    table_at,
)
from bristle.friction import MODELS

LENGTH = Variable("length", "a way", min=0.0, max=1.0)
VARIABLES = {"lambda_": Variable("1/time", "a slope"), "way": LENGTH, "count": Variable("1", "so many times", min=0.0)}


def refused(call, words):
    with pytest.raises(InputError, match=words):
        call()


def test_keys_are_names_without_the_underscore_of_python():
    assert [key_of(name) for name in ("lambda_", "F_C", "x_", "_")] == ["lambda", "F_C", "x_", "_"]


def test_a_table_is_a_table():
    assert table_at({"a": 1}, "x") == {"a": 1}
    refused(lambda: table_at(3, "a.b"), r"a\.b: must be a table; found 3.*Write \[a\.b\] on a separate line")


def test_an_unknown_key_is_refused_with_a_suggestion():
    check_keys({"a": 1}, ("a", "b"), "x")
    refused(
        lambda: check_keys({"durtion": 3}, ("duration", "delay"), "run"),
        r"run\.durtion: unknown key; allowed keys: duration, delay.*'duration'",
    )
    refused(lambda: check_keys({"c": {}}, ("a",), ""), r"^c: unknown key")


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({}, "schema: is missing. Write schema = 1 on the first line"),
        ({"schema": 2}, "schema: is a schema that this version of bristle cannot read; found 2, allowed 1. Update bristle if"),
        ({"schema": "1"}, "schema: is a schema that.*Write schema = 1"),
        ({"schema": True}, "schema: is a schema that.*Write schema = 1"),
        ({"schema": 1.0}, "schema: is a schema that.*Write schema = 1"),
    ],
)
def test_the_schema_is_required_and_checked(data, words):
    refused(lambda: check_schema(data), words)
    check_schema({"schema": 1})


def test_the_name_is_in_the_file_or_is_the_file_name():
    assert name_of({"name": "stage"}, Path("x.toml")) == "stage"
    assert name_of({}, Path("there/x.toml")) == "x"
    refused(lambda: name_of({"name": 3}, Path("x.toml")), "name")


def test_a_model_is_named_and_its_values_are_in_range():
    model = model_from({"model": "coulomb", "F_C": "3 N"}, MODELS, kind="translational", path="friction")
    assert (model.name, model.values["F_C"]) == ("coulomb", 3.0)
    assert model_from({"F_C": 2.0}, MODELS, kind="translational", path="friction", default="coulomb").name == "coulomb"
    for table, words in (
        ({"F_C": 1.0}, r'friction: names no model.*Write model = "\.\.\." under \[friction\]'),
        ({"file": "own.py"}, "friction: names no model.*Name your own law in an experiment file"),
        ({"model": "coulom"}, r"friction\.model: there is no such model; found 'coulom'.*'coulomb'"),
        ({"model": 3}, r"friction\.model: there is no such model"),
        ({"model": "coulomb", "F_C": -1.0}, r"friction\.F_C"),
        ({"model": "coulomb", "F_C": 1.0, "F_v": 1.0}, r"friction\.F_v: unknown key"),
        (3, "friction: must be a table"),
    ):
        refused(lambda table=table: model_from(table, MODELS, kind="translational", path="friction"), words)


def test_a_number_is_in_si_and_in_its_range():
    assert number_at("3 mm", LENGTH, "translational", "x") == pytest.approx(3e-3)
    assert number_at(0.5, LENGTH, "rotational", "x") == 0.5
    for raw in ("-1 mm", 1.5, "3 N", float("nan")):
        refused(lambda raw=raw: number_at(raw, LENGTH, "translational", "x.way"), r"x\.way")


def test_numbers_of_a_table_are_those_that_are_there():
    assert numbers_in({"lambda": 2, "count": 3.0}, VARIABLES, "translational", "x", integers=("count",)) == {"lambda_": 2.0, "count": 3}
    assert isinstance(numbers_in({"count": 3.0}, VARIABLES, "translational", "x", integers=("count",))["count"], int)
    refused(lambda: numbers_in({}, VARIABLES, "translational", "x", needs=("way",)), r"x: needs way. Write way \(a way\) under \[x\]")
    refused(
        lambda: numbers_in({"count": 1.5}, VARIABLES, "translational", "x", integers=("count",)),
        r"x\.count: must be a whole number; found 1\.5",
    )
    refused(lambda: numbers_in({"way": 2.0}, VARIABLES, "translational", "x"), r"x\.way")


def test_the_first_choice_is_the_default():
    assert choice_at({}, "side", ("motor", "load"), "sensor", "no such side") == "motor"
    assert choice_at({}, "side", ("motor", "load"), "sensor", "no such side", "load") == "load"
    assert choice_at({"side": "load"}, "side", ("motor", "load"), "sensor", "no such side") == "load"
    refused(
        lambda: choice_at({"side": "left"}, "side", ("motor", "load"), "sensor", "no such side"),
        r"sensor\.side: no such side; found 'left', allowed motor or load",
    )


def test_there_are_two_kinds_of_axis():
    assert kind_at("rotational", "kind") == "rotational"
    refused(lambda: kind_at("linear", "kind"), "kind: unknown kind of axis; found 'linear', allowed translational or rotational")


def test_question_marks_are_to_be_filled_in():
    tables = {"a": "?", "b": {"c": 1, "d": {"e": "?"}}, "f": "no ?"}
    assert list(open_in(tables)) == ["a", "b.d.e"]
    refused(
        lambda: refuse_open(tables), r"a: is not filled in; found '\?'.*The comment on this line explains the value. Also fill in b\.d\.e"
    )
    refused(lambda: refuse_open({"a": "?"}), r"The comment on this line explains the value\.?$")
    refuse_open({"a": 1})


# --- control laws ----------------------------------------------------------------------------------------------------


def cascade(kind="translational", axis=None, **values):
    return controller_from({"model": "cascade", "k_p": 10.0} | values, kind=kind, axis=axis, path="controller").values


def test_an_integral_is_given_by_gain_or_time():
    assert cascade(k_v=200.0, T_n="10 ms")["k_i"] == pytest.approx(2e4)
    assert cascade(k_v="0.2 kN*s/m", T_n=0.01)["k_i"] == pytest.approx(2e4)
    assert cascade(k_v=200.0, T_n=0.0)["k_i"] == 0.0
    assert cascade(k_v=200.0, k_i=3.0)["k_i"] == 3.0
    refused(lambda: cascade(k_v=200.0, k_i=3.0, T_n=0.1), r"controller\.T_n: sets the integral gain, but k_i sets it too.*Keep only one")
    refused(lambda: cascade(T_n=0.1), r"controller\.T_n: needs the velocity gain.*Write k_v under \[controller\]")
    refused(lambda: cascade(k_v=200.0, T_n=-0.1), r"controller\.T_n")
    refused(
        lambda: controller_from({"model": "sliding_mode", "T_n": 1.0}, kind="translational", path="controller"),
        r"controller\.T_n: unknown key",
    )
    refused(lambda: cascade(k_v=-200.0), r"controller\.k_v")


AXIS = Axis(kind="translational", columns={"effort": Column("i", "A", "A", -150.0), "position": Column("q", "rad", "rad", 1e-3)})


def test_gains_may_be_in_the_units_of_the_drive():
    # An ampere is 150 N, a radian of the motor a millimetre.
    assert in_effort("2 A*s/m", "force*time/length", "translational", AXIS, "k_v") == pytest.approx(300.0)
    assert in_effort("2 A*s/rad", "force*time/length", "translational", AXIS, "k_v") == pytest.approx(300.0 / 1e-3)
    assert in_effort("2 N*s/rad", "force*time/length", "translational", AXIS, "k_v") == pytest.approx(2.0 / 1e-3)
    assert in_effort("3 A", "force", "translational", AXIS, "limit") == pytest.approx(450.0)
    assert cascade(axis=AXIS, k_v="2 A*s/m")["k_v"] == pytest.approx(300.0)


def test_values_in_si_units_and_without_effort_are_unchanged():
    assert in_effort(3.0, "force", "translational", AXIS, "limit") == 3.0
    assert in_effort("3 kN", "force", "translational", AXIS, "limit") == "3 kN"
    assert in_effort("3 mm", "length", "translational", AXIS, "x") == "3 mm"
    assert in_effort("3", "force", "translational", AXIS, "limit") == "3"
    assert in_effort("3 A", "force", "translational", None, "limit") == "3 A"  # to be refused by its unit


def test_a_name_is_looked_for_among_components():
    assert components.component_named("coulomb", MODELS, "x") is MODELS["coulomb"]
