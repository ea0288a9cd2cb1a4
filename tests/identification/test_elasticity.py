"""An elastic drive is reported by its signature, without a friction model."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, Motion, log_of, sines, sliding_effort

from bristle.identification import identify
from bristle.identification.elasticity import FEWEST_BLOCKS, _Resonance, elastic_coupling
from bristle.report.messages import message

MASS, LEVEL, LOOP, DT = 12.0, 8.0, 25.0, 1e-3  # kg, N, Hz, s


def two_masses(reference, frequency, share, seed=0, noise=0.1):
    """Motion and effort of a motor in a loop, with a share of mass and friction behind a spring; friction turns with the reference."""
    laplace = 2j * np.pi * np.fft.rfftfreq(reference.time.size, DT)
    wanted, rubs = np.fft.rfft(reference.position), np.fft.rfft(LEVEL * np.where(reference.velocity < 0.0, -1.0, 1.0))
    own, pace = (laplace / (2.0 * np.pi * frequency)), 2.0 * np.pi * LOOP
    load = 1.0 / (1.0 + 0.04 * own + own**2) if share else 1.0
    felt, lead = MASS * (1.0 - share + share * load), MASS * (pace**2 + 1.4 * pace * laplace)
    behind = rubs * (1.0 - share + share * load)
    x = ((lead + MASS * laplace**2) * wanted - behind) / (felt * laplace**2 + lead)
    effort = felt * laplace**2 * x + behind
    q, v, a, u = (np.fft.irfft(signal, reference.time.size) for signal in (x, laplace * x, laplace**2 * x, effort))
    return Motion(reference.time, q, v, a), u + np.random.default_rng(seed).normal(0.0, noise, u.size)


@pytest.fixture(scope="module")
def motion():
    return sines(40.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.3, 0.85, 2.3))


def coupling_of(motion, frequency=43.0, share=0.4, cutoff=100.0, *, seed=0, noise=0.1, measured=lambda effort: effort):
    """The coupling that shows where inertia and friction are those of the truth."""
    moved, effort = two_masses(motion, frequency, share, seed, noise)
    segment = SimpleNamespace(time=moved.time, velocity=moved.velocity, effort=measured(effort))
    dataset = SimpleNamespace(
        segments=(segment,),
        sample_time=DT,
        dropped=20,
        cutoff=cutoff,
        friction_along=lambda *_: [LEVEL * np.where(motion.velocity < 0.0, -1.0, 1.0)],
        mechanical_along=lambda *_: MASS * moved.acceleration,
        without_edges=lambda signal: signal[20:-20],
    )
    return elastic_coupling(dataset, None, None)


@pytest.mark.parametrize("frequency", [17.0, 43.0])
def test_antiresonance_and_load_are_those_of_the_axis(motion, frequency):
    coupling = coupling_of(motion, frequency)
    assert coupling.antiresonance == pytest.approx(frequency, rel=0.15)
    assert coupling.share > 0.3
    moved, effort = two_masses(motion, frequency, 0.4, noise=0.0)
    lacking = effort - MASS * moved.acceleration - LEVEL * np.where(motion.velocity < 0.0, -1.0, 1.0)
    assert coupling.force == pytest.approx(float(np.std(lacking)), rel=0.4)


@pytest.mark.parametrize("seed", range(4))
def test_a_rigid_axis_has_no_coupling_for_any_noise_lag_and_delay(motion, seed):
    for measured in (lambda effort: effort, lambda effort: np.roll(effort, 3), behind_lag):
        assert coupling_of(motion, share=0.0, seed=seed, noise=0.3, measured=measured) is None


def behind_lag(signal, lag=4e-3):
    return np.fft.irfft(np.fft.rfft(signal) / (1.0 + 2j * np.pi * np.fft.rfftfreq(signal.size, DT) * lag), signal.size)


def test_a_coupling_not_excited_or_beyond_the_filter_is_not_reported(motion):
    assert coupling_of(motion, noise=0.1) is not None
    assert coupling_of(motion, noise=30.0) is None
    assert coupling_of(motion, cutoff=20.0) is None


def test_a_log_of_few_blocks_shows_no_coupling():
    motion = sines(4.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.3, 0.85, 2.3))
    assert motion.time.size / 250 < FEWEST_BLOCKS
    assert coupling_of(motion) is None


def codes_of(fit):
    return [diagnostic.code for diagnostic in fit.diagnostics]


def named_models(fit):
    return {diagnostic.numbers.get("model") for diagnostic in fit.diagnostics} - {None, ""}


def test_an_elastic_axis_is_reported_without_a_friction_model(motion):
    moved, effort = two_masses(motion, 43.0, 0.4)
    log = log_of(moved, effort, step=1e-8)
    static = identify(log, "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
    assert codes_of(static)[:2] == ["structure", "missing_presliding"]  # a contact that gives way is a spring, too
    best = identify(log, "lugre", axis=STATED, blocks=0, draws=0).best
    assert codes_of(best)[:2] == ["structure", "elastic_load"]
    assert not named_models(best)
    assert "filter_suspect" not in codes_of(best)
    text = message(best.diagnostics[1])
    assert text.startswith("the load is coupled elastically, with an antiresonance near 4")


def test_a_periodic_encoder_error_is_not_a_force_over_the_position():
    motion = sines(20.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.3, 0.85, 2.3))
    effort = sliding_effort(motion, noise=0.1)
    shifted = motion._replace(position=motion.position + 4e-6 * np.sin(2.0 * np.pi * motion.position / 0.01))
    best = identify(log_of(shifted, effort, step=1e-8), "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
    assert "missing_ripple" not in codes_of(best)
    rippled = effort + 0.1 * np.sin(2.0 * np.pi * motion.position / 0.01)
    best = identify(
        log_of(motion, rippled, step=1e-8), "coulomb_viscous", axis=STATED, blocks=0, draws=0, settings={"missing_evidence": 1e-4}
    ).best
    assert "missing_ripple" in codes_of(best)


def test_a_clear_resonance_is_significant_large_and_partly_below_its_frequency():
    resonance = _Resonance(frequency=50.0, ratio=0.5, of_friction=0.1, gain=40.0, below=10.0, share=0.2, least=30.0)
    assert resonance.clear
    for doubt in ({"gain": 29.0}, {"share": 0.09}, {"below": 7.0}, {"below": 41.0}):
        assert not resonance._replace(**doubt).clear, doubt
