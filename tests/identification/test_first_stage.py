"""The choice of cut-offs of the instruments, and rows that are omitted."""

import importlib
import math
import tracemalloc
from itertools import accumulate
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.identification.known_logs import TRUTH, Motion, log_of, sines, sliding_effort
from tests.identification.rigid import identify

from bristle.identification import first_stage
from bristle.identification.dataset import Alignment, Segment
from bristle.identification.first_stage import (
    Rung,
    _alignment_from,
    agreeing,
    alignment_of,
    believed,
)
from bristle.identification.settings import DEFAULT
from bristle.identification.wide_rows import STEPS, InstrumentFit, WideRows
from bristle.logs import Log

wide = importlib.import_module("bristle.identification.wide_rows")
DT = 1e-3
FAST = {
    "amplitudes": (0.02, 0.004, 0.0015),
    "frequencies": (0.5, 3.1, 7.3),
    "phases": (0.3, 1.1, 2.5),
}


def instruments(
    mass=10.0,
    delay=0.0,
    c=0.0,
    *,
    std=0.01,
    delay_std=1e-4,
    c_std=5e-7,
    bias=0.0,
    converged=True,
    cutoff=20.0,
):
    """What one cut-off says, known to `std` of the mass, a tenth of a sample, and 1 ms of a filter."""
    covariance = np.diag([std, delay_std, c_std]) ** 2
    return InstrumentFit(cutoff, np.array([mass]), delay, c, covariance, bias, converged)


def rung(*values, **named):
    """The same without a filter and with one that is free."""
    fit = instruments(*values, **named)
    return Rung(fit, fit)


def aligned_by(*rungs, bent=None, lowered=1.0, scale=1.0, springiness=0.2):
    """What is made of cut-offs that agree; `bent` is what the rows say with a filter in a channel."""
    rows = SimpleNamespace(
        dt=DT,
        fit=lambda *_, **__: bent,
        lowered=lambda *_: lowered * np.ones(20),
        springiness=lambda _: springiness,
    )
    return _alignment_from(rows, list(rungs), DEFAULT, scale, sought=True)


def test_changes_with_the_cutoff_widen_the_interval():
    steady, drifting = (aligned_by(rung(), rung(), last) for last in (rung(), rung(10.02, 8e-5)))
    assert drifting.delay_half_width > steady.delay_half_width + 2e-5
    assert drifting.mass_half_width > steady.mass_half_width + 5e-3


def test_a_cutoff_with_possible_noise_bias_is_not_chosen():
    assert aligned_by(rung(cutoff=10.0), rung(cutoff=20.0)).slow == 20.0
    assert aligned_by(rung(cutoff=10.0), rung(cutoff=20.0, bias=1e-4)).slow == 10.0


@pytest.mark.parametrize(
    ("said", "springiness", "removed"),
    [
        ({"delay": 5e-3, "std": 0.4}, 0.2, True),
        ({"delay": 5e-3, "std": 0.8}, 0.2, False),  # of an inertia of 10
        ({"delay": 5e-3, "std": 0.4}, 0.8, False),
        # A delay that may be zero is removed only with a well-known inertia.
        ({"delay": 5e-3, "std": 0.4, "delay_std": 7e-4}, 0.2, True),
        ({"delay": 2.2e-3, "std": 0.4, "delay_std": 7e-4}, 0.2, False),
        ({"delay": 1e-3, "std": 0.05, "delay_std": 7e-4}, 0.2, True),
    ],
)
def test_a_delay_is_removed_if_the_inertia_is_known_to_a_ninth(said, springiness, removed):
    item = rung(**said)
    assert aligned_by(item, item, springiness=springiness).delay == (
        pytest.approx(said["delay"]) if removed else None
    )


@pytest.mark.parametrize(
    ("said", "is_open"),
    [
        ({"delay": 5e-3, "c_std": 2e-5}, True),
        ({"delay": 5e-3, "c_std": 1e-6}, False),
        ({"delay": -5e-3, "c_std": 2e-5}, True),
        ({"delay": 1.2e-3, "c_std": 2e-5}, False),
        ({"delay": 5e-3, "c": 5e-6, "c_std": 3e-6}, True),
        ({"delay": -5e-3, "c": 5e-6, "c_std": 3e-6}, False),
        ({"delay": 5e-3, "std": 0.8, "c_std": 2e-5}, False),  # of an unknown delay
    ],
)
def test_a_delay_that_a_filter_may_cause_is_marked(said, is_open):
    item = rung(**said)
    assert aligned_by(item, item).filter_open is is_open


def test_a_known_filter_is_not_marked():
    filtered = rung(10.0, 6.3e-3, 1.7e-5, c_std=2e-6)
    result = aligned_by(filtered, filtered, bent=filtered.plain)
    assert result.smoothing == pytest.approx(5.8e-3, abs=0.1e-3)
    assert result.filter_open is False


@pytest.mark.parametrize(("frequency", "kept"), [(40.0, 1.0), (110.0, 0.0)])
def test_the_slope_of_the_acceleration_is_kept_up_to_sixty_hertz(frequency, kept):
    time = DT * np.arange(4000)
    columns = np.stack(
        [np.sin(2.0 * np.pi * frequency * time), np.cos(2.0 * np.pi * frequency * time)]
    )
    rows = WideRows(
        [wide._Stretch(time, np.ones_like(time), columns, np.ones_like(time), np.zeros_like)],
        200.0,
        DT,
        DT,
        0.0,
    )
    (calm,) = rows._calm(8.0, 0.0)
    assert calm[500:-500] == pytest.approx(kept * columns[0, 500:-500], abs=0.12)


def test_an_uncertain_filter_changes_the_inertia_little():
    sure, unsure = (
        Rung(instruments(10.0), instruments(10.02, c=4e-7, c_std=std)) for std in (1e-8, 4e-6)
    )
    clear, doubtful = aligned_by(sure, sure), aligned_by(unsure, unsure)
    assert clear.mass == pytest.approx(10.02, abs=0.001)
    assert doubtful.mass == pytest.approx(10.0, abs=0.006)


CHANCE, ALIKE = np.random.default_rng(0).normal(0.1, 1.0, 20), np.ones(20)
# In a stop from full speed a filter shows a thousand times as clearly as elsewhere, and so does a fault.
FIERCE = np.where(np.arange(20) == 7, 1e3, 1.0)


@pytest.mark.parametrize(
    ("changed", "seen"),
    [
        ({}, True),
        ({"narrow": 1e-9}, False),  # invisible at a lower cut-off: noise
        ({"narrow": -2e-5}, False),
        ({"lowered": 1.0 + CHANCE}, True),
        ({"lowered": CHANCE}, False),  # no lower residual
        ({"lowered": -1.0 - CHANCE}, False),
        ({"lowered": FIERCE}, True),  # one extreme block neither hides nor creates a filter
        ({"lowered": FIERCE * np.where(np.arange(20) % 2, 1.0, -1.0)}, False),
        ({"lowered": ALIKE - 30.0 * (FIERCE > 1.0)}, False),
        ({"bent": {"c": 3.9e-5}}, True),  # half of it is needed in a first step
        ({"bent": {"c": 4.1e-5}}, False),
        ({"bent": {"c": 1.4e-5}}, True),
        ({"bent": {"c": 1.3e-5}}, False),
        ({"bent": {"c": 2e-5, "converged": False}}, False),
        ({"scale": 40.0}, False),  # as uncertain as its cut-offs
    ],
)
def test_a_filter_is_removed_if_cutoffs_residuals_and_a_first_step_show_it(changed, seen):
    said = {"narrow": 2e-5, "bent": {"c": 2e-5}} | changed
    narrow, bent = rung(c=said.pop("narrow")), instruments(**said.pop("bent"))
    assert (aligned_by(narrow, rung(c=2e-5), bent=bent, **said).smoothing is not None) is seen


@pytest.mark.parametrize(
    ("rungs", "agreed"),
    [
        ((rung(10.0), rung(10.005), rung(9.996)), [0, 1, 2]),
        *(
            ((rung(), rung(), contradicting), [0, 1])
            for contradicting in (
                rung(9.9),
                rung(10.1),
                rung(delay=6e-4),
                rung(c=4e-6),
                rung(converged=False),
                rung(10.0, std=6.0),
            )
        ),
        ((rung(9.0), rung(), rung(), rung()), [1, 2, 3]),  # the longest run
        ((rung(9.0), rung(10.0), rung(11.0)), []),
        ((rung(),), []),
        ((rung(), rung(delay=6e-4)), []),
        ((rung(), rung(c=4e-6)), []),
        # The tail of a filter is no contradiction, and its growth is.
        ((rung(c=2e-5), rung(c=1e-5)), [0, 1]),
        ((rung(c=2e-5), rung(c=3e-5)), []),
    ],
)
def test_cutoffs_that_agree_are_used(rungs, agreed):
    run = agreeing(rungs, DT, sought=True)
    assert [place for place, item in enumerate(rungs) if any(item is one for one in run)] == agreed


@pytest.mark.parametrize(
    ("rungs", "allowed"),
    [
        ((rung(), rung(delay=6e-4)), {"sought": False}),
        ((rung(), rung(c=4e-6)), {"sought": True, "filters": False}),
    ],
)
def test_cutoffs_that_disagree_about_what_is_not_sought_may_agree_about_the_rest(rungs, allowed):
    assert agreeing(rungs, DT, **allowed) == list(rungs)


def test_errors_of_contradicting_cutoffs_grow_until_some_agree():
    apart = rung(10.0), rung(10.025), rung(9.7)
    assert agreeing(apart, DT, sought=True) == []
    run, scale = believed(apart, DT, sought=True)
    assert scale == 2.0
    assert [item.plain.std(0) for item in run] == pytest.approx([0.02, 0.02])
    result = aligned_by(*run, scale=scale)
    assert abs(result.mass - 10.0) < result.mass_half_width
    assert abs(result.mass - 10.025) < result.mass_half_width < 0.1
    assert (
        believed((rung(10.0), rung(11.0)), DT, sought=True),
        believed((rung(), rung()), DT, sought=True)[1],
    ) == (([], 1.0), 1.0)


def test_a_doubted_filter_is_as_uncertain_as_the_cutoffs():
    sure, doubted = (
        aligned_by(rung(c=2e-5), rung(c=2e-5), bent=instruments(c=2e-5), scale=scale)
        for scale in (1.0, 2.0)
    )
    assert doubted.smoothing == sure.smoothing
    assert doubted.smoothing_half_width == pytest.approx(2.0 * sure.smoothing_half_width)


MOTION = sines(12.0, DT, **FAST)
SMOOTH = sliding_effort(MOTION, noise=0.0)


def recorded(effort, motion=MOTION, *, step=0.0):
    return log_of(
        motion, effort + np.random.default_rng(5).normal(0.0, 0.05, effort.size), step=step
    )


def late_presliding():
    stretches = list(
        accumulate(
            np.diff(MOTION.position / 1e-5, prepend=MOTION.position[0] / 1e-5), clipped, initial=0.0
        )
    )
    return TRUTH["F_C"] * (np.array(stretches[1:]) - np.where(MOTION.velocity < 0.0, -1.0, 1.0))


def clipped(stretch, step):
    return min(max(stretch + step, -1.0), 1.0)


@pytest.fixture(scope="module")
def smooth():
    return alignment_of([recorded(SMOOTH)], [None], DEFAULT)


WAVE = 1.5 * np.sin(2.0 * np.pi * MOTION.position / 4e-3 + 0.5)
FALL = 6.0 * np.exp(-np.abs(MOTION.velocity) / 0.02) * np.where(MOTION.velocity > 0.0, 1.0, -0.4)


@pytest.mark.parametrize(
    ("force", "wider"),
    [
        pytest.param(WAVE, 2.0, id="wave over the position"),
        pytest.param(WAVE * np.sign(MOTION.velocity), 2.0, id="wave of friction"),
        pytest.param(300.0 * MOTION.position, 9.0, id="spring"),
        pytest.param(FALL, 9.0, id="nonlinear in speed and direction"),
        pytest.param(late_presliding(), 9.0, id="late presliding"),
    ],
)
def test_a_force_over_position_or_speed_is_neither_inertia_nor_delay(smooth, force, wider):
    result = alignment_of([recorded(SMOOTH + force)], [None], DEFAULT)
    assert abs(result.mass - TRUTH["M"]) < result.mass_half_width < wider * smooth.mass_half_width
    assert abs(result.delay) < result.delay_half_width


@pytest.mark.parametrize(("samples", "begin"), [(0, 0.0), (2, 1.7e9)])
def test_warming_up_is_not_a_delay(samples, begin):
    parts = [
        sines(seconds, DT, (0.03,), (hertz,), (np.pi / 2.0,))
        for seconds, hertz in ((10.0, 0.6), (10.0, 1.2), (4.0, 2.5))
    ]
    motion = Motion(*map(np.concatenate, zip(*parts, strict=True)))
    time = DT * np.arange(motion.time.size)
    effort = sliding_effort(motion, noise=0.0) - 2.0 * np.sign(motion.velocity) * time / time[-1]
    result = alignment_of(
        [recorded(np.roll(effort, samples), motion._replace(time=begin + time))], [None], DEFAULT
    )
    assert abs(result.delay - samples * DT) < result.delay_half_width < 0.3 * DT
    assert abs(result.mass - TRUTH["M"]) < result.mass_half_width < 0.01 * TRUTH["M"]


def test_a_filter_below_a_sample_does_not_matter():
    motion = sines(12.0, DT / 50, **FAST)
    pole = np.exp(-DT / 50 / 0.5e-3)
    effort = lfilter([1.0 - pole], [1.0, -pole], sliding_effort(motion, noise=0.0))[::50]
    result = alignment_of(
        [recorded(effort, Motion(*(signal[::50] for signal in motion)))], [None], DEFAULT
    )
    assert result.smoothing is None
    assert result.delay == pytest.approx(0.5e-3, abs=result.delay_half_width)
    assert abs(result.mass - TRUTH["M"]) < result.mass_half_width


def moved(distances, speeds, rates):
    """Speeds of moves to and fro, their corners rounded over 20 ms."""
    parts = [np.zeros(300)]
    for distance, speed, rate in zip(distances, speeds, rates, strict=True):
        up, cruise = round(speed / rate / DT), max(round((distance / speed - speed / rate) / DT), 0)
        item = speed * np.concatenate(
            [np.arange(up) / up, np.ones(cruise), np.arange(up)[::-1] / up]
        )
        parts += [item, np.zeros(100), -item, np.zeros(100)]
    return np.convolve(np.concatenate([*parts, np.zeros(300)]), np.ones(20) / 20, "same")


@pytest.fixture(scope="module")
def driven():
    """Position and effort of a loop that follows moves: the effort held over a sample, the axis stuck at rest."""
    mass, level, drag, steps = 1.1, 5.0, 0.5, 20
    distances = [size for size in (2.0, 1.0, 0.5, 0.2, 0.1) for _ in range(3)] + [1.0] * 8
    speeds = [size for size in (3.0, 1.5, 0.7, 0.3, 0.1) for _ in range(3)] + [3.0] * 8
    speed = moved(distances, speeds, [12.0] * 15 + [25.0] * 8)
    x = v = past = whole = 0.0
    rows = np.empty((speed.size, 2))
    for k, wanted in enumerate(np.cumsum(speed) * DT):
        seen = round(x / 1e-6) * 1e-6
        error = 40.0 * (wanted - seen) + speed[k] - (seen - past) / DT
        past, whole = seen, whole + error * DT
        u = 60.0 * error + 1200.0 * whole
        rows[k] = x, u
        for _ in range(steps):
            drive = u - (math.copysign(level, v) + drag * v if v else min(max(u, -level), level))
            after = v + DT / steps * drive / mass
            v = 0.0 if after * v < 0.0 else after
            x += v * DT / steps
    return mass, np.round(rows[:, 0] / 3.8e-5) * 3.8e-5, rows[:, 1]


def noisy(position, effort, seed):
    scatter = np.random.default_rng(seed).normal(0.0, 0.07, effort.size)
    return Log(
        time=DT * np.arange(effort.size), position=position, effort=effort + scatter, sample_time=DT
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_filter_that_does_not_predict_other_parts_of_the_log_is_rejected(driven, seed):
    mass, position, effort = driven
    result = alignment_of([noisy(position, effort, seed)], [None], DEFAULT)
    assert result.smoothing is None
    # The effort acts from its sample to the next.
    assert result.delay == pytest.approx(-0.5 * DT, abs=result.delay_half_width)
    assert result.mass == pytest.approx(mass, rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("lag", [3e-3, 5e-3])
def test_a_filter_of_a_drive_is_found_with_friction_that_turns_at_once(driven, lag):
    mass, position, effort = driven
    gain = 1.0 - np.exp(-DT / lag)
    result = alignment_of(
        [noisy(position, lfilter([gain], [1.0, gain - 1.0], effort), 0)], [None], DEFAULT
    )
    assert result.smoothing == pytest.approx(lag, rel=0.04)
    assert result.mass == pytest.approx(mass, rel=2e-3)


def test_encoder_steps_do_not_look_like_a_filter():
    result = alignment_of([recorded(SMOOTH, step=2e-5)], [None], DEFAULT)
    assert result.smoothing is None
    # Three sines that repeat meet the same steps again and again.
    assert result.mass == pytest.approx(TRUTH["M"], rel=5e-3)


def swung(step):
    """A log of wide swings, with an encoder too coarse for its fast parts and an effort late by two samples."""
    swings = {
        "duration": 14.0,
        "amplitudes": (7.7, 0.6, 0.28, 0.037, 0.016),
        "frequencies": (0.104, 0.52, 0.859, 3.103, 5.33),
        "phases": (4.5, 5.4, 0.4, 5.7, 4.1),
    }
    motion = sines(dt=DT, **swings)
    effort = np.interp(motion.time - 2.0 * DT, motion.time, sliding_effort(motion, noise=0.0))
    return recorded(effort, motion, step=step)


def in_a_band(size):
    """A log with encoder errors between 20 and 40 Hz and an effort late by two samples."""
    motion = sines(14.0, DT, amplitudes=(0.02, 0.004), frequencies=(0.5, 3.1), phases=(0.3, 1.1))
    effort = np.interp(motion.time - 2.0 * DT, motion.time, sliding_effort(motion, noise=0.0))
    white = np.fft.rfft(np.random.default_rng(3).standard_normal(motion.time.size))
    frequency = np.fft.rfftfreq(motion.time.size, DT)
    error = np.fft.irfft(
        np.where((frequency > 20.0) & (frequency < 40.0), white, 0.0), motion.time.size
    )
    return recorded(
        effort, motion._replace(position=motion.position + size / np.std(error) * error)
    )


@pytest.mark.parametrize("size", [0.0, 3e-4, pytest.param(1e-4, marks=pytest.mark.slow)])
def test_an_encoder_error_in_a_band_does_not_bias_the_inertia(size):
    best = identify(in_a_band(size), "coulomb_viscous", blocks=0, draws=0).best.parameters["M"]
    assert best.value == pytest.approx(TRUTH["M"], rel=0.1)
    assert best.status == "identified"
    low, high = best.interval
    assert low <= TRUTH["M"] <= high
    assert high - low < 0.5 * TRUTH["M"]


def test_an_unknown_inertia_biased_by_noise_is_not_identified():
    fit = identify(
        in_a_band(0.0), "coulomb_viscous", alignment=Alignment(too_small=0.3), blocks=0, draws=0
    ).best
    assert (fit.parameters["M"].status, fit.parameters["M"].reason.code) == (
        "unidentifiable",
        "noisy_acceleration",
    )
    assert fit.parameters["M"].reason.numbers["percent"] == pytest.approx(30.0)


def test_an_unknown_delay_widens_the_interval_of_a_biased_inertia():
    logs = [in_a_band(3e-4)]
    late, none = (
        first_stage._without_noise(Alignment(sought=sought), logs, [None], DEFAULT, None)
        for sought in (True, False)
    )
    assert late.mass == none.mass
    assert late.mass_half_width > 1.05 * none.mass_half_width


def test_an_inertia_is_below_another_only_if_significant():
    parts = np.array([0.3, -0.3] * 10)
    low, high = (
        InstrumentFit(20.0, np.array([mass]), 0.0, 0.0, np.eye(1), 0.0, True, sign * parts)
        for mass, sign in ((9.0, 1.0), (12.0, -1.0))
    )
    error = (19.0 / 20.0 * 20.0 * 0.6**2) ** 0.5  # of a difference of 3, by the jackknife
    assert low.below(high, 0.99 * 3.0 / error, 0.02) == pytest.approx(0.25)
    assert low.below(high, 1.01 * 3.0 / error, 0.02) == 0.0
    assert low.below(high, 0.5, 0.26) == 0.0
    assert high.below(low, 0.0, 0.02) == 0.0


def test_a_coarse_encoder_does_not_hide_a_delay():
    result = alignment_of([swung(1.5e-3)], [None], DEFAULT)
    assert result.delay == pytest.approx(2.0 * DT, abs=result.delay_half_width)
    assert result.delay_half_width < 0.3 * DT
    assert result.mass == pytest.approx(TRUTH["M"], abs=result.mass_half_width)


@pytest.mark.parametrize(("step", "left"), [(0.0, True), (1.5e-3, False)])
def test_an_uncertain_inertia_is_left_to_the_models_unless_noise_biases_them(step, left):
    fit = identify(
        swung(step), "coulomb_viscous", blocks=0, draws=0, settings={"inertia_unsure": 1e-6}
    )
    assert (fit.best.parameters["M"].value != fit.treatment["mass"]) is left
    assert fit.best.parameters["M"].value == pytest.approx(TRUTH["M"], rel=0.005)


@pytest.mark.parametrize(("std", "known"), [(0.01, True), (1.1, False)])
def test_an_inertia_of_large_uncertainty_is_unknown(std, known):
    item = Rung(instruments(std=std), instruments(std=1.1))
    assert (aligned_by(item, item).mass is not None) is known


def ladder(monkeypatch, *, width=100.0, sought=True, **said):
    """The cut-offs that are fitted, and which of their fits step on to a filter, of rows that say the same everywhere."""
    asked = []

    def fit(cutoff, delay, c=0.0, *, free, steps=STEPS):
        asked.append((cutoff, delay, free, steps))
        return instruments(cutoff=cutoff, **said)

    rows = SimpleNamespace(
        dt=DT, width=width, scanned=lambda: 7e-3, find_waves=asked.append, fit=fit
    )
    monkeypatch.setattr(first_stage, "wide_rows", lambda logs, axes: rows)
    monkeypatch.setattr(first_stage, "_without_noise", lambda alignment, *_: alignment)
    monkeypatch.setattr(first_stage, "believed", lambda rungs, dt, *, sought: ([], 1.0))
    assert alignment_of([], [], DEFAULT, sought=sought) == Alignment(sought=sought)
    start, *fits = asked
    return start, fits


@pytest.mark.parametrize(
    ("c", "c_std", "steps_on"),
    [
        (3e-6, 1e-6, True),
        (-3e-6, 1e-6, True),
        (3e-6, 1.6e-6, False),
        (1.9e-6, 1e-9, False),
        (2.1e-6, 1e-9, True),
        (0.0, 1e-9, False),
    ],
)
def test_a_visible_filter_of_more_than_two_milliseconds_is_found(monkeypatch, c, c_std, steps_on):
    _, fits = ladder(monkeypatch, c=c, c_std=c_std, std=1e-7)
    assert [steps for *_, steps in fits[:3]] == ([STEPS, 1, 3] if steps_on else [STEPS, 1, STEPS])
    assert [free for *_, free, _ in fits[:3]] == [(True, False), (True, True), (True, steps_on)]


@pytest.mark.parametrize(
    ("width", "lowest", "highest"),
    [(100.0, 4.0, 80.0), (60.0, 3.0, 48.0), (1000.0, 40.0, 110.0), (5.0, 2.0, 4.0)],
)
def test_eight_cutoffs_lie_evenly_between_a_share_of_the_rows_and_their_width(
    monkeypatch, width, lowest, highest
):
    _, fits = ladder(monkeypatch, width=width)
    cutoffs = [cutoff for cutoff, *_ in fits[::2]]
    assert (cutoffs[0], cutoffs[-1], len(cutoffs)) == (
        pytest.approx(lowest),
        pytest.approx(highest),
        8,
    )
    assert np.diff(np.log(cutoffs)) == pytest.approx(math.log(highest / lowest) / 7.0)


@pytest.mark.parametrize(("sought", "delay"), [(True, 7e-3), (False, 0.0)])
def test_only_a_sought_delay_is_scanned_and_free(monkeypatch, sought, delay):
    start, ((_, first, plain, _), (_, _, filtered, _), *_) = ladder(monkeypatch, sought=sought)
    assert (start, first) == (delay, delay)
    assert (plain, filtered) == ((sought, False), (sought, True))


def slide(count, speed):
    """A segment at a constant speed."""
    time = DT * np.arange(count)
    motion = {
        "velocity": np.full(count, speed),
        "acceleration": np.zeros(count),
        "effort": np.zeros(count),
    }
    return Segment(time, speed * time, recorded=speed * time, **motion)


def test_wide_rows_of_a_long_log_keep_one_column_in_memory():
    segment = slide(200_000, 0.1)
    tracemalloc.start()
    wide._stretch(segment, segment.velocity, 5.0, DT, 40, 0.2)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 7 * segment.time.nbytes  # of its twelve columns


def test_columns_of_a_slide_are_those_of_friction_in_its_direction():
    speed, segment = 0.1, slide(4000, 0.1)
    stretch = wide._stretch(segment, segment.velocity, 100.0, DT, 2, 2.0 * speed)
    acceleration, position, *shapes = stretch.columns[:, 1000]
    assert (acceleration, position) == pytest.approx((0.0, 2000 * DT * speed), abs=1e-9)
    falls = np.exp(-0.5 / np.array(wide.SPEEDS))  # at half of the top speed
    assert shapes == pytest.approx([speed, 1.0, *falls, *[0.0] * 5, 2000 * DT], abs=1e-9)


def test_columns_without_rows_in_a_log_in_one_direction_are_dropped():
    time, columns = DT * np.arange(500), np.random.default_rng(1).standard_normal((3, 500))
    columns[2] = 1e-9
    columns[2, 0] = 1.0  # where nothing is weighed
    weight = np.where(time > 0.01, 1.0, 0.0)
    stretches = [
        wide._Stretch(time, np.sign(time), columns.copy(), weight, np.zeros_like) for _ in range(2)
    ]
    assert WideRows(stretches, 100.0, DT, DT, 0.0).suffice()
    assert [stretch.columns.tolist() for stretch in stretches] == [columns[:2].tolist()] * 2
