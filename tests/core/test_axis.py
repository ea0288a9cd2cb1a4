"""What is known of an axis: what nobody says, what may be said, and what of it tells two axes apart."""

import math

import pytest

from bristle.core.axis import COLUMNS, Axis, Cogging, Column, Injected, KnownColumn
from bristle.core.errors import InputError

# Nothing is known of these until somebody says it; they are positive.
POSITIVE = (
    *(
        "sample_time",
        "mass",
        "resolution",
        "effort_limit",
        "velocity_limit",
        "acceleration_limit",
        "jerk_limit",
    ),
    *("pitch", "arm", "rated", "presliding", "cutoff"),
)
# None, too, may be known of these, and they may be zero.
OF_THE_GROUND = ("stiffness", "damping")


def test_the_default_axis_is_a_driven_mass_with_fitted_efforts():
    axis = Axis()
    assert (axis.name, axis.kind, axis.plant) == ("axis", "translational", "inertia")
    assert (
        axis.columns,
        axis.injected,
        axis.settings,
        axis.cogging,
        axis.regressors,
        axis.text,
    ) == ({}, (), {}, (), (), b"")
    assert (axis.delay, axis.lag, axis.offset, axis.method) == (
        0.0,
        0.0,
        "identify",
        "prediction_error",
    )
    absent = (
        *POSITIVE,
        *OF_THE_GROUND,
        "table",
        "held",
        "hold",
        "periodic",
        "span",
        "stroke",
        "controller",
        "decimation",
        "loop",
    )
    assert [name for name in absent if getattr(axis, name) is not None] == []
    assert axis.seeks_delay
    assert not any((axis.seeks_lag, axis.at_rest, axis.in_cycle, axis.keeps_rests, axis.gravity))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *((name, 1e-9) for name in POSITIVE),
        ("lag", 1e-4),
        ("delay", -1e-4),
        *(("offset", value) for value in (-3.0, 0.0, "identify")),
        ("span", (2.0, math.inf)),
        ("stroke", (-0.1, 0.4)),
        ("decimation", 1),
        ("decimation", 10_000),
        ("cogging", (Cogging("motor", 5e-3),)),
        ("injected", (Injected("a", 1.0),)),
        ("regressors", (KnownColumn("b", "c"),)),
        *(("columns", {name: Column("c", "", "m")}) for name in COLUMNS),
        ("columns", {"humidity": Column("h", "%", "1")}),
        ("columns", {"humidity": Column("h", "", "", shift=1.0)}),
    ],
)
def test_what_may_be_said_of_an_axis_is_taken(name, value):
    assert getattr(Axis(**{name: value}), name) == value


@pytest.mark.parametrize(
    ("place", "words", "values"),
    [
        *(
            (name, None, {name: wrong})
            for name in POSITIVE
            for wrong in (0.0, -1e-9, math.inf, math.nan)
        ),
        *((name, None, {name: -1e-9}) for name in OF_THE_GROUND),
        ("lag", None, {"lag": -1e-4}),
        ("offset", r'allowed "identify", or a value in N', {"offset": "found"}),
        (
            "offset",
            r'allowed "identify", or a value in N\*m',
            {"offset": "2 m", "kind": "rotational"},
        ),
        ("stroke[1]", None, {"stroke": (0.0, math.inf)}),
        *(
            (name, "must be a list or a tuple of two values", {name: wrong})
            for name in ("span", "stroke")
            for wrong in ((1.0,), (1.0, 2.0, 3.0))
        ),
        *(("decimation", None, {"decimation": wrong}) for wrong in (0, 10_001, 2.5)),
        *(
            (
                "columns",
                "has an unknown name.*following_error, or a further channel with a unit",
                {"columns": wrong},
            )
            for wrong in (
                {"humidity": Column("h", "", "")},
                {"a b": Column("h", "%", "1")},
                {3: Column("h", "%", "1")},
            )
        ),
        ("columns.position", "must be an object of class Column", {"columns": {"position": "q"}}),
        ("cogging", "must be an object of class Cogging", {"cogging": "motor"}),
    ],
)
def test_anything_else_is_refused_with_its_place(place, words, values):
    with pytest.raises(InputError, match=words) as reported:
        Axis(**values)
    assert reported.value.path == place


def test_values_in_units_and_single_parts_are_converted():
    assert [Axis(offset="2 N").offset, Axis(kind="rotational", offset="2 N*m").offset] == [2.0, 2.0]
    assert [getattr(Axis(plant="oscillator", **{name: 0.0}), name) for name in OF_THE_GROUND] == [
        0.0,
        0.0,
    ]
    assert Axis(cogging=Cogging("motor", 5e-3)).cogging == (Cogging("motor", 5e-3),)
    assert Axis(injected=Injected("a", 1.0), regressors=KnownColumn("b", "c")).injected == (
        Injected("a", 1.0),
    )


def test_axes_with_gains_in_different_units_are_equal():
    # The movement for a radian of the motor and the rated effort only help to read a file; its text is where it came from.
    assert Axis(arm=0.01) == Axis(arm=0.02) == Axis(rated=5.0) == Axis(text=b"schema = 1") == Axis()
    assert Axis(pitch=0.01) != Axis(pitch=0.02)
    assert Axis(mass=1.0) != Axis(mass=2.0)
    assert "text" not in repr(Axis(text=b"schema = 1"))


def test_columns_are_required_and_unscaled_by_default():
    column = Column("q", "mm", "m")
    assert (column.scale, column.shift, column.optional) == (1.0, 0.0, False)
    assert Column("T", "degC", "K", 1.0, True, 273.15).shift == 273.15
    assert not Injected("pulses", 70.0).optional
    assert not KnownColumn("load", "weight").optional
    assert set(COLUMNS) == {
        "time",
        "position",
        "velocity",
        "effort",
        "reference",
        "load",
        "temperature",
        "following_error",
    }
    assert [Cogging("motor", 5e-3).harmonics, Cogging("screw", 1e-12, 6).harmonics] == [None, (6,)]
    assert Cogging("screw", 5e-3, [1, 10_000]).harmonics == (1, 10_000)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        *(
            (lambda wrong=wrong: Column("q", "mm", "m", wrong), "scale")
            for wrong in (math.inf, math.nan)
        ),
        *(
            (lambda wrong=wrong: Injected("pulses", wrong), "gain")
            for wrong in (math.inf, math.nan)
        ),
        (lambda: Cogging("wheel", 5e-3, 1), None),
        (lambda: Cogging("motor", 0.9e-12, 1), None),
        (lambda: Cogging("motor", -5e-3, 1), None),
        (lambda: Cogging("motor", 5e-3, 0), None),
        (lambda: Cogging("motor", 5e-3, 10_001), None),
    ],
)
def test_columns_are_finite_and_cogging_comes_a_whole_number_of_times_in_a_turn(call, words):
    with pytest.raises(InputError, match=words):
        call()
