"""Linear systems whose responses, poles and margins are known in closed form."""

import math
from functools import partial

import numpy as np
import pytest
from tests.apps.design.conftest import loop

from bristle import controllers, friction, plants
from bristle.core.experiment import Run
from bristle.simulation import linear_system
from bristle.simulation.linear_system import (
    LARGE,
    NO_FRICTION,
    SMALL,
    LinearFriction,
    LinearSystem,
    SampledLoop,
    linear_law,
    linear_plant,
    margins_of,
    measured_on,
    sliding_force,
    slope_in_sliding,
    varied_in,
)

DT = 1e-3
POINTS = np.exp(1j * np.array([0.1, 0.7, 2.0]))


def first_order(pole, gain=1.0, direct=0.0):
    """The system gain / (z - pole) + direct."""
    return LinearSystem(np.array([[pole]]), np.ones(1), np.array([gain]), direct)


def constant(gain):
    """A system that answers its input by so many times as much."""
    return LinearSystem(np.zeros((0, 0)), np.zeros(0), np.zeros(0), gain)


def test_the_response_is_that_of_the_transfer_function():
    assert first_order(0.5, 3.0, 2.0).response(POINTS) == pytest.approx(3.0 / (POINTS - 0.5) + 2.0)
    assert constant(4.0).response(POINTS) == pytest.approx(np.full(3, 4.0))


def test_parallel_systems_add_their_outputs():
    single, other = first_order(0.5, 3.0, 2.0), first_order(-0.2, 1.0, 0.5)
    both = single.beside(other)
    assert both.response(POINTS) == pytest.approx(single.response(POINTS) + other.response(POINTS))
    assert sorted(np.linalg.eigvals(both.A)) == pytest.approx([-0.2, 0.5])
    assert single.beside(constant(1.0)).response(POINTS) == pytest.approx(
        single.response(POINTS) + 1.0
    )


def test_a_function_is_measured_by_its_slopes_in_each_direction():
    def sample(state, measured):
        x, mode = state
        return np.array([0.5 * x + 3.0 * measured + 0.1, mode]), 2.0 * x - measured + 7.0

    system = measured_on(sample, np.array([1.0, 5.0]), np.array([True, False]), 1e-3)
    assert pytest.approx(np.array([[0.5]])) == system.A
    assert (system.B[0], system.C[0], system.D) == pytest.approx((3.0, 2.0, -1.0))


def test_only_numbers_of_a_state_are_varied():
    structure = ("State", ["number", "counter", ("Part", ["number", "mode"])])
    assert varied_in(structure).tolist() == [True, False, True, False]


def test_a_cascade_answers_a_position_by_its_gains():
    law = linear_law(controllers.cascade(k_p=40.0, k_v=3000.0), DT, LARGE)
    slow = law.response(np.array([np.exp(1e-6j)]))[0]
    assert slow.real == pytest.approx(-40.0 * 3000.0, rel=1e-6)
    # A difference over a sample: k_v (1 - 1/z) / dt at half the sampling rate.
    assert law.response(np.array([-1.0 + 0j]))[0] == pytest.approx(
        -3000.0 * (40.0 + 2.0 / DT), rel=1e-6
    )


def test_a_law_is_measured_about_rest_to_rounding():
    # Anywhere else a motion so small would be lost in the digits of position and effort.
    for law in (
        controllers.sliding_mode(J=20.0, lambda_=100.0, K_1=100.0, K_2=3.0, phi=1e-3),
        controllers.cascade(k_p=40.0, k_v=3000.0, k_i=2e4),
    ):
        small, larger = linear_law(law, DT, SMALL), linear_law(law, DT, 1e3 * SMALL)
        for part, other in zip(small, larger, strict=True):
            assert part == pytest.approx(
                other, rel=1e-14, abs=1e-14 * np.max(np.abs(other), initial=0.0)
            )


# --- plants ---------------------------------------------------------------------------------------------------------


def positions(plant, command, count):
    """The positions [m] that a plant has at the samples under a constant command."""
    state, result = np.zeros(plant.B.size), []
    for _ in range(count):
        result.append(plant.C @ state)
        state = plant.A @ state + plant.B * command
    return np.array(result)


def last(x):
    return x[-1]


def speed(x):
    return (x[-1] - x[-2]) / DT


# An arm of 1 mm.
SCREW = {"kind": "rotational", "J": 1e-3, "M": 50.0, "lead": 2e-3 * math.pi, "k": 1e8, "d": 2e3}


def behind_a_screw(side, motor=NO_FRICTION, table=NO_FRICTION, **changed):
    """The plant of a table behind a screw whose arm is a millimetre."""
    law = controllers.cascade(kind="rotational", k_p=80.0, k_v=0.2)
    variant = loop(
        plant=plants.ball_screw(**(SCREW | changed)),
        controller=law,
        sensor_at=side,
        run=Run(4.0, DT, substeps=20),
    )
    return linear_plant(variant, LARGE, motor, table)


LAGGING = loop(run=Run(4.0, DT, substeps=10, current_lag=2e-3))
KEPT = (LinearFriction(0.0, 0.06), LinearFriction(1e7, 3e4))


@pytest.mark.parametrize(
    ("plant", "command", "count", "read", "expected", "tolerance"),
    [
        # A constant effort moves a mass by half of its acceleration times time squared, and behind a lag later.
        (
            lambda: linear_plant(loop(), LARGE),
            40.0,
            6,
            np.array,
            0.5 * 2.0 * (DT * np.arange(6)) ** 2,
            1e-6,
        ),
        (
            lambda: linear_plant(LAGGING, LARGE),
            40.0,
            9,
            np.array,
            2.0
            * (
                0.5 * (DT * np.arange(9)) ** 2
                - 2e-3 * DT * np.arange(9)
                + 4e-6 * (1.0 - np.exp(-0.5 * np.arange(9)))
            ),
            1e-3,
        ),
        # A damper lets it slide at its terminal speed, and a spring holds it where the effort balances.
        (
            lambda: linear_plant(loop(), LARGE, LinearFriction(0.0, 4000.0)),
            40.0,
            100,
            speed,
            0.01,
            1e-6,
        ),
        (
            lambda: linear_plant(loop(), LARGE, LinearFriction(2e5, 4000.0)),
            40.0,
            2000,
            last,
            2e-4,
            1e-6,
        ),
        # 50 kg over an arm of a millimetre are 5e-5 kg m^2.
        *(
            (
                partial(behind_a_screw, side),
                0.42,
                200,
                lambda x: np.mean(np.diff(x, 2)[100:]) / DT**2,
                0.42 / (1e-3 + 5e-5),
                0.01,
            )
            for side in ("motor", "load")
        ),
        # 0.01 N m are 10 N at the table: of 1e7 N/m it gives by 1 um, or 1e-3 rad, and a screw of 1e6 N/m by 10 um, or 1e-2 rad.
        (partial(behind_a_screw, "motor", *KEPT, k=1e6), 0.01, 3000, last, 1e-3 + 1e-2, 1e-3),
        (partial(behind_a_screw, "load", *KEPT, k=1e6), 0.01, 3000, last, 1e-3, 1e-3),
        # Over an arm of a millimetre 3e5 N s/m at the table are 0.3 N m s/rad at the motor.
        (partial(behind_a_screw, "load", LinearFriction(0.0, 0.3)), 0.06, 400, speed, 0.2, 1e-3),
        (
            partial(behind_a_screw, "load", NO_FRICTION, LinearFriction(0.0, 3e5)),
            0.06,
            400,
            speed,
            0.2,
            1e-3,
        ),
        # A spring at the motor holds both.
        *(
            (partial(behind_a_screw, side, LinearFriction(4.0, 0.2)), 0.2, 2000, last, 0.05, 1e-4)
            for side in ("motor", "load")
        ),
    ],
)
def test_a_plant_goes_where_its_equation_says(plant, command, count, read, expected, tolerance):
    assert read(positions(plant(), command, count)) == pytest.approx(
        expected, rel=tolerance, abs=1e-4 * tolerance
    )


@pytest.mark.parametrize("side", ["motor", "load"])
def test_springs_without_dampers_keep_their_energy_and_their_frequencies(side):
    # 100 N m/rad of the screw between 1e-3 and 5e-5 kg m^2, each held by a spring of its own: 4 and 10 N m/rad.
    system = behind_a_screw(side, LinearFriction(4.0, 0.0), LinearFriction(1e7, 0.0), d=0.0)
    poles = np.linalg.eigvals(system.A)
    turning = poles[np.abs(poles) > 0.5]
    assert np.abs(turning) == pytest.approx(np.ones(4), abs=1e-9)
    expected = np.sqrt(
        np.linalg.eigvals(np.array([[104.0 / 1e-3, -100.0 / 1e-3], [-100.0 / 5e-5, 110.0 / 5e-5]]))
    )
    assert np.sort(np.angle(turning) / DT)[2:] == pytest.approx(np.sort(expected), rel=2e-3)


def test_a_mass_on_a_spring_keeps_its_energy_and_its_frequency():
    poles = np.linalg.eigvals(
        linear_plant(loop(run=Run(4.0, DT, substeps=20)), LARGE, LinearFriction(2e6, 0.0)).A
    )
    turning = poles[np.abs(poles.imag) > 0.1]
    assert np.abs(turning) == pytest.approx(np.ones(2), abs=1e-9)
    assert np.abs(np.angle(turning)) / DT == pytest.approx(
        np.full(2, math.sqrt(2e6 / 20.0)), rel=1e-3
    )


# --- friction -------------------------------------------------------------------------------------------------------


def test_friction_at_a_speed_is_the_mean_of_both_directions():
    model = friction.find("coulomb_viscous+asymmetry")(
        F_C_pos=24.0, F_C_neg=16.0, F_v_pos=90.0, F_v_neg=50.0, offset=3.0
    )
    assert sliding_force(model, 0.1) == pytest.approx(20.0 + 7.0)
    assert slope_in_sliding(model, 0.1) == (0.0, pytest.approx(70.0))


# --- loops ----------------------------------------------------------------------------------------------------------


def integrator(gain, delay=0):
    """A position that is the sum of efforts, under a law that answers it by a gain."""
    return SampledLoop(first_order(1.0), constant(-gain), delay, DT)


@pytest.mark.parametrize(
    ("looped", "polynomial"),
    [
        # z^d (z - 1) + 0.3 = 0
        (integrator(0.3), [1.0, -0.7]),
        (integrator(0.3, 1), [1.0, -1.0, 0.3]),
        (integrator(0.3, 3), [1.0, -1.0, 0.0, 0.0, 0.3]),
        # z^d (z - 1) (z - 0.5) + 0.2 = 0
        (SampledLoop(first_order(1.0), first_order(0.5, -0.2), 0, DT), [1.0, -1.5, 0.7]),
        (SampledLoop(first_order(1.0), first_order(0.5, -0.2), 2, DT), [1.0, -1.5, 0.5, 0.0, 0.2]),
    ],
)
def test_delay_lines_and_laws_make_the_poles_of_their_polynomial(looped, polynomial):
    sizes = sorted(np.abs(np.roots(polynomial)), reverse=True)
    assert np.abs(looped.poles) == pytest.approx(sizes, rel=1e-7)  # the largest one first
    assert looped.spectral_radius == pytest.approx(sizes[0])


def test_states_that_take_no_part_are_no_poles():
    idle = LinearSystem(
        np.diag([1.0, 0.99, 0.98]), np.array([1.0, 0.0, 1.0]), np.array([1.0, 1.0, 0.0]), 0.0
    )
    assert SampledLoop(idle, constant(-0.3), 0, DT).poles == pytest.approx([0.7])


def test_a_free_body_is_not_unstable():
    free = LinearSystem(
        np.array([[1.0, DT], [0.0, 1.0]]), np.array([0.0, DT]), np.array([1.0, 0.0]), 0.0
    )
    assert not SampledLoop(free, constant(0.0), 0, DT).is_unstable
    assert SampledLoop(first_order(1.00001), constant(0.0), 0, DT).is_unstable


def test_a_stronger_law_answers_so_many_times_as_strongly():
    law = first_order(0.5, -0.2, -0.1)
    stronger = SampledLoop(first_order(1.0), law, 1, DT).with_gain(3.0)
    assert stronger.law.response(POINTS) == pytest.approx(3.0 * law.response(POINTS))
    assert stronger.delay == 1


@pytest.mark.parametrize(("gain", "delay"), [(0.3, 0), (0.3, 1), (0.1, 3), (0.05, 0)])
def test_margins_of_an_integrator_are_those_by_hand(gain, delay):
    # |z - 1| = 2 sin(w T/2) = k at the crossover; the phase there is -90 degrees less w T (1/2 + delay).
    angle = 2.0 * math.asin(0.5 * gain)
    result = margins_of(integrator(gain, delay))
    phase = 90.0 - math.degrees(angle * (0.5 + delay))
    assert result.crossover == pytest.approx(angle / DT, rel=1e-9)
    assert result.phase == pytest.approx(phase, rel=1e-9)
    assert result.delay == pytest.approx(math.radians(phase) / angle, rel=1e-9)
    # At 180 degrees w T (1/2 + delay) is 90 degrees.
    assert result.gain == pytest.approx(
        2.0 * math.sin(0.5 * math.pi / (1.0 + 2.0 * delay)) / gain, rel=1e-6
    )


def test_the_sensitivity_is_its_largest():
    # 1/(1 + k/(z - 1)) = (z - 1)/(z - 1 + k) is largest at half the sampling rate: 2/(2 - k).
    assert margins_of(integrator(0.5)).sensitivity == pytest.approx(2.0 / 1.5)


def test_an_unstable_loop_has_negative_phase_margin_and_a_stable_lower_gain():
    # With one sample of delay an integrator is stable up to a gain of 1.
    result = margins_of(integrator(1.25, 1))
    assert result.gain == pytest.approx(0.8, rel=1e-6)
    assert result.phase == pytest.approx(90.0 - math.degrees(3.0 * math.asin(0.625)), rel=1e-9)
    assert result.phase < 0.0
    assert result.delay == pytest.approx(math.radians(result.phase) / (2.0 * math.asin(0.625)))


def test_a_loop_that_never_crosses_over_has_no_margin():
    still = SampledLoop(first_order(0.5, 0.1), constant(-1.0), 0, DT)
    result = margins_of(still)
    assert (result.phase, result.crossover, result.delay) == (None, None, None)
    assert result.gain == pytest.approx(15.0, rel=1e-3)  # 0.1/(-1 - 0.5) at half the sampling rate


def test_a_state_is_reached_along_a_chain():
    linked = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=bool)
    assert linear_system._reached(linked, np.array([True, False, False])).tolist() == [
        True,
        True,
        True,
    ]
    assert linear_system._reached(linked.T, np.array([True, False, False])).tolist() == [
        True,
        False,
        False,
    ]
