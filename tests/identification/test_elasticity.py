"""An elastic drive is reported from the frequency response of the motor, before any friction model."""

import numpy as np
import pytest
from benchmarks.elastic import tried
from tests.identification.known_logs import STATED, Motion, log_of
from tests.identification.rigid import identify

from bristle import identification
from bristle.identification.elasticity import Elastic, elastic_coupling
from bristle.report.messages import message

MASS, LEVEL, LOOP, DT = 12.0, 8.0, 25.0, 1e-3  # kg, N, Hz, s


def two_masses(frequency, share, *, seed=0, noise=0.1, strength=4.0, seconds=40.0, highest=200.0):
    """Motion and effort of a motor in a loop, with a share of mass and friction behind a spring, and noise injected up to a frequency."""
    count, draw = round(seconds / DT), np.random.default_rng(seed)
    time = DT * np.arange(count)
    hertz = np.fft.rfftfreq(count, DT)
    laplace = 2j * np.pi * hertz
    turns = np.sign(np.sin(2.0 * np.pi * time / 5.0 + 0.3))
    wanted = np.fft.rfft(0.06 * np.sin(2.0 * np.pi * time / 5.0 + 0.3 + 0.5 * np.pi))
    rubs = np.fft.rfft(-LEVEL * turns)
    pushes = np.fft.rfft(strength * draw.normal(size=count)) * ((hertz > 2.0) & (hertz < highest))
    own, pace = (laplace / (2.0 * np.pi * frequency)), 2.0 * np.pi * LOOP
    load = 1.0 / (1.0 + 0.04 * own + own**2) if share else 1.0
    felt, lead = MASS * (1.0 - share + share * load), MASS * (pace**2 + 1.4 * pace * laplace)
    behind = rubs * (1.0 - share + share * load)
    x = ((lead + MASS * laplace**2) * wanted + pushes - behind) / (felt * laplace**2 + lead)
    effort = felt * laplace**2 * x + behind
    q, v, a, u = (
        np.fft.irfft(signal, count) for signal in (x, laplace * x, laplace**2 * x, effort)
    )
    return Motion(time, q, v, a), u + draw.normal(0.0, noise, count)


def coupling_of(frequency=43.0, share=0.4, *, step=1e-7, measured=lambda effort: effort, **further):
    moved, effort = two_masses(frequency, share, **further)
    return elastic_coupling([log_of(moved, measured(effort), step=step)], [None])


def behind_lag(signal, lag=4e-3):
    return np.fft.irfft(
        np.fft.rfft(signal) / (1.0 + 2j * np.pi * np.fft.rfftfreq(signal.size, DT) * lag),
        signal.size,
    )


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("frequency", "share"),
    [(17.0, 0.4), (80.0, 0.7), pytest.param(43.0, 0.2, marks=pytest.mark.slow)],
)
def test_antiresonance_resonance_ratio_and_mass_are_those_of_the_axis(frequency, share):
    coupling, ratio = (
        coupling_of(frequency, share, measured=lambda effort: np.roll(effort, 2)),
        share / (1.0 - share),
    )
    assert coupling.antiresonance == pytest.approx(frequency, rel=0.02)
    assert coupling.resonance == pytest.approx(frequency * (1.0 + ratio) ** 0.5, rel=0.02)
    assert coupling.inertia_ratio == pytest.approx(ratio, rel=0.1)
    assert coupling.mass == pytest.approx(MASS, rel=0.01)
    assert coupling.delay == pytest.approx(2.0 * DT, abs=0.3 * DT)
    assert (
        abs(coupling.antiresonance - frequency)
        < coupling.antiresonance_half_width
        < 0.05 * frequency
    )


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "strength"), [(1.0, 8.0), (0.5, 4.0)])
def test_noise_of_the_effort_does_not_raise_the_mass(noise, strength):
    coupling = coupling_of(noise=noise, strength=strength)
    assert coupling.mass == pytest.approx(MASS, rel=0.01)
    assert coupling.inertia_ratio == pytest.approx(0.4 / 0.6, rel=0.05)
    assert abs(coupling.mass - MASS) < coupling.mass_half_width


def held(effort):
    return np.fft.irfft(
        np.fft.rfft(effort) / np.sinc(DT * np.fft.rfftfreq(effort.size, DT)), effort.size
    )


def averaged(effort):
    return np.fft.irfft(
        np.fft.rfft(effort) * np.sinc(DT * np.fft.rfftfreq(effort.size, DT)), effort.size
    )


@pytest.mark.parametrize("measured", [averaged, pytest.param(held, marks=pytest.mark.slow)])
def test_an_effort_that_is_held_or_averaged_over_a_sample_has_the_same_mass(measured):
    coupling = coupling_of(80.0, 0.7, measured=measured)
    assert coupling.mass == pytest.approx(MASS, rel=0.005)
    assert coupling.inertia_ratio == pytest.approx(0.7 / 0.3, rel=0.03)


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize(
    "measured",
    [lambda effort: effort, behind_lag, lambda effort: np.roll(effort, 3)],
    ids=["", "lag", "delay"],
)
@pytest.mark.parametrize("seed", [0, 1])
def test_a_rigid_axis_has_no_coupling_for_any_noise_lag_and_delay(measured, seed):
    assert coupling_of(share=0.0, seed=seed, noise=0.3, measured=measured) is None


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize(
    "recorded",
    [
        {"noise": 30.0, "strength": 0.2},
        {"seconds": 4.0},
        {"highest": 20.0, "strength": 1.0, "step": 1e-6},
    ],
)
def test_a_coupling_that_is_not_excited_is_not_reported(recorded):
    assert coupling_of(**recorded) is None


def codes_of(fit):
    return [diagnostic.code for diagnostic in fit.diagnostics]


def named_models(fit):
    return {diagnostic.numbers.get("model") for diagnostic in fit.diagnostics} - {None, ""}


@pytest.fixture(scope="module")
def log():
    return log_of(*two_masses(43.0, 0.4), step=1e-7)


@pytest.fixture(scope="module")
def identified(log):
    return identification.identify(log, "coulomb_viscous", blocks=0, draws=0)


@pytest.mark.parametrize(
    "model", ["coulomb_viscous", pytest.param("lugre", marks=pytest.mark.slow)]
)
def test_an_elastic_axis_is_reported_first_and_without_a_friction_model(identified, log, model):
    best = (
        identified
        if model == "coulomb_viscous"
        else identification.identify(log, model, blocks=0, draws=0)
    ).best
    assert codes_of(best)[0] == "elastic_load"
    assert not named_models(best)
    assert "filter_suspect" not in codes_of(best)
    assert message(best.diagnostics[0]).startswith(
        "the load is coupled elastically. Motor effort to motor speed has an antiresonance at 4"
    )


def test_the_low_band_has_the_sum_of_the_masses_and_a_stated_cutoff_wins(identified):
    assert identified.treatment["cutoff"] < 0.25 * 43.0
    assert identified.best.parameters["M"].value == pytest.approx(MASS, rel=0.01)
    assert identified.treatment["antiresonance"] == pytest.approx(43.0, rel=0.02)
    assert identified.best.diagnostics[0].numbers["one_mass"]
    coupling = Elastic(43.0, 0.5, 55.5, 0.5, 0.67, 0.05, MASS, 0.1, 0.0, 1e-4)
    short = log_of(*two_masses(43.0, 0.4, seconds=8.0))
    stated = identify(
        short, "coulomb_viscous", axis=STATED, blocks=0, draws=0, cutoff=90.0, coupling=coupling
    )
    assert stated.treatment["cutoff"] == 90.0
    assert not stated.best.diagnostics[0].numbers["one_mass"]


@pytest.mark.parametrize("ratio", [0.2, 1.0, 5.0])
def test_up_to_the_band_of_one_mass_the_motor_feels_two_per_cent_more(ratio):
    coupling = Elastic(
        40.0, 0.1, 40.0 * (1.0 + ratio) ** 0.5, 0.1, ratio, 0.01, MASS, 0.1, 0.0, 1e-4
    )
    motor, s = MASS / (1.0 + ratio), 2j * np.pi * coupling.one_mass
    load, stiffness = MASS - motor, (MASS - motor) * (2.0 * np.pi * 40.0) ** 2
    moved = np.linalg.solve(
        [[motor * s**2 + stiffness, -stiffness], [-stiffness, load * s**2 + stiffness]], [1.0, 0.0]
    )
    assert abs(1.0 / (s**2 * moved[0])) == pytest.approx(1.02 * MASS, rel=1e-6)


# Without and with play; `benchmarks.elastic` measures the rates over sixty drives.
SEEDS = (501, 504, 505, 509, 510, 511)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_an_elastic_drive_is_reported_first_and_a_rigid_axis_is_not(seed):
    drive, rigid = tried(seed, True), tried(seed, False)
    assert drive.reported
    assert drive.first
    assert not drive.suggested
    assert abs(drive.antiresonance) < 5.0
    assert abs(drive.resonance) < 5.0
    assert not rigid.reported
