"""The loop of Set A designed: what its margins are, what is refused, what limits it, and what goes past it."""

import re
from dataclasses import replace
from functools import cache
from importlib.resources import files

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.signal import cont2discrete
from tests.docs.conftest import ROOT

from bristle.files import read_experiment
from bristle.loop import Verdict, assess, error_budget, proposals_for, runnable
from bristle.paper.tracking import Sound, Tracked
from bristle.report.messages import message
from bristle.simulation import simulate

pytestmark = pytest.mark.slow

EXPERIMENTS = files("bristle.paper") / "experiments"
SET_A = EXPERIMENTS / "set_a.toml"


def told_of(assessment):
    return [message(item) for item in assessment.doubts]


@cache
def loops():
    return {variant.name: variant for variant in read_experiment(SET_A).variants}


def delayed(delay, name="paper"):
    return replace(loops()[name], run=replace(loops()[name].run, delay=delay))


@pytest.mark.parametrize(
    ("delay", "outside", "inside", "radius"),
    [(0, 41.5, 30.8, 0.886), (1, 21.1, 3.6, 0.986), (2, 0.8, -23.5, 1.062), (3, -19.5, -50.6, 1.096)],
)
def test_margins_of_set_a_by_its_file(delay, outside, inside, radius):
    small, large = assess(delayed(delay)).bare
    assert large.margins.phase == pytest.approx(outside, abs=1.0)
    assert small.margins.phase == pytest.approx(inside, abs=1.0)
    assert small.loop.spectral_radius == pytest.approx(radius, abs=1e-3)


def test_the_page_on_design_states_these_margins():
    page = (ROOT / "docs" / "how-to" / "design-a-loop.md").read_text().replace("−", "-")
    rows = re.findall(r"^\| (\d) \| (-?[\d.]+)° \| (-?[\d.]+)° \| ([\d.]+) \|", page, re.MULTILINE)
    assert len(rows) == 4
    for delay, *text in rows:
        small, large = assess(delayed(int(delay))).bare
        result = (large.margins.phase, small.margins.phase, small.loop.spectral_radius)
        assert [round(result[0], 1), round(result[1], 1), round(result[2], 3)] == [float(item) for item in text]


def margins_by_transfer_functions(g):
    """Phase margin [deg] and gain margin of set C, by transfer functions: a free mass, drive and delay."""
    T, M, rate, lag, cutoff = 0.5e-3, 631.65, 150.0, 0.2e-3, 400.0
    numerator, denominator, _ = cont2discrete(([1.0], [M * lag, M, 0.0, 0.0]), T)
    kept, fades = np.exp(-2.0 * np.pi * cutoff * T), np.exp(-g * T)

    def open_loop(omega):
        z = np.exp(1j * omega * T)
        plant = np.polyval(numerator[0], z) / np.polyval(denominator, z) / z
        speed = (1.0 - kept) / (1.0 - kept / z) * (1.0 - 1.0 / z) / T
        by_itself = M * (2.0 * rate * speed + rate**2)
        seen = (1.0 - fades) / (1.0 - fades / z)  # of what is commanded, and of the momentum times g
        return plant * (by_itself + g * M * speed * (1.0 - seen)) / (1.0 - seen / z)

    crossover = brentq(lambda w: abs(open_loop(w)) - 1.0, 150.0, 1500.0)
    turn = brentq(lambda w: open_loop(w).imag, 600.0, 3000.0)
    return np.degrees(np.angle(-open_loop(crossover))), -1.0 / open_loop(turn).real


@pytest.mark.parametrize(("name", "g", "told"), [("none", 0.0, (51.9, 3.99)), ("observer", 60.0, (43.4, 3.30))])
def test_margins_of_set_c(name, g, told):
    sound = Sound(Tracked(EXPERIMENTS / "set_c.toml"), Tracked(EXPERIMENTS / "set_a_break_away.toml"))
    # The least of the free mass, of one that is stuck and of one that slides: that of the free one.
    phase, gain = sound.margins[name]
    assert (phase, gain) == pytest.approx(margins_by_transfer_functions(g), rel=1e-4)
    assert (round(phase, 1), round(gain, 2)) == told
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert "at least 43° of phase and 3.3 of gain" in readme


def test_two_samples_are_flagged_inside_the_layer_and_three_are_refused():
    experiment = replace(read_experiment(SET_A), variants=tuple(replace(delayed(delay), name=str(delay)) for delay in range(4)))
    kept, judged = runnable(experiment)
    assert [variant.name for variant in kept.variants] == ["0", "1", "2"]
    assert judged["2"].verdict is Verdict.OSCILLATES
    assert "pole at 1.062. Cause: two samples of delay" in message(judged["2"].finding)
    assert "pole at 1.096. Cause: three samples of delay" in message(judged["3"].finding)


def test_two_samples_of_delay_degrade_and_three_diverge_as_their_poles_say():
    # Past the refusal: what is named before the simulation is what the simulation does.
    actual = {}
    for delay in (1, 2, 3):
        item = delayed(delay, "identified")
        actual[delay] = replace(item, name=str(delay), run=replace(item.run, duration=10.0, seeds=1))
    result = simulate(replace(read_experiment(SET_A), variants=tuple(actual.values())))
    error = [result.variants[str(delay)].following_error.peak_to_peak for delay in (1, 2, 3)]
    assert 1.8 * error[0] < error[1]
    assert 10.0 * error[1] < error[2] or not error[2] < 1.0


@cache
def low_gain(name):
    variants = read_experiment(EXPERIMENTS / "low_gain.toml").variants
    result = next(variant for variant in variants if variant.name == name)
    return replace(result, run=replace(result.run, duration=14.0, seeds=1))


def measured_is_warned_of(variant):
    return any("along the measured motion" in text for text in told_of(assess(variant)))


def test_feedforward_along_the_measured_motion_causes_a_warning_at_low_gain():
    assert [measured_is_warned_of(low_gain(name)) for name in ("none", "desired", "measured")] == [False, False, True]
    high = loops()["paper"]
    assert not measured_is_warned_of(replace(high, feedforward=replace(high.feedforward, along="measured")))


def test_the_design_of_a_low_gain_loop_shows_the_gain_of_the_desired_motion():
    present, desired, *_ = proposals_for(low_gain("measured"))
    assert (present.name, desired.name) == ("as it is", "along the desired motion")
    assert present.following_error.peak_to_peak > 1.6 * desired.following_error.peak_to_peak


def test_no_more_than_the_existing_stiffness_is_compensated():
    item = low_gain("measured")
    too_much = replace(item, feedforward=replace(item.feedforward, gain=1.5))
    result = assess(too_much)
    assert result.verdict is Verdict.OSCILLATES
    assert "removes more stiffness than the axis has" in message(result.finding)


def test_the_error_budget_of_the_paper_s_compensator():
    budget = error_budget(replace(loops()["paper"], run=replace(loops()["paper"].run, duration=12.0, seeds=1)))
    alone = {entry.cause: entry.alone.peak_to_peak for entry in budget.entries}
    assert set(alone) == {"amplitude", "shape", "asymmetry", "irregularity", "encoder", "delay"}
    # Amplitude and encoder dominate; the shape of the loops hardly matters.
    assert min(alone["amplitude"], alone["encoder"]) > 1.5 * max(alone["shape"], alone["irregularity"], alone["delay"])
    assert budget.no_cause.peak_to_peak < 0.01e-6


def test_an_observer_with_margins_goes_past_the_paper():
    item = replace(loops()["paper"], run=replace(loops()["paper"].run, duration=10.0, seeds=1))
    proposed = {each.name: each for each in proposals_for(item)}
    present, observer = proposed["as it is"], proposed["with an observer"]
    assert observer.following_error.peak_to_peak < 0.7 * present.following_error.peak_to_peak
    assert min(point.margins.phase for point in observer.assessment.bare) >= 40.0
