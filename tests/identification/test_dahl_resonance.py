"""Sweeps of small amplitude show stiffness and damping of the contact, without a friction model."""

from dataclasses import replace
from functools import partial
from itertools import accumulate
from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.rigid import identify

from bristle.identification.dahl_resonance import Compared, DahlResonance, dahl_resonance
from bristle.logs.log import Log
from bristle.report.summary import identification_summary
from bristle.report.sweep import sweep_lines, sweep_table

MASS, DAMPING, DT, STEP = 3.0, 120.0, 5e-4, 5e-9  # kg, N*s/m, s, m
SPRINGS, SLIPS = np.array([4e4, 3e4, 2e4, 2e4]), np.array([0.6e-6, 1.1e-6, 2e-6, 6e-6])  # N/m, m
STIFFNESS = 1.1e5  # N/m, of all elements before slip


def chirps(amplitudes, *, low=6.0, high=75.0, seconds=5.0):
    """Position [m] of chirps, each after a rest, with velocity and acceleration."""
    t = np.arange(round(seconds / DT)) * DT
    rate = np.log(high / low) / seconds
    fade = np.clip(np.minimum(t, seconds - t) / 0.2, 0.0, 1.0)
    wave = fade * fade * (3.0 - 2.0 * fade) * np.sin(2.0 * np.pi * low * np.expm1(rate * t) / rate)
    position = np.concatenate(
        [part for size in amplitudes for part in (np.zeros(400), size * wave)]
    )
    laplace, spectrum = 2j * np.pi * np.fft.rfftfreq(position.size, DT), np.fft.rfft(position)
    return position, *(np.fft.irfft(laplace**order * spectrum, position.size) for order in (1, 2))


def rubbed(position):
    """Force of springs in series with dry sliders, one after the other."""
    steps = np.diff(position).tolist()

    def pulled(stretch, step, slip):
        return min(max(stretch + step, -slip), slip)

    stretches = (
        list(accumulate(steps, partial(pulled, slip=slip), initial=0.0)) for slip in SLIPS.tolist()
    )
    return sum(
        spring * np.array(stretch) for spring, stretch in zip(SPRINGS, stretches, strict=True)
    )


def recorded(
    amplitudes=(0.1e-6, 0.2e-6, 0.4e-6, 0.8e-6),
    *,
    constant=0.0,
    late=0,
    noise=2e-4,
    further=0.0,
    seed=0,
    **motion,
):
    """The log of an axis; `further` is another force."""
    draw = np.random.default_rng(seed)
    position, velocity, acceleration = chirps(amplitudes, **motion)
    effort = (
        MASS * acceleration
        + DAMPING * velocity
        + rubbed(position)
        + constant
        + further
        + noise * draw.standard_normal(position.size)
    )
    read = STEP * np.round((position + 0.3 * STEP * draw.standard_normal(position.size)) / STEP)
    return Log.from_columns(
        {"time": DT * np.arange(position.size), "position": read, "effort": np.roll(effort, late)}
    )


def holds(found):
    values = (
        (found.stiffness, STIFFNESS, found.stiffness_half_width),
        (found.damping, DAMPING, found.damping_half_width),
    )
    return all(
        abs(value - truth) <= half < 0.1 * truth
        for value, truth, half in (*values, (found.mass, MASS, found.mass_half_width))
    )


@pytest.fixture(scope="module")
def log():
    return recorded()


@pytest.fixture(scope="module")
def sweep(log):
    return dahl_resonance([log], STEP)


def test_stiffness_damping_and_mass_are_those_of_the_axis_and_depend_on_the_amplitude(sweep):
    assert holds(sweep)
    assert sweep.stiffnesses[-1] < 0.95 * min(sweep.stiffnesses[:-1])
    assert sweep.losses[-1] > 5.0 * max(sweep.losses[:-1])


@pytest.mark.parametrize(
    "changed",
    [
        {"constant": 5.0},
        {"late": 3},
        {"constant": -1.0, "late": 1, "noise": 2e-3, "seed": 3},
        {"amplitudes": (0.1e-6, 0.3e-6, 0.8e-6, 60e-6)},
    ],
)
def test_constant_force_delay_noise_and_windows_of_larger_amplitude_do_not_change_the_values(
    changed,
):
    found = dahl_resonance([recorded(**changed)], STEP)
    assert holds(found)
    assert found.amplitudes[-1] < 2e-6


def test_the_loss_extrapolates_the_stiffness_where_each_amplitude_slips():
    found = dahl_resonance([recorded((0.7e-6, 0.9e-6, 1.2e-6, 1.6e-6), low=4.0)], STEP)
    assert found.stiffness == pytest.approx(STIFFNESS, rel=0.03)
    assert found.stiffnesses[-1] < 0.85 * found.stiffness


def test_a_coarse_encoder_widens_the_intervals(log, sweep):
    coarse = dahl_resonance([log], 10.0 * STEP)
    assert coarse.stiffness == pytest.approx(sweep.stiffness, rel=0.02)
    assert coarse.stiffness_half_width > 1.5 * sweep.stiffness_half_width


def test_logs_of_one_axis_are_one_sweep():
    assert holds(
        dahl_resonance([recorded((size,), seed=3) for size in (0.15e-6, 0.4e-6, 0.8e-6)], STEP)
    )


@pytest.mark.parametrize(
    "motion",
    [{"amplitudes": (0.15e-6,)}, {"amplitudes": (40e-6, 100e-6)}, {"low": 20.0, "high": 40.0}],
)
def test_one_amplitude_sliding_and_few_frequencies_are_no_sweep(motion):
    assert dahl_resonance([recorded(**motion)], STEP) is None


def test_frequencies_of_an_elastic_load_are_left_out(log, sweep):
    assert (
        dahl_resonance([log], STEP, highest=15.0)
        == "the load is coupled elastically, and the sweep has too few frequencies below 15 Hz"
    )
    below = dahl_resonance([log], STEP, highest=50.0)
    assert abs(below.stiffness - STIFFNESS) < below.stiffness_half_width
    assert below.mass_half_width > sweep.mass_half_width


@pytest.mark.slow
def test_a_response_of_two_masses_is_refused():
    position, _, _ = chirps((0.1e-6, 0.2e-6, 0.4e-6, 0.8e-6))
    hertz = np.fft.rfftfreq(position.size, DT)
    load = (
        2.0 * (2.0 * np.pi * hertz) ** 2 * -1.0 / (1.0 - (hertz / 25.0) ** 2 + 0.05j * hertz / 25.0)
    )
    assert dahl_resonance(
        [recorded(further=np.fft.irfft(load * np.fft.rfft(position), position.size))], STEP
    ).startswith("the response is not that of one mass on a spring")


@pytest.mark.parametrize(
    ("fitted", "half", "differs"),
    [
        (1.3, 0.05, True),
        (1.07, 0.05, False),
        (1.015, 0.001, False),
        (1.3, None, False),
        (None, None, False),
    ],
)
def test_sweep_and_fit_contradict_each_other_beyond_their_intervals(fitted, half, differs):
    assert Compared("stiffness", "N/m", 1.0, 0.005, fitted, half).differs is differs


def reported(sweep, **quantities):
    items = [Compared(name, "N/m", 1e5, 1e3, *fitted) for name, fitted in quantities.items()]
    sweep = (
        sweep
        if isinstance(sweep, str) or sweep is None
        else SimpleNamespace(compared_with=lambda *_: items)
    )
    return SimpleNamespace(
        sweep=sweep, best=SimpleNamespace(name="lugre", plant=None, friction=None, estimates=())
    )


@pytest.mark.parametrize(
    ("sweep", "fitted", "text"),
    [
        (
            True,
            {"stiffness": (2e5, 1e3), "damping": (1e5, 1e3)},
            [
                "stiffness 100 kN/m ± 1.00 %, damping 100 kN/m ± 1.00 %",
                "The fit contradicts the sweep in stiffness. Prefer the sweep",
            ],
        ),
        (True, {"stiffness": (1e5, 1e3)}, ["stiffness 100 kN/m ± 1.00 %"]),
        ("too few", {}, ["no stiffness: too few"]),
        (None, {}, []),
    ],
)
def test_the_terminal_reports_a_contradiction_in_a_sentence(sweep, fitted, text):
    assert [line.text for line in sweep_lines(reported(sweep, **fitted))] == text


@pytest.mark.slow
def test_an_identification_reports_the_sweep_beside_its_fit(log, sweep):
    found = identify(log, "dahl", draws=0, blocks=0)
    assert isinstance(found.sweep, DahlResonance)
    assert found.sweep.stiffness == pytest.approx(sweep.stiffness, rel=1e-9)
    stiffness, damping = found.sweep.compared_with(
        found.best.plant, found.best.friction, found.best.estimates
    )
    assert stiffness.fitted == found.best.parameters["sigma_0"].value
    assert damping.fitted == found.best.parameters["sigma_2"].value
    assert [row[0] for row in sweep_table(found).rows] == ["Stiffness", "Damping"]
    without = {"table": [], "simulation": None, "prediction": None, "provenance": {}}
    entry = identification_summary(found, **without)["sweep"]
    assert entry["quantities"]["stiffness"]["value"] == found.sweep.stiffness
    assert "sweep" not in identification_summary(replace(found, log=recorded((0.2e-6,))), **without)
