"""Roles of parameters, and the magnitudes that a log gives them."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort, strokes

from bristle.core import InputError, Variable
from bristle.core.dimensions import exponents_of
from bristle.friction import coulomb_viscous, find, lugre, stribeck, with_slots
from bristle.identification.parameters import (
    PriorKnowledge,
    Role,
    Scales,
    acts_in_sliding,
    constant_of,
    name_of,
    names_of,
    offset_of,
    parameters_of,
    scales_of,
    stroke_of,
)
from bristle.identification.preprocessing import treat

SCALES = Scales(
    force=20.0, peak=50.0, speed=0.6, slowest=1e-3, acceleration=3.0, stroke=0.09, shortest=1e-5, duration=10.0, sample_time=1e-3
)


def variable(quantity, **more):
    return Variable(quantity, "something", **more)


@pytest.mark.parametrize(
    ("quantity", "low", "high"),
    [
        ("length", 1e-5, 0.09),
        ("length/time", 1e-3, 0.2),
        ("force/length", 20.0 / 0.09, 20.0 / 1e-5),
        ("time", 1e-3, 10.0),
        ("1/time", 0.1, 1000.0),
        ("force/time", 2.0, 20_000.0),
        ("force", 0.02, 2000.0),
    ],
)
def test_an_unknown_magnitude_is_sought_in_the_range_of_the_log(quantity, low, high):
    assert SCALES.range(variable(quantity)) == pytest.approx((low, high))


def test_speeds_of_a_slow_log_are_sought_up_to_twice_its_slowest():
    assert SCALES._replace(slowest=0.3).range(variable("length/time")) == pytest.approx((0.3, 0.6))


@pytest.mark.parametrize(
    ("quantity", "typical"),
    [
        ("length", math.sqrt(0.09 * 1e-5)),
        ("length/time", math.sqrt(1e-3 * 0.6)),
        ("force/length", 20.0 / math.sqrt(0.09 * 1e-5)),
        ("1/length", 1.0 / 0.09),
        ("time", 0.1),
        ("1/time", 10.0),
        ("force/time", 200.0),
        ("force", 20.0),
        ("mass", 20.0 / 3.0),
        ("force*time/length", 20.0 / 0.6),
        ("force*time^2/length^2", 20.0 / 0.36),
    ],
)
def test_a_typical_value_follows_from_force_speed_and_acceleration(quantity, typical):
    assert SCALES.magnitude(variable(quantity)) == pytest.approx(typical)


def test_numbers_without_a_unit_and_of_a_drive_have_nominal_values():
    assert SCALES.magnitude(variable("1", nominal=2.0)) == 2.0
    assert SCALES.magnitude(variable("temperature", nominal=290.0)) == 290.0
    assert SCALES.magnitude(variable("force", nominal=7.0, excitation="drive")) == 7.0


def test_magnitudes_of_a_log_are_those_of_its_motion():
    motion = sines(6.0)
    dataset = treat(log_of(motion, sliding_effort(motion, noise=0.0), step=1e-6), STATED, 100.0, 10)
    scales = scales_of(dataset, 9.0)
    assert scales.force == 9.0
    assert scales.peak == pytest.approx(np.max(np.abs(dataset.effort)))
    assert scales.speed == pytest.approx(np.max(np.abs(motion.velocity)), rel=0.03)
    assert scales.slowest == pytest.approx(np.quantile(np.abs(motion.velocity), 0.01), rel=0.1)
    assert scales.acceleration == pytest.approx(np.sqrt(np.mean(motion.acceleration**2)), rel=0.02)
    assert scales.stroke == stroke_of(dataset) == pytest.approx(np.ptp(motion.position), rel=1e-3)
    assert scales.duration == pytest.approx(5.9, abs=0.02)
    assert scales.shortest == max(1e-6, scales.slowest * 1e-3)
    assert scales.sample_time == 1e-3


def test_a_log_with_rests_has_the_speeds_of_its_motion():
    motion = strokes(2)
    dataset = treat(log_of(motion, sliding_effort(motion), step=1e-6), STATED, 100.0, 10)
    scales = scales_of(dataset, 9.0)
    assert scales.slowest >= 1e-4 * scales.speed
    assert scales.slowest > 0.0


def test_the_stroke_is_that_of_a_single_segment():
    motion = sines(4.0, amplitudes=(0.02,), frequencies=(0.25,), phases=(0.0,))
    halves = log_of(motion, sliding_effort(motion), segments=(slice(0, 2000), slice(2000, 4000)))
    dataset = treat(halves, STATED, 100.0, 10)
    assert stroke_of(dataset) == pytest.approx(0.02, rel=0.01)


def test_roles_follow_from_quantity_and_excitation():
    assert {role: names_of(role, lugre.variables) for role in Role} == {
        **{role: [] for role in Role},
        Role.LEVEL: ["F_C"],
        Role.BREAK_AWAY: ["F_S"],
        Role.FALL: ["v_S"],
        Role.STIFFNESS: ["sigma_0"],
        Role.MICRO_DAMPING: ["sigma_1"],
        Role.VISCOUS: ["sigma_2"],
    }
    assert name_of(Role.LEVEL, lugre.variables) == "F_C"
    assert name_of(Role.INERTIA, lugre.variables) is None
    assert names_of(Role.LEVEL, with_slots(stribeck, ["asymmetry"]).variables) == ["F_C_pos", "F_C_neg"]
    assert [name for name in lugre.variables if acts_in_sliding(lugre.variables[name])] == ["F_C", "F_S"]


def test_the_constant_force_is_the_offset_plus_half_the_difference_of_levels():
    model = with_slots(coulomb_viscous, ["asymmetry"])(F_C_pos=9.0, F_C_neg=5.0, F_v_pos=1.0, F_v_neg=1.0, offset=1.5)
    variables, values = model.component.variables, model.values
    assert offset_of(variables, values) == 1.5
    assert constant_of(variables, values) == pytest.approx(3.5)
    assert offset_of(variables, {}) == 0.0
    assert offset_of({}, values) == 0.0
    assert constant_of(coulomb_viscous.variables, {"F_C": 3.0, "F_v": 1.0}) == 0.0


def held_by(name, velocity=(1.0, -1.0), effort=(8.0, -6.0), reach=0.03, **known):
    """The parameters of a model in a log of these rows, all of them fast, and of samples alike."""
    velocity, effort = (np.tile(signal, 50) for signal in (velocity, effort))
    segment = SimpleNamespace(position=np.array([0.01, 0.01 + reach]), surroundings={})
    facts = {"velocity": velocity, "all_velocities": velocity, "effort": effort, "acceleration": np.zeros(velocity.size)}
    dataset = SimpleNamespace(segments=(segment,), kind="translational", units={}, **facts)
    return parameters_of(find(name), PriorKnowledge(**known), dataset)


def test_redundant_parameters_are_fixed_at_round_numbers_and_known_ones_as_given():
    for reach, length in ((0.03, 0.01), (0.3, 0.1)):
        parameters = held_by("bouc_wen_classic", reach=reach)
        beta = parameters.fixed["beta"]
        assert parameters.is_redundant("beta")
        power = exponents_of(parameters.variables["beta"].quantity).get("length", 0.0)
        assert beta.value == pytest.approx(length**power)
        assert (beta.reason, beta.numbers) == ("redundant", {"products": ("beta*gamma", "beta*delta")})
    known = held_by("coulomb_viscous", values={"M": 3.0}, offset=2.0, measured={"M": (4.0, 0.5)})
    assert (known.fixed["M"].value, known.fixed["M"].reason, known.held["offset"]) == (3.0, "held_known", 2.0)
    measured = held_by("coulomb_viscous", measured={"M": (4.0, 0.5)})
    assert (measured.fixed["M"].value, measured.fixed["M"].half_width, measured.free) == (4.0, 0.5, ("F_v", "F_C", "offset"))
    place = held_by("coulomb_viscous+position").held
    assert (place["x_0"], place["x_L"]) == pytest.approx((0.025, 0.015))
    shape = held_by("dahl")
    assert shape.fixed["exponent"].reason == "held_default"
    assert "exponent" in held_by("dahl", free=("exponent",)).free
    assert held_by("coulomb_viscous+periodic", pitch=0.005).fixed["pitch"].value == 0.005


def test_a_log_of_one_direction_does_not_identify_a_constant_with_a_level():
    for velocity, side in (((1.0,), "forward"), ((-1.0,), "backward")):
        offset = held_by("coulomb_viscous", velocity, (8.0,)).fixed["offset"]
        assert (offset.value, offset.reason, offset.numbers) == (0.0, "held_one_direction", {"level": "F_C", "direction": side})
        with pytest.raises(InputError, match=f"the log contains only {side} motion"):
            held_by("coulomb_viscous+asymmetry", velocity, (8.0,))
    assert "offset" in held_by("coulomb_viscous").free


def test_a_constant_with_directional_levels_is_guessed_if_the_effort_keeps_its_sign():
    velocity = (1.0, 2.0, -1.0, -2.0)
    held = held_by("coulomb_viscous+asymmetry", velocity, (11.0, 14.0, 4.0, 1.0)).fixed["offset"]  # levels of 8 and 7, no weight
    assert (held.reason, held.numbers) == ("held_constant", {"levels": ("F_C_pos", "F_C_neg")})
    assert held.value == pytest.approx(7.5)
    # Rows below a tenth of the largest speed are not asked.
    slow = held_by("coulomb_viscous+asymmetry", (*velocity, 0.19, -0.19), (11.0, 14.0, 4.0, 1.0, 50.0, 50.0)).fixed["offset"]
    assert slow.value == pytest.approx(7.5)
    none = held_by("coulomb_viscous+asymmetry", velocity, (8.0, 11.0, -6.0, -9.0)).fixed["offset"]
    assert (none.value, none.reason) == (0.0, "held_levels")
