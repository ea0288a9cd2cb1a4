"""What would make a simulated loop follow as a log does: each number that may be wrong, changed by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from bristle import controllers, friction, plants, references, sensors
from bristle.core import Axis
from bristle.core.diagnostic import Diagnostic
from bristle.core.experiment import Feedforward, Run, Variant
from bristle.identification.settings import Settings
from bristle.logs.log import Channel, Log
from bristle.prediction import following
from bristle.prediction.following import (
    CHANGES,
    FACTORS,
    Following,
    Suspect,
    _best_factor,
    _fed,
    _shifted,
    _Trial,
    apart,
    explanations,
    following_of,
    longest_of,
    loop_of,
)
from bristle.simulation import compensation_experiment, simulate
from bristle.simulation.statistics import Statistics, statistics_of

pytestmark = pytest.mark.usefixtures("in_plain_python")

DT, COUNT = 1e-2, 100
LAW = controllers.cascade(k_p=10.0, k_v=100.0, k_i=500.0)


def loop(**changes):
    position = 0.05 * (1.0 - np.cos(2.0 * np.arange(COUNT) * DT))
    parts = {
        "name": "loop",
        "plant": plants.inertia(M=2.0),
        "friction": friction.viscous(F_v=20.0),
        "controller": LAW,
        "sensor": sensors.encoder(),
        "reference": references.recorded(position=position, sample_time=DT),
        "feedforward": Feedforward(),
        "run": Run(duration=COUNT * DT, sample_time=DT, substeps=1, settle=0.2),
    }
    return Variant(**(parts | changes))


def error_of(variant):
    """Return the following error of a loop against the reference of the plain one."""
    return _Trial.of(loop(), np.zeros(COUNT)).followed(variant)


def statistics(peak_to_peak, rms):
    return Statistics(peak_to_peak, 0.0, 0.0, rms, 0.0, 0.0)


@pytest.mark.parametrize(
    ("measured", "simulated", "distance"),
    [
        ((2.0, 1.0), (3.0, 1.0), 0.5),
        ((2.0, 1.0), (2.0, 0.4), 0.6),
        ((2.0, 1.0), (1.0, 1.2), 0.5),
        ((0.0, 1.0), (1.0, 1.0), np.inf),
    ],
)
def test_errors_differ_by_their_swing_or_their_rms(measured, simulated, distance):
    assert apart(statistics(*measured), statistics(*simulated)) == pytest.approx(distance)


def test_factors_lie_from_a_sixteenth_to_sixteen_half_an_octave_apart():
    assert (FACTORS[0], FACTORS[-1], FACTORS.size) == (1.0 / 16.0, 16.0, 17)
    assert FACTORS[1:] / FACTORS[:-1] == pytest.approx(np.sqrt(2.0))


def test_scales_change_the_numbers_of_a_law_by_their_units():
    law = controllers.cascade(k_p=10.0, k_v=100.0, k_i=500.0, limit=30.0)
    position, effort = (
        CHANGES[name](loop(controller=law), 2.0).controller.values
        for name in ("position", "effort")
    )
    # k_v is in N s/m: lengths of twice as much are half as many.
    assert [position[name] for name in ("k_p", "k_v", "k_i", "limit")] == pytest.approx(
        [10.0, 200.0, 1000.0, 30.0]
    )
    assert [effort[name] for name in ("k_p", "k_v", "k_i", "limit")] == pytest.approx(
        [10.0, 50.0, 250.0, 15.0]
    )


def test_a_position_gain_a_share_of_velocity_and_a_delay_are_changed_alone():
    plain = loop(run=Run(duration=1.2, sample_time=DT, substeps=1, delay=1))
    assert CHANGES["k_p"](plain, 3.0).controller == LAW.with_values(k_p=30.0)
    assert CHANGES["k_ff"](plain, 0.4).controller == LAW.with_values(k_ff=0.4)
    assert CHANGES["delay"](plain, 2.0).run == replace(plain.run, delay=3)
    surface = controllers.sliding_mode
    passed = {name: 1.0 for name in surface.variables if name not in surface.defaults}
    assert (
        CHANGES["k_p"](
            loop(controller=surface(**passed | {"lambda_": 5.0})), 3.0
        ).controller.values["lambda_"]
        == 15.0
    )


def test_a_reference_that_acts_later_is_moved_by_its_samples():
    later = CHANGES["reference"](
        loop(reference=references.recorded(position=[0.0, 1.0, 3.0], sample_time=DT)), 0.5 * DT
    )
    assert later.reference.values["position"].tolist() == pytest.approx([0.0, 0.5, 2.0])


@pytest.mark.parametrize(
    ("search", "name", "value", "tolerance"),
    [
        (lambda trial: _best_factor(trial, "k_p"), "k_p", 0.6, 0.02),
        (lambda trial: _best_factor(trial, "k_p"), "k_p", 2.2, 0.02),
        (_fed, "k_ff", 0.0, 1e-6),
        (_fed, "k_ff", 0.3, 1e-6),
        (_fed, "k_ff", 1.0, 1e-6),
        (_shifted, "reference", 0.02, 0.05),
        (_shifted, "reference", -0.02, 0.05),
    ],
)
def test_the_change_that_makes_an_error_is_found(search, name, value, tolerance):
    trial = _Trial.of(loop(), error_of(CHANGES[name](loop(), value)))
    outcome = search(trial)
    assert (outcome.name, outcome.value) == (name, pytest.approx(value, rel=tolerance, abs=1e-6))
    assert outcome.difference < 0.05 * trial.difference(loop()) + 1e-9


def test_no_share_of_velocity_is_negative():
    ahead = 2.0 * error_of(loop()) - error_of(CHANGES["k_ff"](loop(), 1.0))
    assert _fed(_Trial.of(loop(), ahead)).value == 0.0


@pytest.mark.parametrize("lost", [0.0, 1.0])
def test_a_loop_that_diverges_at_an_end_has_no_share(lost):
    trial = _Trial.of(loop(), np.zeros(COUNT))

    def followed(variant):
        return None if variant.controller.values["k_ff"] == lost else np.zeros(COUNT)

    half = SimpleNamespace(
        variant=loop(), error=trial.error, judged=trial.judged, followed=followed
    )
    assert _fed(half) == Suspect("k_ff", 1.0, np.inf)


def test_a_resting_reference_has_no_time():
    resting = loop(reference=references.recorded(position=np.zeros(COUNT), sample_time=DT))
    assert _shifted(_Trial.of(resting, np.ones(COUNT))) == Suspect("reference", 0.0, np.inf)


def test_a_trial_compares_samples_after_the_settling_time():
    trial = _Trial.of(loop(), np.ones(70))
    assert trial.variant.run.duration == pytest.approx(70 * DT)
    assert np.flatnonzero(trial.judged)[0] == 20
    assert trial.desired == pytest.approx(loop().reference.values["position"][:70])
    early = error_of(loop()) + np.where(np.arange(COUNT) < 20, 1.0, 0.0)
    assert _Trial.of(loop(), early).difference(loop()) == pytest.approx(0.0, abs=1e-12)


def test_a_loop_agrees_if_both_errors_differ_by_less_than_allowed():
    trial = _Trial.of(loop(), error_of(CHANGES["k_p"](loop(), 2.0)))
    assert trial.agrees(Suspect("k_p", 2.0, 0.0), 1e-9)
    assert not trial.agrees(Suspect("k_p", 1.0, 0.0), 0.1)


@pytest.mark.slow
def test_the_wrong_number_explains_the_error_best():
    first, *_ = explanations(loop(), error_of(CHANGES["delay"](loop(), 4.0)), 0.1)
    assert (first.name, first.value) == ("delay", 4.0)


@pytest.mark.slow
def test_a_loop_that_follows_as_measured_needs_no_explanation():
    assert explanations(loop(), error_of(loop()) + 1e-5 * np.sin(0.9 * np.arange(COUNT)), 0.1) == ()


def test_an_implausible_gain_is_not_promised():
    sides = {
        "measured": statistics(1.0, 2.0),
        "simulated": statistics(3.0, 4.0),
        "compensated": statistics(5.0, 6.0),
    }
    following = Following(np.zeros(1), np.zeros(1), **sides)
    assert following.as_data() == {
        "measured": {"peak_to_peak": 1.0, "rms": 2.0},
        "simulated": {"peak_to_peak": 3.0, "rms": 4.0},
        "compensated": {"peak_to_peak": 5.0, "rms": 6.0},
    }
    assert (
        replace(following, contradiction=Diagnostic("loop_contradicts")).as_data()["compensated"]
        is None
    )
    assert Following(np.zeros(1), np.zeros(1), statistics(1.0, 2.0)).as_data()["simulated"] is None


def log_of(position, reference, segments):
    time = DT * np.arange(len(position))
    channels = {
        "time": Channel(time, "s", "t"),
        "position": Channel(position, "m", "q"),
        "effort": Channel(np.ones(time.size), "N", "u"),
    }
    return Log(
        **channels, reference=Channel(reference, "m", "r"), sample_time=DT, segments=segments
    )


def test_the_error_of_a_log_leaves_out_how_its_first_stretch_settles():
    error = np.ones(300)
    error[:5], error[200:205], error[150] = 100.0, 50.0, 9.0
    log = log_of(np.zeros(300), error, (slice(0, 200), slice(200, 300)))
    assert longest_of(log) == slice(0, 200)
    result = following_of(log)
    # A twentieth of 200 samples.
    assert result.measured.peak_to_peak == 49.0
    assert result.error.tolist() == error[:200].tolist()
    assert result.time == pytest.approx(DT * np.arange(200))
    assert result.measured.rms == pytest.approx(np.sqrt(np.mean(error[10:] ** 2)))
    assert following_of(replace(log, reference=None)) is None
    assert longest_of(log_of(np.zeros(300), error, (slice(0, 100), slice(100, 300)))) == slice(
        100, 300
    )


def test_a_loop_of_an_axis_needs_a_controller_a_reference_and_an_effort():
    motion = 0.05 * (1.0 - np.cos(2.0 * np.arange(300) * DT))
    log, axis = log_of(motion, motion, (slice(0, 300),)), Axis(controller=LAW, decimation=1)
    model = friction.viscous(F_v=20.0)
    assert loop_of(plants.inertia(M=2.0), model, log, axis) is not None
    assert loop_of(plants.inertia(M=2.0), model, log, Axis()) is None
    assert loop_of(plants.inertia(M=2.0), model, replace(log, reference=None), axis) is None
    assert loop_of(plants.inertia(M=2.0), model, replace(log, effort=None), axis) is None


def test_a_loop_of_a_log_is_built_from_the_axis_and_the_log():
    motion = 0.05 * (1.0 - np.cos(2.0 * np.arange(300) * DT))
    log = log_of(motion, motion + 1e-3, (slice(0, 100), slice(100, 300)))
    axis = Axis(
        name="bench",
        controller=LAW,
        resolution=1e-6,
        effort_limit=50.0,
        lag=2e-3,
        presliding=1e-5,
        decimation=1,
    )
    model = friction.coulomb(F_C=3.0)
    experiment = loop_of(plants.inertia(M=2.0), model, log, axis)
    first, _, compensated = experiment.variants
    assert experiment.name == "bench"
    assert first.reference.values["position"] == pytest.approx((motion + 1e-3)[100:])
    assert (first.sensor.values["resolution"], first.run.effort_limit, first.run.current_lag) == (
        1e-6,
        50.0,
        2e-3,
    )
    assert first.friction.values["presliding"] == 1e-5
    assert compensated.feedforward.friction == model
    assert first.start.position == motion[100]
    assert first.start.velocity == pytest.approx(0.1 * np.sin(2.0), rel=1e-3)
    assert first.disturbance.shape == (200,)
    assert first.injected is None
    assert (
        loop_of(plants.inertia(M=2.0), model, log, axis, {"lag": 5e-3}).variants[0].run.current_lag
        == 5e-3
    )


def test_a_loop_that_contradicts_its_log_names_explanations(monkeypatch):
    model, reference = friction.viscous(F_v=20.0), loop().reference.values["position"]
    simulation = simulate(
        compensation_experiment(plants.inertia(M=2.0), model, model, LAW, reference, DT)
    )
    recorded = simulation.variants["as_recorded"]
    same = following_of(log_of(recorded.measured, reference, (slice(0, COUNT),)), simulation)
    assert same.contradiction is None
    assert same.simulated == recorded.following_error
    assert same.compensated == simulation.variants["compensated"].following_error
    suspects = (
        Suspect("reference", -0.02, 1.0),
        Suspect("delay", 3.0, 1.0),
        Suspect("reference", 0.03, 1.0),
    )
    monkeypatch.setitem(following_of.__globals__, "explanations", lambda *_: suspects)
    twice = log_of(2.0 * recorded.measured - reference, reference, (slice(0, COUNT),))
    other = following_of(twice, simulation)
    assert following_of(twice, simulation, Settings.of({"loop_differs": 0.6})).contradiction is None
    numbers = dict(other.contradiction.numbers)
    assert numbers["suspects"] == ("reference_earlier", "delay", "reference_later")
    assert numbers["factors"] == (0.02, 3.0, 0.03)
    assert (numbers["measured"], numbers["measured_rms"]) == (
        other.measured.peak_to_peak,
        other.measured.rms,
    )
    assert (numbers["simulated"], numbers["simulated_rms"]) == (
        recorded.following_error.peak_to_peak,
        recorded.following_error.rms,
    )
    assert other.measured.rms == pytest.approx(2.0 * recorded.following_error.rms)
    assert statistics_of(other.error[5:]).rms == pytest.approx(other.measured.rms)


def test_all_explanations_as_good_as_the_best_are_named(monkeypatch):
    left = {"k_p": 0.1, "position": 0.109, "effort": 0.111}
    trial = SimpleNamespace(
        variant=loop(), difference=lambda variant: 1.0, agrees=lambda suspect, allowed: True
    )
    monkeypatch.setattr(following._Trial, "of", lambda variant, error: trial)
    monkeypatch.setattr(
        following, "_best_factor", lambda trial, name: Suspect(name, 2.0, left[name])
    )
    for name in ("_at", "_fed", "_shifted"):
        # Does not explain half of the difference.
        monkeypatch.setattr(following, name, lambda *asked: Suspect("late", 1.0, 0.6))
    assert [suspect.name for suspect in explanations(loop(), np.zeros(COUNT), 0.1)] == [
        "k_p",
        "position",
    ]
