"""Models from components and values: what is missing, unknown or out of range is named with its place."""

from dataclasses import replace
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from bristle import friction, hysteresis, plants, sensors
from bristle.core.contracts import Component, HysteresisOperator, example_of, make_model
from bristle.core.errors import InputError
from bristle.core.read_only import ReadOnly
from bristle.core.variable import Variable

STRIBECK = {"F_C": 8.0, "F_S": 11.0, "v_S": 4e-3, "F_v": 30.0}


def made(values=None, component=friction.stribeck, **options):
    return make_model(
        component,
        STRIBECK if values is None else values,
        **{"kind": None, "validate": True} | options,
    )


@pytest.mark.parametrize("path", ["", "friction"])
@pytest.mark.parametrize(
    ("changes", "options", "place"),
    [
        *(
            ({name: value}, {}, ".F_C")
            for name, value in (("F_C", -1.0), ("F_C", np.nan), ("F_C", "8 kg"))
        ),
        ({"F_X": 1.0}, {}, ".F_X"),
        ({"F_S": 7.0}, {}, ""),
        ({}, {"kind": "magnetic"}, ".kind"),
        ({}, {"validate": 1}, ".validate"),
    ],
)
def test_errors_include_the_path_of_the_model(path, changes, options, place):
    with pytest.raises(InputError) as reported:
        made(STRIBECK | changes, path=path, **options)
    assert reported.value.path == (f"{path}{place}".lstrip(".") or "stribeck")


OPERATOR = hysteresis.prandtl_ishlinskii(thresholds=[0.0, 1e-6], weights=[1e6, 1e6])
PREISACH = {
    "F_C": 20.0,
    "F_S": 28.0,
    "v_S": 2e-3,
    "kernel": hysteresis.preisach(s=1e7, f_p=40.0, kind="translational"),
}
UNEQUAL = {"F_C": 1.0, "k_i": [1.0, 2.0], "nu_i": [1.0]}


@pytest.mark.parametrize(
    ("component", "values", "options", "words"),
    [
        (
            friction.stribeck,
            {"F_C": 8.0, "F_S": 11.0},
            {},
            r"^stribeck: stribeck needs v_S.*Give v_S \(.*\[m/s\]",
        ),
        (friction.stribeck, {"F_C": 8.0, "F_S": 11.0}, {"kind": "rotational"}, r"\[rad/s\]"),
        (friction.stribeck, STRIBECK, {"kind": "magnetic"}, "allowed translational or rotational"),
        (
            friction.coulomb,
            {"F_C": 1.0, "kernel": OPERATOR},
            {},
            "the friction model has no kernel that an operator can replace",
        ),
        (
            friction.preisach_lugre,
            {"kernel": OPERATOR},
            {"kind": "rotational"},
            "is a translational operator, but this",
        ),
        (
            friction.preisach_lugre,
            PREISACH | {"s": 1e6},
            {},
            r"s: is already set by the operator; found 1000000\.0.*Remove s",
        ),
        (friction.maxwell_slip, UNEQUAL, {"validate": False}, "k_i"),
        (friction.maxwell_slip, UNEQUAL, {"related": False}, "k_i"),
        (
            friction.maxwell_slip,
            {"F_C": 1.0, "k_i": np.array([1.0, -2.0]), "nu_i": np.array([0.5, 0.5])},
            {},
            r"k_i\[1\]: out of range",
        ),
        (
            friction.maxwell_slip,
            {"F_C": 1.0, "k_i": np.array([1.0]), "nu_i": np.array([1.5])},
            {},
            r"nu_i\[0\]: out of range",
        ),
    ],
)
def test_values_that_make_no_model_are_refused_in_words(component, values, options, words):
    with pytest.raises(InputError, match=words):
        made(values, component=component, **options)


@pytest.mark.parametrize(
    ("model", "kind"),
    [
        (made(), "translational"),
        (made(STRIBECK | {"F_C": "8 N*m"}), "rotational"),
        (made(kind="rotational"), "rotational"),
        (made().with_values(F_C=8.5), "translational"),
        (make_model(hysteresis.play, {"r": 1.0}, kind="magnetic", validate=True), "magnetic"),
    ],
)
def test_the_kind_of_axis_is_given_or_follows_from_units(model, kind):
    assert model.kind == kind


@pytest.mark.parametrize(
    ("name", "value", "options"),
    [
        ("F_S", 7.0, {"validate": False}),
        ("F_S", 7.0, {"related": False}),
        ("F_C", -1.0, {"validate": False}),
    ],
)
def test_without_a_check_ranges_and_relations_are_left(name, value, options):
    assert made(STRIBECK | {name: value}, **options).values[name] == value


@pytest.mark.parametrize("other", [made(STRIBECK | {"F_C": 8.5}), made(kind="rotational"), 3])
def test_models_are_equal_where_component_kind_and_numbers_are(other):
    assert (made() == made(), hash(made()) == hash(made()), made() == other) == (True, True, False)


def test_a_model_with_another_value_is_shown_with_it():
    assert made().with_values(F_C=8.5) == made(STRIBECK | {"F_C": 8.5})
    assert repr(friction.coulomb(F_C=2.0)).startswith("coulomb(F_C=2 N")


@pytest.mark.parametrize(
    "component", [friction.gms, plants.inertia, sensors.encoder, friction.coulomb]
)
def test_an_example_is_a_valid_model(component):
    model = example_of(component)
    assert model.component is component
    for name, variable in component.variables.items():
        assert np.all(np.asarray(model.values[name], dtype=float) >= variable.min)
        assert np.all(np.asarray(model.values[name], dtype=float) <= variable.max)


def test_memory_begins_empty():
    model = example_of(friction.gms)
    memory = friction.gms.new_memory(model.parameters)
    assert memory.size == friction.gms.memory_size(model.parameters) > 0
    assert not memory.any()
    assert friction.coulomb.new_memory(None).size == 0


def test_a_component_knows_its_module_and_its_example_is_read_only():
    made = replace(friction.coulomb, module="", example={"F_C": 3.0})
    assert (
        made.module == friction.coulomb.Parameters.__module__ == "bristle.models.friction.coulomb"
    )
    assert replace(friction.coulomb, module="elsewhere").module == "elsewhere"
    assert isinstance(made.example, ReadOnly)
    assert example_of(made).values["F_C"] == 3.0


def test_an_operator_without_memory_has_an_empty_memory():
    part = hysteresis.stop
    bare = HysteresisOperator(
        name="bare",
        description="none",
        Parameters=part.Parameters,
        State=part.State,
        trial=part.trial,
        commit=part.commit,
    )
    assert bare.new_memory(None).shape == (0,)
    assert (bare.input, bare.output, bare.measure) == ("length", "force", None)


class Given(NamedTuple):
    few: Annotated[float, Variable("1", "below its typical size", max=0.5)]
    many: Annotated[float, Variable("1", "above its typical size", min=3.0)]
    usual: Annotated[float, Variable("1", "of its typical size", nominal=7.0)]
    listed: Annotated[np.ndarray, Variable("1", "several", nominal=4.0)]
    left: Annotated[float, Variable("1", "by default", nominal=9.0)] = 2.0


def test_default_examples_are_nominal_and_within_the_range():
    values = example_of(
        Component(name="given", description="of no use", Parameters=Given, State=Given)
    ).values
    assert (
        values["few"],
        values["many"],
        values["usual"],
        values["listed"].tolist(),
        values["left"],
    ) == (0.5, 3.0, 7.0, [4.0], 2.0)


def test_an_operator_gives_its_values_and_its_kind():
    model = made(PREISACH, component=friction.preisach_lugre)
    assert (model.s, model.f_p, model.kind) == (1e7, 40.0, "translational")
