"""Intervals from replicates of a log contain the truth, and each correction is tested separately.

One number for the coverage does not see most corrections: what one of them no longer explains, another one takes over.
So each has a log of its own here, in which it is what counts, with the answer known from elsewhere: Student's interval
of a mean, the chi-square interval of a variance, the spread over many logs, or the truth that was simulated."""

import math
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from scipy import stats
from scipy.signal import lfilter
from tests.identification.known_logs import (
    STATED,
    TRUTH,
    Motion,
    log_of,
    sines,
    sliding_effort,
    slow_log,
)
from tests.identification.rigid import identify
from tests.identification.test_preprocessing import trapezoids

import bristle as br
from bristle import controllers, friction, plants, sensors
from bristle.core import Axis
from bristle.engine import run_closed_loop, run_open_loop
from bristle.identification import Fit
from bristle.identification.half_cycles import Disturbance, Groups, scatter_in
from bristle.identification.inverse_dynamics import InverseDynamics, RowReplicates
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat
from bristle.logs.log import Channel, Log
from bristle.prediction import predict

DT = 1e-3
MASS, LEVEL, SCATTER = 12.0, 8.0, 0.05
FEW = (4, 5, 6)  # half-cycles
HALF_CYCLE = 0.4  # s
MOTION, NAMES = sines(4.0), tuple(TRUTH)
LASTING, SIZE = 0.02, 0.5  # s, N: noise of first order
ROUNDED = {"F_C": 8.0, "F_S": 10.0, "v_S": 5e-3, "sigma_0": 1e6, "sigma_1": 3795.0, "sigma_2": 40.0}
LAW, WAVE = controllers.cascade(k_p=80.0, k_v=3000.0), 0.27  # of the loops; a period [s]


def half_width(estimate) -> float:
    low, high = estimate.interval
    return 0.5 * (high - low)


def swings(count: int, amplitude: float = 0.02) -> Motion:
    """Half-cycles of a cosine, to and fro."""
    t, w = DT * np.arange(round(count * HALF_CYCLE / DT)), np.pi / HALF_CYCLE
    return Motion(
        t,
        *(amplitude * item for item in (-np.cos(w * t), w * np.sin(w * t), w * w * np.cos(w * t))),
    )


def side_of(motion: Motion) -> np.ndarray:
    return np.where(motion.velocity < 0.0, -1.0, 1.0)


class Levelled(NamedTuple):
    """A fit of Coulomb friction to a log in which each half-cycle has its own level, and those levels."""

    fit: Fit
    levels: np.ndarray


@cache
def levelled(count: int) -> Levelled:
    motion, rng = swings(count), np.random.default_rng(count)
    levels = LEVEL * (1.0 + SCATTER * rng.standard_normal(count))
    effort = MASS * motion.acceleration + np.repeat(levels, motion.time.size // count) * side_of(
        motion
    )
    log = log_of(motion, effort + 0.05 * rng.standard_normal(effort.size))
    return Levelled(
        identify(log, "coulomb", mass=MASS, offset=0.0, axis=STATED, blocks=0, draws=140).best,
        levels,
    )


@pytest.mark.slow
def test_the_mean_of_few_levels_has_students_interval():
    # From 4 to 6 levels Student's factor is 3.2 to 2.6: nobody knows the scatter of so few.
    shares = [
        half_width(levelled(count).fit.parameters["F_C"])
        / (stats.t.ppf(0.975, count - 1) * stats.sem(levelled(count).levels))
        for count in FEW
    ]
    assert 0.8 < np.mean(shares) < 1.2


@pytest.mark.slow
def test_the_scatter_is_that_of_the_levels_not_of_the_residual():
    shares = [
        levelled(count).fit.resampling.scatter.value
        * LEVEL
        / np.std(levelled(count).levels, ddof=1)
        for count in FEW
    ]
    assert 0.92 < np.mean(shares) < 1.08


@pytest.mark.slow
@pytest.mark.parametrize("count", FEW)
def test_the_scatter_has_the_interval_of_chi_square(count):
    scatter = levelled(count).fit.resampling.scatter
    for end, tail in ((scatter.low, 0.975), (scatter.high, 0.025)):
        assert end / scatter.value == pytest.approx(
            ((count - 1) / stats.chi2.ppf(tail, count - 1)) ** 0.5, rel=0.15
        )


@cache
def noisy():
    """A fit to a log with only white noise of the effort."""
    return identify(
        log_of(MOTION, sliding_effort(MOTION, noise=0.3)), "coulomb_viscous", blocks=0, draws=40
    ).best


@pytest.mark.slow
def test_noise_changes_a_linear_fit_symmetrically():
    for name in NAMES:
        item = noisy().parameters[name]
        assert np.mean(item.interval) == pytest.approx(item.value, abs=0.02 * half_width(item))


@pytest.mark.slow
def test_noise_explains_a_residual_of_noise():
    bands = noisy().resampling.bands
    assert bands.noise == pytest.approx(0.3, rel=0.1)
    assert bands.unexplained < 0.3 * np.std(noisy().traces.residual)
    assert bands.lasting == 0.0


@cache
def wavy(seed: int):
    """A fit to a log with noise that lasts."""
    effort = sliding_effort(MOTION, noise=0.0) + SIZE * coloured(seed, LASTING, MOTION.time.size)
    return identify(
        log_of(MOTION, effort),
        "coulomb_viscous",
        axis=STATED,
        blocks=0,
        draws=40 if seed < 3 else 0,
    ).best


@pytest.mark.slow
def test_correlated_residuals_make_intervals_as_wide_as_the_scatter_of_estimates():
    scatter = {
        name: np.std([wavy(seed).parameters[name].value for seed in range(24)], ddof=1)
        for name in NAMES
    }
    shares = {
        name: np.mean([half_width(wavy(seed).parameters[name]) for seed in range(3)])
        / (1.96 * scatter[name])
        for name in ("M", "F_v", "offset")
    }
    # Least squares has half of it.
    assert wavy(0).parameters["offset"].std < 0.5 * scatter["offset"]
    assert 0.65 < np.mean(list(shares.values())) < 1.5, shares
    assert min(shares.values()) > 0.4, shares


def lasting_share() -> float:
    """How long it lasts as a mean over a fortieth of the log tells it [s]."""
    # The mean of noise of first order has the share 2 s (1 - s (1 - exp(-1/s))) of its variance, s its time over all.
    block = MOTION.time[-1] / 40.0
    s = LASTING / block
    return block * 2.0 * s * (1.0 - s * (1.0 - np.exp(-1.0 / s)))


@pytest.mark.slow
def test_the_correlation_time_is_reported():
    assert np.mean([wavy(seed).resampling.bands.lasting for seed in range(3)]) == pytest.approx(
        lasting_share(), rel=0.4
    )


@pytest.mark.slow
def test_a_scattering_level_does_not_count_as_correlated_residual():
    motion, rng = swings(10), np.random.default_rng(0)
    levels = np.repeat(LEVEL * (1.0 + 0.1 * rng.standard_normal(10)), motion.time.size // 10)
    effort = (
        MASS * motion.acceleration
        + levels * side_of(motion)
        + SIZE * coloured(5, LASTING, levels.size)
    )
    fit = identify(
        log_of(motion, effort), "coulomb", mass=MASS, offset=0.0, axis=STATED, blocks=0, draws=20
    ).best
    assert fit.resampling.bands.unexplained > 0.5 * SIZE
    assert fit.resampling.bands.lasting < lasting_share()


@cache
def rounded():
    """A fit to a log with sharp corners behind a filter that is too low for them, which biases it."""
    motion = trapezoids(6.0)
    return identify(
        log_of(motion, sliding_effort(motion, noise=0.02)),
        "coulomb_viscous",
        cutoff=10.0,
        decimation=5,
        axis=STATED,
        blocks=0,
        draws=40,
    ).best


@pytest.mark.slow
@pytest.mark.parametrize("name", ["F_C", "F_v"])
def test_the_bias_of_a_filter_is_reflected(name):
    item = rounded().parameters[name]
    bias, left = item.value - TRUTH[name], np.mean(item.interval) - TRUTH[name]
    assert abs(bias) > 2e-3 * TRUTH[name]
    # Two thirds of it are; of corners that are not put back first, less than half.
    assert abs(left) < 0.4 * abs(bias)


def spotted(seed: int) -> Log:
    """A log with a force at one place, of which the model knows nothing: a tenth of the time it errs by far."""
    motion = sines(
        6.0, phases=tuple(np.random.default_rng(100 + seed).uniform(0.0, 2.0 * np.pi, 3))
    )
    low, high = np.quantile(motion.position, [0.75, 0.85])
    present = (low < motion.position) & (motion.position < high)
    return log_of(motion, sliding_effort(motion, seed, noise=0.2) + 4.0 * present)


@pytest.mark.slow
def test_bands_contain_19_of_20_despite_a_rare_large_model_error():
    settings = {"lines_gain": 1.0}
    fit = identify(
        spotted(0), "coulomb_viscous", axis=STATED, blocks=0, draws=20, settings=settings
    ).best
    inside = [
        predict(fit.plant, fit.friction, spotted(seed), bands=fit.resampling.bands).inside_percent
        for seed in range(1, 5)
    ]
    # A normal number of this size would be inside nine times of ten.
    assert 94.0 < np.mean(inside) < 98.5


@pytest.mark.slow
def test_a_weakly_visible_parameter_does_not_make_others_look_certain():
    # Over 2 cm/s to and fro viscous friction hardly differs from Coulomb's.
    motion = sines(4.0, amplitudes=(0.01,), frequencies=(0.5,), phases=(0.3,))
    log = log_of(motion, sliding_effort(motion, noise=4.0))
    fit = identify(
        log,
        "coulomb_viscous",
        mass=MASS,
        offset=1.5,
        cutoff=50.0,
        decimation=5,
        axis=STATED,
        blocks=0,
        draws=40,
    ).best
    viscous, level = fit.parameters["F_v"], fit.parameters["F_C"]
    assert half_width(viscous) > 0.2 * viscous.value
    assert abs(fit.correlation[0, 1]) > 0.85
    # Held, it would leave F_C half of its error.
    assert half_width(level) > 0.9 * 1.96 * level.std


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "status"), [(4, "at_edge"), (0, "unidentifiable")])
def test_at_an_edge_an_interval_is_one_sided(seed, status):
    motion = sines(3.0)
    log = log_of(motion, sliding_effort(motion, seed, noise=1.0, F_v=0.0))
    item = identify(
        log, "coulomb_viscous", axis=STATED, mass=MASS, blocks=0, draws=40
    ).best.parameters["F_v"]
    assert item.status == status
    assert item.interval[0] == 0.0
    assert item.interval[1] > item.value


@pytest.mark.slow
def test_errors_of_a_stiffness_are_factors():
    log = slow_log(friction.dahl(F_C=LEVEL, sigma_0=4e4), duration=3.0, noise=20.0)
    fit = identify(log, "dahl", mass=MASS, offset=0.0, axis=STATED, blocks=0, draws=20).best
    item, draws = fit.parameters["sigma_0"], fit.resampling.bands.draws["sigma_0"]
    assert item.interval[1] > 1.3 * item.value
    assert item.interval[0] < 4e4 < item.interval[1]
    # Replicates come out above the truth that they were made with, and so may the value: by factors, never below zero.
    assert item.interval[1] - item.value > 1.5 * (item.value - item.interval[0])
    assert item.interval == pytest.approx(tuple(np.percentile(draws, [2.5, 97.5])))


def replicates() -> RowReplicates:
    rows = treat(log_of(MOTION, sliding_effort(MOTION, noise=0.0)), Axis())
    return RowReplicates(
        InverseDynamics(
            rows, parameters_of(friction.find("coulomb_viscous"), PriorKnowledge(), rows)
        ),
        TRUTH,
    )


def drawn(count: int, *, signal: str = "effort", **causes: float) -> np.ndarray:
    """By how much each sample of so many replicates is another one, shape (replicate, sample)."""
    none = Disturbance(0.0, 0.0, 0.0)
    disturbed, drawing = none._replace(**causes), replicates()

    def values(disturbance: Disturbance, seed: int) -> np.ndarray:
        return getattr(drawing.log(disturbance, np.random.default_rng(seed)), signal).values

    return np.array([values(disturbed, seed) for seed in range(count)]) - values(none, 0)


@pytest.mark.slow
def test_a_replicate_has_a_random_encoder_phase():
    step = 1e-5
    off = drawn(100, signal="position", resolution=step)
    assert np.max(np.abs(off)) <= 0.5 * step * (1.0 + 1e-6)
    # At each sample rounding errs by anything up to half a step, be it the one sample or the other.
    assert np.std(off, axis=0) == pytest.approx(step / 12.0**0.5, rel=0.35)


@pytest.mark.slow
def test_noise_of_a_replicate_is_white():
    for signal, cause in (("effort", "noise"), ("position", "jitter")):
        off = drawn(5, signal=signal, **{cause: 1e-3})
        assert np.std(off) == pytest.approx(1e-3, rel=0.03)
        assert abs(np.mean(off[:, 1:] * off[:, :-1])) < 0.05e-6


@pytest.mark.slow
def test_noise_of_the_position_explains_its_residual():
    shaken = MOTION.position + 8e-6 * np.random.default_rng(0).standard_normal(MOTION.time.size)
    log = log_of(MOTION._replace(position=shaken), sliding_effort(MOTION, noise=0.0))
    fit = identify(log, "coulomb_viscous", axis=STATED, blocks=0, draws=20).best
    assert fit.resampling.bands.unexplained < 0.6 * np.std(fit.traces.residual)


@pytest.mark.slow
def test_correlated_noise_counts_as_its_few_independent_rows():
    # Now and then a half-cycle that is so short that noise is most of what it tells.
    lengths, along = np.tile([400] * 6 + [20], 4), 0.8
    groups, slope = Groups(np.repeat(np.arange(lengths.size), lengths)), np.ones(lengths.sum())
    rng = np.random.default_rng(3)
    levels = rng.standard_normal((150, lengths.size))[:, groups.index]
    lasting = 4.0 * lfilter([1.0], [1.0, -along], rng.standard_normal(levels.shape))
    # White noise that does the same to a mean over many rows.
    white = 4.0 / (1.0 - along) * rng.standard_normal(levels.shape)
    item, other = (
        np.sqrt(np.mean([scatter_in(groups, slope, row) ** 2 for row in levels + noise]))
        for noise in (lasting, white)
    )
    assert item == pytest.approx(other, rel=0.08)
    means = np.add.reduceat(levels + lasting, np.cumsum(lengths) - lengths, axis=1) / lengths
    assert item < 0.8 * np.sqrt(np.mean(means**2)), "long half-cycles count for more"


class Looped(NamedTuple):
    """A fit of Coulomb friction in its loop, its log and axis, and the level of each half-cycle."""

    fit: Fit
    log: Log
    axis: Axis
    levels: np.ndarray


@cache
def looped(count: int, *, scatter=0.0, step=1e-7, noise=0.02, wave=0.0, spot=0.0) -> Looped:
    """Causes [N] are forces in the loop: levels that scatter, a wave of 0.27 s, a push at one place."""
    rng, path = np.random.default_rng(1), swings(count, 0.01)
    levels = LEVEL * (1.0 + scatter * rng.standard_normal(count))
    off = np.repeat(levels - LEVEL, path.time.size // count) * side_of(path)
    off += wave * np.sin(2.0 * np.pi * path.time / WAVE)
    off += spot * (np.abs(path.position - np.quantile(path.position, 0.3)) < 0.0012)
    desired = np.stack([path.position, path.velocity, path.acceleration, np.zeros(off.size)])
    trace = run_closed_loop(
        plants.inertia(M=MASS),
        friction.coulomb(F_C=LEVEL),
        LAW,
        sensors.encoder(resolution=step),
        desired,
        DT,
        steps=8,
        disturbance=off,
        x=path.position[0],
    )
    log = Log(
        time=Channel(path.time, "s", "t"),
        position=Channel(trace.measured, "m", "q"),
        effort=Channel(trace.command + noise * rng.standard_normal(off.size), "N", "u"),
        reference=Channel(path.position, "m", "r"),
        sample_time=DT,
        segments=(slice(0, off.size),),
    )
    axis = Axis(
        resolution=step, controller=LAW, method="output_error", held=True, mass=MASS, offset=0.0
    )
    return Looped(identify(log, "coulomb", axis=axis, blocks=0, draws=40).best, log, axis, levels)


@pytest.mark.slow
def test_in_a_loop_the_level_scatters():
    item = looped(6, scatter=SCATTER)
    assert item.fit.resampling.scatter.value * LEVEL == pytest.approx(
        np.std(item.levels, ddof=1), rel=0.2
    )
    assert 0.6 < half_width(item.fit.parameters["F_C"]) / (1.96 * stats.sem(item.levels)) < 1.6


@pytest.mark.slow
def test_in_a_loop_encoder_steps_explain_the_effort_that_they_cause():
    fit = looped(4, step=5e-6, noise=0.0).fit
    assert fit.resampling.bands.unexplained < 0.2 * fit.loop_rmse


@pytest.mark.slow
def test_in_a_loop_a_replicate_has_a_random_encoder_phase():
    # Nothing else disturbs these replicates; were it known, all would be one and its mirror image.
    assert (
        np.unique(looped(3, step=1e-5, noise=0.0).fit.resampling.bands.draws["F_C"].round(9)).size
        > 30
    )


@pytest.mark.slow
def test_in_a_loop_a_correlated_residual_has_a_random_sign():
    path = swings(3)
    # By how much a wave of an unknown phase moves the mean of what opposes the motion.
    moved = abs(np.mean(side_of(path) * np.exp(2j * np.pi * path.time / WAVE))) / 2.0**0.5
    level = looped(3, wave=1.0).fit.parameters["F_C"]
    assert np.mean(level.interval) == pytest.approx(level.value, abs=0.02 * half_width(level))
    assert level.std < 0.2 * moved
    assert half_width(level) > 0.5 * 1.96 * moved


@pytest.mark.slow
def test_in_a_loop_bands_contain_rare_large_errors():
    item = looped(6, spot=4.0)
    prediction = predict(
        item.fit.plant,
        item.fit.friction,
        item.log,
        item.axis,
        "closed-loop",
        bands=item.fit.resampling.bands,
    )
    assert 94.0 < prediction.inside_percent < 98.5


@cache
def cornered(name: str):
    """A fit to an axis in open loop, whose filter rounds what friction does at reversals."""
    t = DT * np.arange(9000)
    effort = 30.0 * np.sin(12.0 * t) + 12.0 * np.sin(34.8 * t) + 8.0 * np.sin(0.7 * t)
    law = ROUNDED if name == "lugre" else {"F_C": 8.0, "F_v": 40.0}
    truth = friction.find(name)(**law)
    position = run_open_loop(plants.inertia(M=40.0), truth, effort, DT, steps=20).position
    return br.identify(
        {"time": t, "position": position, "effort": effort},
        name,
        method="inverse_dynamics",
        draws=40,
        blocks=0,
    )


@pytest.mark.slow
def test_bias_of_the_filter_at_corners_is_known_from_replicates():
    fit = cornered("lugre")
    for name, truth in ROUNDED.items():
        item = fit.parameters[name]
        assert item.interval[0] < truth < item.interval[1]
        # The middle of the draws is closer than the value, which misses by more than noise.
        draws = fit.best.resampling.bands.draws[name]
        assert abs(np.mean(draws) / truth - 1.0) < 2.5e-3
    assert abs(fit.parameters["sigma_1"].value / ROUNDED["sigma_1"] - 1.0) > 0.01


SETTLING = 2000  # samples after which the coloured noise has forgotten how it began


def coloured(seed: int, correlation_time: float, count: int, dt: float = 1e-3) -> np.ndarray:
    """Noise of first order with a standard deviation of 1."""
    pole = math.exp(-dt / correlation_time)
    white = np.random.default_rng(seed).normal(size=count + SETTLING)
    return lfilter([math.sqrt(1.0 - pole * pole)], [1.0, -pole], white)[SETTLING:]


@pytest.mark.parametrize(
    "correlation_time", [pytest.param(time, marks=pytest.mark.slow) for time in (0.02, 0.05)]
)
def test_intervals_cover_the_truth_with_coloured_residuals(correlation_time):
    inside, inside_plain = [], []
    for seed in range(60):
        motion = sines(phases=tuple(np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, 3)))
        effort = sliding_effort(motion, noise=0.0) + 0.5 * coloured(
            seed, correlation_time, motion.time.size
        )
        parameters = identify(
            log_of(motion, effort), "coulomb_viscous", blocks=0, draws=0
        ).best.parameters
        for name, truth in TRUTH.items():
            error = abs(parameters[name].value - truth)
            inside.append(
                100.0 * error < parameters[name].interval_percent * abs(parameters[name].value)
            )
            inside_plain.append(error < 1.96 * parameters[name].std)
    # Of 240 intervals of 95 %, fewer than 90 % hold the truth once in a thousand times.
    assert 0.90 < np.mean(inside) < 0.99
    assert np.mean(inside_plain) < 0.75
