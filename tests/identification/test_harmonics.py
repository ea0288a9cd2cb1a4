"""Forces with the period of a motor or screw: waves, harmonics, pitches, and plants with them."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort

from bristle.core import InputError
from bristle.core.axis import Axis, Cogging
from bristle.identification.estimation import (
    context_of,
    harmonics_in,
    sliding_problem,
    with_harmonics,
    with_harmonics_of,
    with_pitch,
)
from bristle.identification.parameters import PriorKnowledge
from bristle.identification.preprocessing import treat
from bristle.logs.waves import frequency_in, waves
from bristle.models.friction import find, with_slots
from bristle.models.plants import inertia, with_terms
from bristle.models.plants.terms import TermedPlant

MOTION = sines(6.0, dt=2e-3, amplitudes=(0.03, 0.008), frequencies=(0.25, 0.7), phases=(0.0, 1.0))
TURN = 0.01
PERIODIC = with_slots(find("coulomb_viscous"), ["periodic"])


def dataset_with(*waves, motion=MOTION, turn=TURN, noise=0.05):
    effort = sliding_effort(motion, noise=noise)
    for order, amplitude in waves:
        effort = effort + amplitude * np.sin(
            2.0 * np.pi * order * motion.position / turn + 0.3 * order
        )
    return treat(log_of(motion, effort), STATED, 100.0, 4)


def prior_of(plant=inertia, **values):
    return PriorKnowledge(plant=plant, values=values)


@pytest.fixture(scope="module")
def rippled():
    return dataset_with((2, 2.0), (6, 1.0), (11, 0.6))


def found_in(dataset, turn=TURN, turner="motor"):
    return harmonics_in(
        sliding_problem(dataset, prior_of()), Cogging(turner, turn), "cogging[0].harmonics"
    )


STROKE = float(np.ptp(MOTION.position))


@pytest.fixture
def few_orders(monkeypatch):
    """The search of all orders takes longer than the tests."""
    monkeypatch.setattr("bristle.identification.estimation.MOST_ORDER", 22)


@pytest.mark.usefixtures("few_orders")
def test_harmonics_of_the_truth_are_found_in_order_from_one_and_a_half_turns(rippled):
    assert found_in(rippled, turn=2.0 * TURN) == [4, 12, 22]
    assert found_in(dataset_with((3, 4.0), turn=STROKE / 1.6), turn=STROKE / 1.6) == [3]


UNSEEN = (
    r"cogging\[0\]\.harmonics: cannot be identified, because no part of the effort in this log repeats with the screw"
    r".*Remove .*cogging.*, or write known orders"
)


@pytest.mark.parametrize(
    ("waves", "asked", "fault"),
    [
        ((), {"turner": "screw"}, UNSEEN),
        (
            ((1, 2.0),),
            {"turn": STROKE / 1.4},
            r"need 1\.5 turns of the motor, but the log has 1\.4",
        ),
    ],
)
def test_an_invisible_harmonic_or_an_incomplete_turn_is_rejected(waves, asked, fault):
    with pytest.raises(InputError, match=fault):
        found_in(dataset_with(*waves), **asked)


@pytest.mark.usefixtures("few_orders")
def test_a_plant_gets_the_harmonics_of_the_log_and_keeps_its_terms(rippled):
    termed = with_terms(inertia, gravity=True, cogging={"screw": [1]})
    axis = Axis(kind="translational", cogging=(Cogging("motor", TURN, None),))
    prior = with_harmonics(prior_of(termed, screw_turn=0.02), axis, rippled)
    assert isinstance(prior.plant, TermedPlant)
    assert prior.plant.gravity
    assert prior.plant.inner is inertia
    assert set(prior.plant.orders) == {("screw", 1), ("motor", 2), ("motor", 6), ("motor", 11)}
    assert prior.values == {"screw_turn": 0.02, "motor_turn": TURN}
    same = prior_of()
    assert with_harmonics(same, Axis(cogging=(Cogging("motor", TURN, (6,)),)), rippled) is same
    assert with_harmonics(same, None, rippled) is same


def test_an_axis_gets_the_harmonics_of_a_plant():
    plant = with_terms(inertia, cogging={"motor": [6, 12], "screw": [1]})
    axis = Axis(cogging=(Cogging("screw", 0.01, None), Cogging("motor", 0.005, None)))
    assert [(entry.harmonics, entry.turn) for entry in with_harmonics_of(plant, axis).cogging] == [
        ((1,), 0.01),
        ((6, 12), 0.005),
    ]


def test_a_pitch_is_found_in_the_residual_of_sliding():
    context = context_of(dataset_with((1, 3.0), turn=0.00713, noise=0.3), prior_of())
    assert with_pitch(context, PERIODIC).prior.pitch == pytest.approx(0.00713, rel=2e-3)
    assert with_pitch(context, find("coulomb_viscous")) is context
    reported = replace(context, prior=replace(context.prior, pitch=0.02))
    assert with_pitch(reported, PERIODIC) is reported


def test_friction_that_looks_viscous_has_the_level_of_total_friction():
    viscous = sliding_effort(MOTION, noise=0.01, F_C=0.0, F_v=200.0, offset=0.0)
    context = context_of(treat(log_of(MOTION, viscous), STATED, 100.0, 10), prior_of())
    assert context.sliding.viscous == pytest.approx(200.0, rel=0.02)
    assert context.scales.force == pytest.approx(
        200.0 * np.sqrt(np.mean(MOTION.velocity**2)), rel=0.1
    )
    dry = context_of(
        treat(log_of(MOTION, sliding_effort(MOTION, noise=0.01)), STATED, 100.0, 10), prior_of()
    )
    assert dry.scales.force == dry.sliding.coulomb == pytest.approx(8.0, rel=0.02)
    assert dry.sliding.viscous == pytest.approx(30.0, rel=0.1)
    with pytest.raises(InputError, match="is zero throughout"):
        context_of(treat(log_of(MOTION, 0.0 * MOTION.time), STATED, 100.0, 10), prior_of())


def test_a_pitch_is_sought_from_three_turns_over_the_range():
    few = dataset_with((1, 5.0), turn=STROKE / 4.2, noise=0.05)
    assert with_pitch(context_of(few, prior_of()), PERIODIC).prior.pitch == pytest.approx(
        STROKE / 4.2, rel=0.02
    )


def test_harmonics_are_limited_in_order_and_number(rippled, monkeypatch):
    monkeypatch.setattr("bristle.identification.estimation.MOST_ORDER", 6)
    assert found_in(rippled) == [2, 6]
    monkeypatch.setattr("bristle.identification.estimation.MOST", 1)
    assert found_in(rippled) == [2]


TURNS = 7.38  # over the range


@pytest.fixture(scope="module")
def passes():
    """Position and direction of some strokes, slower near their ends."""
    time = np.linspace(0.0, 12.0 * np.pi, 6000)
    x = 0.1 * np.cos(time)
    return x, np.where(np.gradient(x) < 0.0, -1.0, 1.0)


@pytest.mark.parametrize("odd", [False, True])
def test_a_wave_between_whole_turns_is_found_with_and_without_direction(passes, odd):
    x, side = passes
    frequency = TURNS / np.ptp(x)
    wave = (side if odd else 1.0) * np.sin(2.0 * np.pi * frequency * x + 0.4)
    noise = 0.3 * np.random.default_rng(3).standard_normal(x.size)
    assert frequency_in(x, side, wave + noise, 100.0) == pytest.approx(frequency, rel=0.006)


def test_a_wave_is_sought_between_the_fewest_and_the_most_turns(passes):
    x, side = passes
    wave = np.sin(2.0 * np.pi * TURNS / np.ptp(x) * x)
    noise = 0.1 * np.random.default_rng(4).standard_normal(x.size)
    for most, least in ((TURNS - 2.0, 1.5), (100.0, TURNS + 2.0)):
        result = frequency_in(x, side, wave + noise, most, least) * np.ptp(x)
        assert least - 1.0 < result < most + 1.0
        assert abs(result - TURNS) > 1.0
    assert frequency_in(x, side, wave, 1.0) is None
    assert frequency_in(0.0 * x, side, wave, 100.0) is None


def test_the_stronger_of_two_waves_in_the_range_is_found(passes):
    x, side = passes
    turns = 2.0 * np.pi / np.ptp(x) * x
    noise = 0.05 * np.random.default_rng(5).standard_normal(x.size)
    strong, weak = np.sin(30.3 * turns), 0.7 * np.sin(6.2 * turns)
    assert frequency_in(x, side, strong + weak + noise, 60.0) * np.ptp(x) == pytest.approx(
        30.3, abs=0.1
    )
    assert frequency_in(x, side, strong + weak + noise, 20.0) * np.ptp(x) == pytest.approx(
        6.2, abs=0.1
    )
    # Whatever the unit of the effort is.
    small = 1e-9 * (strong + weak + noise)
    assert frequency_in(x, side, small, 20.0) * np.ptp(x) == pytest.approx(6.2, abs=0.1)
    assert frequency_in(x, side, small, 60.0, 12.0) * np.ptp(x) == pytest.approx(30.3, abs=0.1)


def test_waves_are_cosine_and_sine_alone_and_with_the_direction():
    x, side = np.array([0.0, 0.25, 0.5]), np.array([1.0, -1.0, -1.0])
    expected = [[1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, -1.0], [-1.0, 0.0, 1.0, 0.0]]
    np.testing.assert_allclose(waves(x, side, 1.0), expected, atol=1e-12)
