"""What is known of an axis: what nobody says, what may be said, and what of it tells two axes apart."""

import math

import pytest

from bristle.core.axis import COLUMNS, Axis, Cogging, Column, Injected, KnownColumn
from bristle.core.errors import InputError

# Nothing is known of these until somebody says it; they are positive.
POSITIVE = (
    *("sample_time", "mass", "resolution", "effort_limit", "velocity_limit", "acceleration_limit", "jerk_limit"),
    *("pitch", "arm", "rated", "presliding", "cutoff"),
)
# None, too, may be known of these, and they may be zero.
OF_THE_GROUND = ("stiffness", "damping")


def refused(path, words=None, **values):
    with pytest.raises(InputError, match=words) as reported:
        Axis(**values)
    assert reported.value.path == path


def test_the_default_axis_is_a_driven_mass_with_fitted_efforts():
    axis = Axis()
    assert (axis.name, axis.kind, axis.plant) == ("axis", "translational", "inertia")
    assert (axis.columns, axis.injected, axis.settings, axis.cogging, axis.regressors, axis.text) == ({}, (), {}, (), (), b"")
    assert (axis.delay, axis.lag, axis.offset, axis.method) == (0.0, 0.0, "identify", "prediction_error")
    absent = (*POSITIVE, *OF_THE_GROUND, "table", "held", "hold", "periodic", "span", "stroke", "controller", "decimation", "loop")
    assert [name for name in absent if getattr(axis, name) is not None] == []
    assert axis.seeks_delay
    assert not any((axis.seeks_lag, axis.at_rest, axis.in_cycle, axis.keeps_rests, axis.gravity))


@pytest.mark.parametrize("name", POSITIVE)
def test_quantities_of_an_axis_are_positive_and_finite(name):
    assert getattr(Axis(**{name: 1e-9}), name) == 1e-9
    for wrong in (0.0, -1e-9, math.inf, math.nan):
        refused(name, **{name: wrong})


@pytest.mark.parametrize("name", OF_THE_GROUND)
def test_stiffness_and_damping_to_the_ground_may_be_zero_but_not_negative(name):
    assert getattr(Axis(plant="oscillator", **{name: 0.0}), name) == 0.0
    refused(name, **{name: -1e-9})


def test_a_lag_is_a_time_and_a_delay_may_lead():
    assert (Axis(lag=1e-4).lag, Axis(delay=-1e-4).delay) == (1e-4, -1e-4)
    refused("lag", lag=-1e-4)


def test_a_constant_part_of_friction_is_of_any_sign_or_to_be_identified():
    assert [Axis(offset=value).offset for value in (-3.0, 0.0, "2 N", "identify")] == [-3.0, 0.0, 2.0, "identify"]
    assert Axis(kind="rotational", offset="2 N*m").offset == 2.0
    refused("offset", r'allowed "identify", or a value in N', offset="found")
    refused("offset", r'allowed "identify", or a value in N\*m', offset="2 m", kind="rotational")


def test_a_span_may_have_no_end_and_a_stroke_has_both():
    assert Axis(span=(2.0, math.inf)).span == (2.0, math.inf)
    assert Axis(stroke=(-0.1, 0.4)).stroke == (-0.1, 0.4)
    refused("stroke[1]", stroke=(0.0, math.inf))
    for name in ("span", "stroke"):
        refused(name, "must be a list or a tuple of two values", **{name: (1.0,)})
        refused(name, "must be a list or a tuple of two values", **{name: (1.0, 2.0, 3.0)})


def test_decimation_is_a_positive_whole_number():
    assert [Axis(decimation=count).decimation for count in (1, 10_000)] == [1, 10_000]
    for wrong in (0, 10_001, 2.5):
        refused("decimation", decimation=wrong)


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
    for wrong in (math.inf, math.nan):
        with pytest.raises(InputError, match="scale"):
            Column("q", "mm", "m", wrong)
        with pytest.raises(InputError, match="gain"):
            Injected("pulses", wrong)


def test_columns_are_channels_following_error_or_further_channels_with_a_unit():
    for name in COLUMNS:
        assert list(Axis(columns={name: Column("c", "", "m")}).columns) == [name]
    assert set(COLUMNS) == {"time", "position", "velocity", "effort", "reference", "load", "temperature", "following_error"}
    assert list(Axis(columns={"humidity": Column("h", "%", "1")}).columns) == ["humidity"]
    assert list(Axis(columns={"humidity": Column("h", "", "", shift=1.0)}).columns) == ["humidity"]
    for name, column in (("humidity", Column("h", "", "")), ("a b", Column("h", "%", "1")), (3, Column("h", "%", "1"))):
        refused("columns", "has an unknown name.*following_error, or a further channel with a unit", columns={name: column})
    refused("columns.position", "must be an object of class Column", columns={"position": "q"})


def test_cogging_comes_a_whole_number_of_times_in_a_turn_of_motor_or_screw():
    assert Cogging("motor", 5e-3).harmonics is None
    assert Cogging("screw", 1e-12, 6).harmonics == (6,)
    assert Cogging("screw", 5e-3, [1, 10_000]).harmonics == (1, 10_000)
    for wrong in (("wheel", 5e-3, 1), ("motor", 0.9e-12, 1), ("motor", -5e-3, 1), ("motor", 5e-3, 0), ("motor", 5e-3, 10_001)):
        with pytest.raises(InputError):
            Cogging(*wrong)
    assert Axis(cogging=Cogging("motor", 5e-3)).cogging == (Cogging("motor", 5e-3),)
    assert Axis(injected=Injected("a", 1.0), regressors=KnownColumn("b", "c")).injected == (Injected("a", 1.0),)
    refused("cogging", "must be an object of class Cogging", cogging="motor")
