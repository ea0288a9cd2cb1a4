"""Tables of files: what must stand in them, and what is told where that is missing."""

from pathlib import Path

import pytest

from bristle.core.axis import Axis, Column
from bristle.core.errors import InputError
from bristle.core.variable import Variable
from bristle.files.components import (
    check_keys,
    check_schema,
    choice_at,
    component_named,
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
from bristle.models.friction import MODELS

LENGTH = Variable("length", "a way", min=0.0, max=1.0)
VARIABLES = {
    "lambda_": Variable("1/time", "a slope"),
    "way": LENGTH,
    "count": Variable("1", "so many times", min=0.0),
}
# An ampere is 150 N, a radian of the motor a millimetre.
AXIS = Axis(
    kind="translational",
    columns={"effort": Column("i", "A", "A", -150.0), "position": Column("q", "rad", "rad", 1e-3)},
)
SIDES = ("side", ("motor", "load"), "sensor", "no such side")


def model_of(table, **more):
    return model_from(table, MODELS, kind="translational", path="friction", **more)


def numbers_of(table, **more):
    return numbers_in(table, VARIABLES, "translational", "x", **more)


def cascade(axis=None, **values):
    return controller_from(
        {"model": "cascade", "k_p": 10.0} | values,
        kind="translational",
        axis=axis,
        path="controller",
    ).values


@pytest.mark.parametrize(
    ("call", "value"),
    [
        *(
            (lambda name=name: key_of(name), key)
            for name, key in (("lambda_", "lambda"), ("F_C", "F_C"), ("x_", "x_"), ("_", "_"))
        ),
        (lambda: table_at({"a": 1}, "x"), {"a": 1}),
        (lambda: check_keys({"a": 1}, ("a", "b"), "x"), None),
        (lambda: check_schema({"schema": 1}), None),
        (lambda: name_of({"name": "stage"}, Path("x.toml")), "stage"),
        (lambda: name_of({}, Path("there/x.toml")), "x"),
        (lambda: model_of({"model": "coulomb", "F_C": "3 N"}), MODELS["coulomb"](F_C=3.0)),
        (lambda: model_of({"F_C": 2.0}, default="coulomb"), MODELS["coulomb"](F_C=2.0)),
        (lambda: number_at("3 mm", LENGTH, "translational", "x"), pytest.approx(3e-3)),
        (lambda: number_at(0.5, LENGTH, "rotational", "x"), 0.5),
        (
            lambda: numbers_of({"lambda": 2, "count": 3.0}, integers=("count",)),
            {"lambda_": 2.0, "count": 3},
        ),
        (lambda: type(numbers_of({"count": 3.0}, integers=("count",))["count"]), int),
        (lambda: choice_at({}, *SIDES), "motor"),
        (lambda: choice_at({}, *SIDES, "load"), "load"),
        (lambda: choice_at({"side": "load"}, *SIDES), "load"),
        (lambda: kind_at("rotational", "kind"), "rotational"),
        (
            lambda: list(open_in({"a": "?", "b": {"c": 1, "d": {"e": "?"}}, "f": "no ?"})),
            ["a", "b.d.e"],
        ),
        (lambda: refuse_open({"a": 1}), None),
        (lambda: cascade(k_v=200.0, T_n="10 ms")["k_i"], pytest.approx(2e4)),
        (lambda: cascade(k_v="0.2 kN*s/m", T_n=0.01)["k_i"], pytest.approx(2e4)),
        (lambda: cascade(k_v=200.0, T_n=0.0)["k_i"], 0.0),
        (lambda: cascade(k_v=200.0, k_i=3.0)["k_i"], 3.0),
        (lambda: cascade(axis=AXIS, k_v="2 A*s/m")["k_v"], pytest.approx(300.0)),
        (
            lambda: in_effort("2 A*s/m", "force*time/length", "translational", AXIS, "k_v"),
            pytest.approx(300.0),
        ),
        (
            lambda: in_effort("2 A*s/rad", "force*time/length", "translational", AXIS, "k_v"),
            pytest.approx(300.0 / 1e-3),
        ),
        (
            lambda: in_effort("2 N*s/rad", "force*time/length", "translational", AXIS, "k_v"),
            pytest.approx(2.0 / 1e-3),
        ),
        (lambda: in_effort("3 A", "force", "translational", AXIS, "limit"), pytest.approx(450.0)),
        (lambda: in_effort(3.0, "force", "translational", AXIS, "limit"), 3.0),
        (lambda: in_effort("3 kN", "force", "translational", AXIS, "limit"), "3 kN"),
        (lambda: in_effort("3 mm", "length", "translational", AXIS, "x"), "3 mm"),
        (lambda: in_effort("3", "force", "translational", AXIS, "limit"), "3"),
        # To be refused by its unit.
        (lambda: in_effort("3 A", "force", "translational", None, "limit"), "3 A"),
        (lambda: component_named("coulomb", MODELS, "x"), MODELS["coulomb"]),
    ],
)
def test_valid_entries_have_their_values_in_si_or_their_defaults(call, value):
    assert call() == value


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: table_at(3, "a.b"),
            r"a\.b: must be a table; found 3.*Write \[a\.b\] on a separate line",
        ),
        (
            lambda: check_keys({"durtion": 3}, ("duration", "delay"), "run"),
            r"run\.durtion: unknown key; allowed keys: duration, delay.*'duration'",
        ),
        (lambda: check_keys({"c": {}}, ("a",), ""), r"^c: unknown key"),
        (lambda: check_schema({}), "schema: is missing. Write schema = 1 on the first line"),
        (
            lambda: check_schema({"schema": 2}),
            "schema: is a schema that this version of bristle cannot read; found 2, allowed 1. Update bristle if",
        ),
        *(
            (
                lambda value=value: check_schema({"schema": value}),
                "schema: is a schema that.*Write schema = 1",
            )
            for value in ("1", True, 1.0)
        ),
        (lambda: name_of({"name": 3}, Path("x.toml")), "name"),
        (
            lambda: model_of({"F_C": 1.0}),
            r'friction: names no model.*Write model = "\.\.\." under \[friction\]',
        ),
        (
            lambda: model_of({"file": "own.py"}),
            "friction: names no model.*Name your own law in an experiment file",
        ),
        (
            lambda: model_of({"model": "coulom"}),
            r"friction\.model: there is no such model; found 'coulom'.*'coulomb'",
        ),
        (lambda: model_of({"model": 3}), r"friction\.model: there is no such model"),
        (lambda: model_of({"model": "coulomb", "F_C": -1.0}), r"friction\.F_C"),
        (
            lambda: model_of({"model": "coulomb", "F_C": 1.0, "F_v": 1.0}),
            r"friction\.F_v: unknown key",
        ),
        (lambda: model_of(3), "friction: must be a table"),
        *(
            (lambda raw=raw: number_at(raw, LENGTH, "translational", "x.way"), r"x\.way")
            for raw in ("-1 mm", 1.5, "3 N", float("nan"))
        ),
        (lambda: numbers_of({}, needs=("way",)), r"x: needs way. Write way \(a way\) under \[x\]"),
        (
            lambda: numbers_of({"count": 1.5}, integers=("count",)),
            r"x\.count: must be a whole number; found 1\.5",
        ),
        (lambda: numbers_of({"way": 2.0}), r"x\.way"),
        (
            lambda: choice_at({"side": "left"}, *SIDES),
            r"sensor\.side: no such side; found 'left', allowed motor or load",
        ),
        (
            lambda: kind_at("linear", "kind"),
            "kind: unknown kind of axis; found 'linear', allowed translational or rotational",
        ),
        (
            lambda: refuse_open({"a": "?", "b": {"d": {"e": "?"}}}),
            r"a: is not filled in; found '\?'.*The comment on this line explains the value. Also fill in b\.d\.e",
        ),
        (lambda: refuse_open({"a": "?"}), r"The comment on this line explains the value\.?$"),
        (
            lambda: cascade(k_v=200.0, k_i=3.0, T_n=0.1),
            r"controller\.T_n: sets the integral gain, but k_i sets it too.*Keep only one",
        ),
        (
            lambda: cascade(T_n=0.1),
            r"controller\.T_n: needs the velocity gain.*Write k_v under \[controller\]",
        ),
        (lambda: cascade(k_v=200.0, T_n=-0.1), r"controller\.T_n"),
        (
            lambda: controller_from(
                {"model": "sliding_mode", "T_n": 1.0}, kind="translational", path="controller"
            ),
            r"controller\.T_n: unknown key",
        ),
        (lambda: cascade(k_v=-200.0), r"controller\.k_v"),
    ],
)
def test_invalid_entries_are_refused_with_their_place_and_a_remedy(call, words):
    with pytest.raises(InputError, match=words):
        call()
