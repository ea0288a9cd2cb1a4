"""What a motion may use of the limits of an axis, and what is believed where the axis file says nothing."""

import math
from dataclasses import replace

import pytest
from tests.prediction.excitation.axes import STAGE

from bristle.core import Axis, InputError
from bristle.models.controllers import cascade
from bristle.models.friction import coulomb_viscous, lugre, maxwell_slip
from bristle.models.plants import inertia
from bristle.prediction.excitation.limits import (
    MotionLimits,
    effort_limit,
    limits_of,
    prior_of,
    turning_distance,
)

# Lengths of a bristle over which half a reversal is done but for 2 %
BRISTLES = 0.5 * math.log(50.0)


def limits(axis=STAGE, travel=None, start=None):
    return limits_of(axis, prior_of(axis), 1e-3, travel, start)


FORCEFUL = replace(STAGE, acceleration_limit=None)
NOTHING = limits(Axis(kind="rotational"))


@pytest.mark.parametrize(
    ("result", "expected"),
    [
        # A motion uses nine tenths of each limit, and all of the jerk.
        ((limits().travel, limits().velocity, limits().acceleration), (0.27, 0.27, 2.7)),
        (
            (limits().jerk, limits().count, limits().presliding, limits().sample_time),
            (5000.0, 0.125e-6, 7e-6, 1e-3),
        ),
        ((limits().reach, limits().extent, limits().fastest), (7e-6, 0.27, 0.27)),
        # An unstated limit is unknown.
        (
            (NOTHING.reach, NOTHING.extent, NOTHING.fastest, NOTHING.corner(1.0, 1.0)),
            (0.0, 0.0, math.inf, 20.0),
        ),
        # It stays off the nearer end of the stroke, and uses a given travel whole.
        ([limits(start=start).travel for start in (0.15, 0.0, 0.05)], [0.09, 0.18, 0.27]),
        (
            [limits(travel=travel).travel for travel in (0.02, STAGE.stroke[1] - STAGE.stroke[0])],
            [0.02, 0.3],
        ),
        # Half of the effort over the mass is an acceleration.
        (limits(FORCEFUL).acceleration, 0.9 * 12.5),
    ],
)
def test_a_motion_uses_the_limits_of_its_axis(result, expected):
    assert result == pytest.approx(expected)


def test_what_is_not_told_is_unknown():
    assert MotionLimits("rotational", 1e-3) == NOTHING
    assert (
        limits(replace(FORCEFUL, mass=None)).acceleration
        is limits(replace(FORCEFUL, effort_limit=None)).acceleration
        is None
    )
    with pytest.raises(
        InputError,
        match=r"travel: is more than the stroke of the axis; found '?0.301.*allowed up to 300 mm",
    ):
        limits(travel=0.301)


@pytest.mark.parametrize(
    ("path", "of"),
    [
        ("limits.velocity", lambda value: {"axis": replace(STAGE, velocity_limit=value)}),
        ("limits.acceleration", lambda value: {"axis": replace(STAGE, acceleration_limit=value)}),
        ("limits.jerk", lambda value: {"axis": replace(STAGE, jerk_limit=value)}),
        ("limits.stroke", lambda value: {"axis": replace(STAGE, stroke=(0.0, value))}),
        ("travel", lambda value: {"travel": value}),
    ],
)
def test_a_limit_below_a_nanometre_is_a_mistake_of_units(path, of):
    prior = prior_of(STAGE)
    asked = {"axis": STAGE, "travel": None}
    limits_of(prior=prior, sample_time=1e-3, **asked | of(1.1e-9))
    with pytest.raises(
        InputError,
        match=rf"{path}: is too small for a motion.*allowed >= 1e-09 in SI.*Check the unit",
    ):
        limits_of(prior=prior, sample_time=1e-3, **asked | of(0.9e-9))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_stroke_far_from_zero_has_too_few_digits(side):
    # Doubles are 2^-30 apart below 2^23.
    limits(replace(STAGE, stroke=tuple(sorted((side * 8.38e6, side * 8.3e6)))))
    with pytest.raises(InputError, match="too few digits"):
        limits(replace(STAGE, stroke=tuple(sorted((side * 8.39e6, side * 8.3e6)))))


@pytest.mark.parametrize("start", [-0.1, 0.2, 0.3])
def test_a_start_at_an_end_of_the_stroke_leaves_no_room(start):
    with pytest.raises(
        InputError,
        match=r"start: leaves no travel on one side.*allowed between -0.1 and 0.2, in SI",
    ):
        limits(start=start)


def number_of(prior, name):
    """A number of what is believed of an axis, of its friction or of its plant."""
    if name == "turning":
        return turning_distance(prior.friction)
    return (
        getattr(prior, name)
        if hasattr(prior, name)
        else (prior.friction.values | prior.plant.values)[name]
    )


about = pytest.approx
BARE = replace(STAGE, presliding=None)
STIFFNESS, FASTEST = 87.5 * BRISTLES / 7e-6, 1e4 * 7e-6 / BRISTLES
GIVEN = lugre(F_C=20.0, F_S=25.0, v_S=1e-3, sigma_0=5e6, sigma_1=1e3, sigma_2=100.0)
STATIC = coulomb_viscous(F_C=20.0, F_v=1.0)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        # Friction is taken for a tenth of the largest effort, with the usual proportions.
        (
            (STAGE,),
            {
                "F_C": about(70.0),
                "F_S": about(87.5),
                "v_S": about(3e-3),
                "sigma_2": about(35.0 / 0.3),
                "sigma_0": about(STIFFNESS),
            }
            | {
                "sigma_1": about(0.2 * 2.0 * math.sqrt(STIFFNESS * 28.0)),
                "M": 28.0,
                "mass_known": True,
                "stribeck_velocity": None,
            }
            | {"resonance": about(math.sqrt(STIFFNESS / 28.0) / (2.0 * math.pi))}
            | {"assumed": ("Coulomb friction of 70 N", "lugre with the usual proportions")},
        ),
        ((replace(STAGE, effort_limit=None),), {"F_C": 1.0, "F_S": 1.25, "resonance": None}),
        # Without a velocity it slides ten thousand bristles a second.
        (
            (replace(STAGE, velocity_limit=None),),
            {"v_S": about(0.01 * FASTEST), "sigma_2": about(35.0 / FASTEST)},
        ),
        # By default friction turns over twenty steps of the encoder.
        (
            (BARE,),
            {"sigma_0": about(87.5 * BRISTLES / 2.5e-6), "presliding": None, "resonance": None},
        ),
        (
            (replace(BARE, resolution=None),),
            {"sigma_0": about(87.5 * BRISTLES / 2e-5), "presliding": None},
        ),
        (
            (replace(STAGE, presliding=4e-6),),
            {"sigma_0": about(87.5 * BRISTLES / 4e-6), "presliding": 4e-6},
        ),
        # A given friction sets distance, resonance and Stribeck velocity.
        (
            (replace(STAGE, mass=None), inertia(M=2.0), GIVEN),
            {
                "friction": GIVEN,
                "assumed": (),
                "stribeck_velocity": 1e-3,
                "mass_known": True,
                "M": 2.0,
            }
            | {
                "presliding": about(BRISTLES * 25.0 / 5e6, rel=0.02),
                "resonance": about(math.sqrt(5e6 / 2.0) / (2.0 * math.pi), rel=0.01),
            },
        ),
        # A static friction turns over the distance of the axis, or at once.
        (
            (STAGE, None, STATIC),
            {"presliding": 7e-6, "turning": about(7e-6, rel=0.02)}
            | {
                "resonance": about(
                    math.sqrt(20.0 * BRISTLES / 7e-6 / 28.0) / (2.0 * math.pi), rel=0.01
                )
            },
        ),
        ((BARE, None, STATIC), {"presliding": None, "resonance": None, "friction": STATIC}),
    ],
)
def test_what_is_believed_of_an_axis_follows_from_its_limits(given, expected):
    prior = prior_of(*given)
    assert {name: number_of(prior, name) for name in expected} == expected


@pytest.mark.parametrize(
    ("changes", "mass", "text"),
    [
        ({}, 350.0 / 3.0, "mass of 117 kg"),
        ({"acceleration_limit": None}, 350.0, "mass of 350 kg"),
        ({"effort_limit": None}, 1.0 / 3.0, "mass of 0.333 kg"),
        ({"kind": "rotational"}, 350.0 / 3.0, "inertia of 117 kg*m^2"),
    ],
)
def test_an_unstated_mass_follows_from_half_of_the_effort(changes, mass, text):
    prior = prior_of(replace(STAGE, mass=None, **changes))
    assert prior.plant.values["M"] == pytest.approx(mass)
    assert prior.assumed[0].replace("·", "*").replace("²", "^2") == text
    assert (prior.mass_known, prior.resonance) == (False, None)


@pytest.mark.parametrize("distance", [2e-9, 0.02])
def test_a_turning_distance_is_found_from_a_nanometre_to_centimetres(distance):
    model = lugre(
        F_C=20.0, F_S=20.0, v_S=1.0, sigma_0=BRISTLES * 20.0 / distance, sigma_1=0.0, sigma_2=0.0
    )
    assert turning_distance(model) == pytest.approx(distance, rel=0.03)
    # Sliders turn over twice the longest stretch.
    assert turning_distance(
        maxwell_slip(F_C=20.0, k_i=[20.0 / distance], nu_i=[1.0])
    ) == pytest.approx(distance, rel=0.03)


def test_an_effort_limit_is_that_of_the_axis_or_else_of_the_controller():
    law = cascade(k_p=10.0, k_v=100.0, limit=350.0)
    assert effort_limit(replace(STAGE, controller=law)) == 700.0
    assert effort_limit(replace(STAGE, controller=law, effort_limit=None)) == 350.0
    assert (
        effort_limit(replace(STAGE, controller=cascade(k_p=10.0, k_v=100.0), effort_limit=None))
        is None
    )
    assert effort_limit(replace(STAGE, effort_limit=None)) is None
