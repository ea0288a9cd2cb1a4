"""One run of a variant: what it is asked for, what is judged, and what is learned from trial to trial."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from bristle import controllers, friction, plants, references, sensors
from bristle.core.errors import InputError
from bristle.core.experiment import Effort, Experiment, Feedforward, Learning, Run, Start, Variant
from bristle.core.status import Status
from bristle.engine.loop import sensed
from bristle.files.variant import at_rest
from bristle.simulation import run as module
from bristle.simulation.run import learn, seeded, simulate, simulate_with
from bristle.simulation.statistics import statistics_of

pytestmark = pytest.mark.usefixtures("in_plain_python")

DT = 1e-2


def loop(count=40, **changes):
    """Return a loop along a straight motion of 0.1 m/s, then back."""
    position = 0.1 * DT * np.minimum(np.arange(count), count - 1.0 - np.arange(count))
    parts = {
        "name": "loop",
        "plant": plants.inertia(M=2.0),
        "friction": friction.coulomb_viscous(F_C=3.0, F_v=5.0),
        "controller": controllers.cascade(k_p=10.0, k_v=100.0),
        "sensor": sensors.encoder(),
        "reference": references.recorded(position=position, sample_time=DT),
        "feedforward": Feedforward(),
        "run": Run(duration=count * DT, sample_time=DT, substeps=1),
    }
    return Variant(**(parts | changes))


def ran(variant):
    return simulate(Experiment("bench", "translational", (variant,))).variants[variant.name]


@pytest.mark.parametrize(("settle", "first"), [(0.0, 0), (0.1, 10)])
def test_errors_compare_the_reference_with_both_positions_after_the_settling_time(settle, first):
    run = Run(duration=40 * DT, sample_time=DT, substeps=1, settle=settle)
    result = ran(loop(sensor=sensors.encoder(resolution=5e-3), run=run))
    assert result.time == pytest.approx(DT * np.arange(40))
    assert result.reference == pytest.approx(loop().reference.values["position"])
    following, true = (
        statistics_of((result.reference - signal)[first:])
        for signal in (result.measured, result.position)
    )
    assert (result.following_error, result.true_error) == (following, true)
    assert following != true
    effort = result.effort[first:]
    assert (result.effort_rms, result.effort_peak) == pytest.approx(
        (np.sqrt(np.mean(effort**2)), np.max(np.abs(effort)))
    )
    assert result.motion == statistics_of(result.position[first:])


def test_directions_are_those_of_the_reference():
    result = ran(loop())
    error = result.reference - result.measured
    assert result.by_direction["forward"].mean == pytest.approx(np.mean(error[:20]))
    assert result.by_direction["backward"].mean == pytest.approx(np.mean(error[20:]))
    assert list(result.by_direction) == ["forward", "backward"]


def test_an_additional_effort_is_added_to_the_feedforward():
    fed = loop(feedforward=Feedforward(friction=friction.coulomb(F_C=3.0)))
    plain, more = simulate_with(fed, None), simulate_with(fed, np.full(40, 2.0))
    assert more.feedforward - plain.feedforward == pytest.approx(np.full(40, 2.0))


def test_feedforward_along_the_measured_motion_is_part_of_the_result():
    result = ran(
        loop(feedforward=Feedforward(friction=friction.coulomb(F_C=3.0), along="measured"))
    )
    assert np.max(result.feedforward) == pytest.approx(3.0)
    assert np.all(ran(loop()).feedforward == 0.0)


def test_an_effort_needs_one_value_for_each_sample():
    driven = loop(controller=controllers.open_loop(), effort=Effort(np.ones(40)))
    assert ran(driven).effort.tolist() == [1.0] * 40
    with pytest.raises(
        InputError, match=r"effort: has another length than the run; found '?39.*allowed 40 samples"
    ):
        ran(replace(driven, effort=Effort(np.ones(39))))


def test_an_effort_with_a_disturbance_runs_by_steps_or_by_a_tolerance():
    push, unseen = np.full(40, 9.0), np.full(40, 2.0)
    driven = loop(
        controller=controllers.open_loop(),
        effort=Effort(push),
        disturbance=unseen,
        reference=at_rest("translational"),
    )
    runs = [
        Run(duration=40 * DT, sample_time=DT, effort_limit=8.0, **way)
        for way in ({"substeps": 50}, {"tolerance": 1e-6})
    ]
    steps, exact = (ran(replace(driven, run=run)) for run in runs)
    assert steps.position == pytest.approx(exact.position, abs=1e-5)
    for result in (steps, exact):
        assert result.effort.tolist() == [8.0] * 40
        # 2 v' = 8 - 2 - 3 - 5 v
        assert result.velocity[-1] == pytest.approx(0.6 * (1.0 - np.exp(-2.5 * 0.39)), rel=1e-3)
        assert result.is_open
        assert np.isnan(result.following_error.rms)


def test_a_motion_in_progress_starts_in_its_steady_state():
    start = Start(0.2, 0.1, 0.0, 3.5)
    bristles = friction.lugre(F_C=3.0, F_S=3.0, v_S=1.0, sigma_0=1e4, sigma_1=0.0, sigma_2=5.0)
    position = 0.2 + 0.1 * DT * np.arange(40)
    moving = loop(
        friction=bristles,
        start=start,
        reference=references.recorded(position=position, sample_time=DT),
    )
    result = ran(moving)
    assert (result.position[0], result.velocity[0]) == (0.2, 0.1)
    # Its bristles are deflected from the first sample on.
    assert result.friction[0] == pytest.approx(3.0 + 5.0 * 0.1, rel=0.1)
    virgin = ran(replace(moving, start=None))
    assert virgin.position[0] == pytest.approx(0.2)
    assert virgin.friction[0] < 3.4


NOISY, EXACT = sensors.encoder(noise=1e-3, seed=5), friction.coulomb(F_C=1.0)


def test_each_run_has_separate_random_numbers():
    assert seeded(NOISY, 3).values["seed"] == 8
    assert (seeded(NOISY, 0) is NOISY, seeded(EXACT, 3) is EXACT) == (True, True)


def test_progress_counts_the_runs_of_all_variants():
    seen = []
    first = loop(
        20,
        name="first",
        sensor=sensors.encoder(noise=1e-4),
        run=Run(duration=20 * DT, sample_time=DT, substeps=1, seeds=3),
    )
    result = simulate(
        Experiment("bench", "translational", (first, loop(20, name="second"))),
        lambda *reported: seen.append(reported),
    )
    assert seen == [(0.0, "first"), (0.25, "first"), (0.5, "first"), (0.75, "second")]
    assert [item.runs for item in result.variants.values()] == [3, 1]
    assert result.variants["first"].following_error.rms > 0.0
    assert result.variants["first"].spread["effort"]["rms"] > 0.0


def trials(learning, gain=1.0, diverges_at=99):
    """Return what is learned on an axis whose error is what the learned effort lacks of a wave, with what was asked."""
    wave, requested, laws = np.sin(0.1 * np.arange(400)), [], []

    def once(variant, desired, number):
        laws.append(variant.controller)
        requested.append((desired, number))
        error = wave - gain * desired[3]
        status = Status.NOT_FINITE if len(requested) == diverges_at else Status.OK
        return Result(
            error,
            np.zeros(400),
            SimpleNamespace(peak_to_peak=float(np.ptp(error))),
            status,
            controller=f"law {len(laws)}",
        )

    desired = np.stack([np.full(400, float(k)) for k in range(4)]) * [[1.0], [1.0], [1.0], [0.0]]
    variant = SimpleNamespace(
        learning=learning, run=SimpleNamespace(sample_time=1e-3), controller="law 0"
    )
    with pytest.MonkeyPatch.context() as patched:
        patched.setitem(learn.__globals__, "_simulate_once", once)
        patched.setitem(
            learn.__globals__,
            "replace",
            lambda item, **changes: type(item)(**(vars(item) | changes)),
        )
        result = learn(variant, desired, 7)
    # Each trial begins with what the law has learned in the trial before.
    assert laws == [f"law {number}" for number in range(len(laws))]
    return result, requested, wave


class Result(SimpleNamespace):
    """What a trial returns, as far as learning looks at it."""

    def __init__(self, reference, measured, following_error, status, trials=(), controller=None):
        super().__init__(
            reference=reference,
            measured=measured,
            following_error=following_error,
            status=status,
            trials=trials,
            controller=controller,
        )


def test_each_trial_learns_from_the_error_of_the_last():
    result, requested, wave = trials(Learning(trials=3, k_e=0.5, k_d=0.0, cutoff=200.0))
    inside = slice(100, 300)
    assert requested[0][0][3].tolist() == [0.0] * 400
    assert requested[1][0][3][inside] == pytest.approx(0.5 * wave[inside], abs=5e-3)
    assert requested[2][0][3][inside] == pytest.approx(0.75 * wave[inside], abs=5e-3)
    assert [rows[:3, 0].tolist() for rows, _ in requested] == [[0.0, 1.0, 2.0]] * 3
    assert [number for _, number in requested] == [7, 1007, 2007]
    assert result.trials == pytest.approx((2.0, 1.0, 0.5), rel=0.2)


def test_the_rate_of_the_error_is_learned_too():
    _, requested, wave = trials(Learning(trials=2, k_e=0.0, k_d=0.01, cutoff=200.0))
    # 0.1 rad in a sample of 1 ms: 100 rad/s.
    assert requested[1][0][3][150:250] == pytest.approx(np.cos(0.1 * np.arange(150, 250)), abs=0.02)
    assert np.ptp(wave) == pytest.approx(2.0, rel=0.01)


def test_a_trial_that_diverges_is_the_last():
    result, requested, _ = trials(Learning(trials=5, k_e=0.5, k_d=0.0, cutoff=200.0), diverges_at=2)
    assert len(requested) == len(result.trials) == 2


def test_a_loop_learns_below_half_its_sampling_frequency():
    with pytest.raises(
        InputError, match=r"controller.learning.cutoff: out of range; found '?500.*allowed < 500 Hz"
    ):
        trials(Learning(trials=2, k_e=0.5, k_d=0.0, cutoff=500.0))


def test_the_first_run_has_the_random_numbers_of_the_variant():
    result = ran(
        loop(20, sensor=NOISY, run=Run(duration=20 * DT, sample_time=DT, substeps=1, seeds=2))
    )
    assert result.measured == pytest.approx(sensed(NOISY, result.position, DT), abs=1e-15)


def test_a_law_takes_over_position_velocity_and_acceleration_of_the_first_sample(monkeypatch):
    t, asked = DT * np.arange(40), []
    run_closed_loop = module.run_closed_loop
    monkeypatch.setattr(
        module,
        "run_closed_loop",
        lambda *loop, **facts: asked.append(facts) or run_closed_loop(*loop, **facts),
    )
    ran(
        loop(
            reference=references.recorded(
                position=0.2 + 0.1 * t + 0.5 * t**2 + 2.0 * t**3, sample_time=DT
            )
        )
    )
    desired = references.recorded(position=0.2 + 0.1 * t + 0.5 * t**2 + 2.0 * t**3, sample_time=DT)
    first = [float(signal[0]) for signal in desired.component.sample(t, desired.parameters)]
    (facts,) = asked
    assert [facts[name] for name in ("x", "v", "acceleration")] == first
    assert len(set(first)) == 3
