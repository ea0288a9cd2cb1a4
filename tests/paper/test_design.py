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
from bristle.loop import assess, error_budget
from bristle.paper.tracking import Sound, Tracked
from bristle.simulation import simulate

pytestmark = pytest.mark.slow

EXPERIMENTS = files("bristle.paper") / "experiments"
SET_A = EXPERIMENTS / "set_a.toml"


@cache
def loops():
    return {variant.name: variant for variant in read_experiment(SET_A).variants}


def delayed(delay, name="paper"):
    return replace(loops()[name], run=replace(loops()[name].run, delay=delay))


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


def test_the_error_budget_of_the_paper_s_compensator():
    budget = error_budget(replace(loops()["paper"], run=replace(loops()["paper"].run, duration=12.0, seeds=1)))
    alone = {entry.cause: entry.alone.peak_to_peak for entry in budget.entries}
    assert set(alone) == {"amplitude", "shape", "asymmetry", "irregularity", "encoder", "delay"}
    # Amplitude and encoder dominate; the shape of the loops hardly matters.
    assert min(alone["amplitude"], alone["encoder"]) > 1.5 * max(alone["shape"], alone["irregularity"], alone["delay"])
    assert budget.no_cause.peak_to_peak < 0.01e-6
