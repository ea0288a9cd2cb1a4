"""From logs to a motion at the work rate, about ten cut-offs, and to the filter of its rows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.errors import InputError, TooShortError
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.identification.dataset import effort_of
from bristle.identification.dictionary import Motion, filtered, low_pass_taps, unsettled
from bristle.identification.preprocessing import CREEPS, step_of
from bristle.logs.log import Log
from bristle.models.friction.next_model import CHANNELS

CUTOFF = 100.0  # [Hz] of the rows, at most
CUTOFF_SHARE = 0.1  # of the sampling frequency: cut-off of the rows, at most
WORK_RATE = 10.0  # cut-offs: sampling frequency of the motion
ROWS_A_PERIOD = 2.4  # of the cut-off
MOST_ROWS = 30_000
FEWEST_ROWS = 240
SMOOTHING = np.exp(
    -0.5 * (np.arange(-4, 5) / 1.1) ** 2
)  # of the position, over the samples beside each
MEDIAN_OVER_DEVIATION = 0.67  # of normal noise
STEP_NOISE = 0.3  # of the step of the encoder: its noise, at least
SPARE = 3  # samples of a margin
LONGEST_DELAY = 0.9  # periods of the cut-off: samples that the search for the delay needs


class Stretch(NamedTuple):
    """A stretch of a log without gaps at the work rate."""

    time: np.ndarray  # [s]
    position: np.ndarray  # [m or rad], after a filter against aliases only
    effort: np.ndarray  # [N or N*m]
    regressors: (
        np.ndarray
    )  # columns that a coefficient turns into an effort, shape (column, sample)
    channels: np.ndarray  # channels on which friction may depend, shape (channel, sample)
    log: int  # number of its log


def motion_of(pairs: Sequence[tuple[Log, Axis | None]], highest: float = CUTOFF) -> Motion:
    """Return the motion of the logs of an axis at the work rate, for rows up to a `highest` frequency [Hz]."""
    for log, _ in pairs:
        refuse_unfit(log, pairs[0][0])
    dt = float(pairs[0][0].sample_time)
    stated = [axis.cutoff for _, axis in pairs if axis is not None and axis.cutoff is not None]
    cutoff = min([*stated, CUTOFF_SHARE / dt, highest])
    decimation = max(int(1.0 / (WORK_RATE * dt * cutoff)), 1)
    work_dt = decimation * dt
    taps = low_pass_taps(cutoff, work_dt)
    margin = margin_of(taps, cutoff * work_dt)
    names = channels_of([log for log, _ in pairs])
    parts = list(stretches_of(pairs, decimation, 2 * margin, names))
    total = sum(part.time.size for part in parts)
    step = max(int(1.0 / (ROWS_A_PERIOD * cutoff * work_dt)), 1, -(-total // MOST_ROWS))
    quantum = max(step_of(log, axis) for log, axis in pairs)
    motion = assembled(parts, work_dt, cutoff, quantum, names)
    is_rotary = pairs[0][0].kind == "rotational"
    motion = replace(motion, taps=taps, step=step, margin=margin, is_rotary=is_rotary)
    if not parts:
        refuse_short(motion)
    if np.ptp(motion.x) <= CREEPS * max(quantum, motion.noise):
        raise InputError(
            "the position hardly changes",
            path="log.position",
            value=f"a range of {with_unit(float(np.ptp(motion.x)), unit_of('length', pairs[0][0].kind))}",
            mend="Record a motion in both directions, at the working speeds of the axis",
        )
    if not np.ptp(motion.u):
        raise InputError(
            "the effort does not change",
            path="log.effort",
            value=with_unit(float(motion.u[0]), unit_of("force", pairs[0][0].kind)),
            mend="Look for the right column and unit of the effort in the axis file",
        )
    motion = replace(motion, unsettled=unsettled(motion))
    refuse_short(motion)
    return motion


def narrowed(motion: Motion, share: float) -> Motion:
    """Return a motion with a share of the cut-off of its rows, and of their number."""
    cutoff = share * motion.cutoff
    taps = low_pass_taps(cutoff, motion.dt)
    return replace(
        motion,
        cutoff=cutoff,
        taps=taps,
        step=int(motion.step / share),
        margin=margin_of(taps, cutoff * motion.dt),
    )


def delayed(motion: Motion, delay: float) -> Motion:
    """Return a motion whose rows reach as far as a delay [s]."""
    needed = motion.taps.size // 2 + math.ceil(abs(delay) / motion.dt) + SPARE
    return replace(motion, margin=max(motion.margin, needed))


def margin_of(taps: np.ndarray, cutoff: float) -> int:
    """Return the samples before the first row of a stretch; the cut-off in cycles a sample."""
    return taps.size // 2 + max(int(LONGEST_DELAY / cutoff), 2)


def refuse_unfit(log: Log, first: Log) -> None:
    """Refuse a log without effort, with samples that are no numbers, or unlike the first log."""
    path = f"log {log.source.name}".strip()
    if log.effort is None:
        raise InputError(
            "has no effort, so its forces are unknown",
            path=path,
            mend="Name the column of force, torque or current in an axis file: bristle log LOG --write AXIS.toml proposes one",
        )
    if log.kind != first.kind:
        raise InputError(
            "has a different kind of axis than the first log",
            path=path,
            value=log.kind,
            allowed=first.kind,
        )
    if abs(log.sample_time / first.sample_time - 1.0) > 1e-3:
        raise InputError(
            "has a different sample time than the first log",
            path=path,
            value=with_unit(log.sample_time, "s"),
            allowed=with_unit(first.sample_time, "s"),
            mend="Resample one of the logs",
        )
    for name in ("time", "position", "effort"):
        values = getattr(log, name).values
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise InputError(
                "is not a finite number",
                path=f"log.{name}[{bad[0]}]",
                value=float(values[bad[0]]),
                mend=f"Cut the log before this sample, or repair all {bad.size} such samples",
            )


def refuse_short(motion: Motion) -> None:
    """Refuse a motion with too few rows for the folds."""
    rows = sum(motion.counts)
    if rows < FEWEST_ROWS:
        shortest = FEWEST_ROWS * motion.step * motion.dt
        raise TooShortError(
            "is too short to explain its effort",
            path="log",
            value=with_unit(rows * motion.step * motion.dt, "s"),
            allowed=f"at least {with_unit(shortest, 's')}",
            mend="Record a longer motion, or sample it faster",
        )


def channels_of(logs: Sequence[Log]) -> list[str]:
    """Return the names of recorded channels on which friction may depend, those that change in all logs."""
    names = [name for name in logs[0].surroundings if name in CHANNELS]
    for log in logs:
        channels = log.surroundings
        names = [name for name in names if name in channels]
        names = [name for name in names if np.ptp(channels[name].values) > 0.0]
    return names


def stretches_of(
    pairs: Sequence[tuple[Log, Axis | None]],
    decimation: int,
    shortest: int,
    names: Sequence[str] = (),
) -> Iterable[Stretch]:
    """Yield the stretches of logs at the work rate that are longer than `shortest` samples."""
    begin = 0.0
    for number, (log, axis) in enumerate(pairs):
        time = log.time.values
        effort = effort_of(log)
        # Logs follow each other in time.
        shifted = time - time[0] + begin
        begin = float(shifted[-1]) + log.sample_time
        nothing = np.zeros((0, time.size))
        regressors = np.vstack([nothing, *(column.values for column in log.regressors)])
        channels = np.vstack([nothing, *(log.surroundings[name].values for name in names)])
        for part in log.segments:
            load = effort[part]
            if axis is not None and axis.held:
                # The mean of two consecutive values acts around the sample between them.
                load = 0.5 * (load + np.append(load[:1], load[:-1]))
            place = log.position.values[part]
            stretch = Stretch(
                shifted[part], place, load, regressors[:, part], channels[:, part], number
            )
            if stretch.time.size > (shortest + 10) * decimation:
                yield decimated(stretch, decimation, log.sample_time)


def decimated(stretch: Stretch, decimation: int, dt: float) -> Stretch:
    """Return a stretch at the work rate."""
    if decimation == 1:
        return stretch
    taps = low_pass_taps(0.42 / (decimation * dt), dt, width=0.35)
    reach = taps.size // 2
    count = (stretch.time.size - 1) // decimation + 1
    origin = stretch.position[0]

    def slow(signal: np.ndarray) -> np.ndarray:
        padded = np.pad(signal, reach, mode="edge")
        return filtered(padded, taps, reach, decimation, count)

    def all_slow(signals: np.ndarray) -> np.ndarray:
        return np.vstack([np.zeros((0, count)), *(slow(signal) for signal in signals)])

    return Stretch(
        stretch.time[::decimation],
        slow(stretch.position - origin) + origin,
        slow(stretch.effort),
        all_slow(stretch.regressors),
        all_slow(stretch.channels),
        stretch.log,
    )


def assembled(
    parts: Sequence[Stretch], dt: float, cutoff: float, quantum: float, names: Sequence[str]
) -> Motion:
    """Return a motion of stretches; derivatives do not cross their ends."""
    x = list[np.ndarray]()
    a = list[np.ndarray]()
    noises = [STEP_NOISE * quantum]
    weights = SMOOTHING / SMOOTHING.sum()
    for part in parts:
        padded = np.pad(part.position, 4, mode="edge")
        smooth = np.convolve(padded, weights, "valid")
        rough = part.position - smooth
        deviation = float(np.median(np.abs(rough - np.median(rough))))
        noises.append(deviation / MEDIAN_OVER_DEVIATION)
        x.append(smooth)
        p = padded[2:-2]
        second = -p[:-4] + 16.0 * p[1:-3] - 30.0 * p[2:-2] + 16.0 * p[3:-1] - p[4:]
        a.append(second / (12.0 * dt**2))
    ends = np.cumsum([0, *(part.time.size for part in parts)]).tolist()
    of_log = np.array([part.log for part in parts], dtype=int)
    firsts = [*np.flatnonzero(np.diff(of_log, prepend=-1)).tolist(), len(parts)]
    joined = np.concatenate
    channels = [joined([part.channels[number] for part in parts]) for number in range(len(names))]
    regressors = np.zeros((0, 0))
    if parts:
        regressors = np.hstack([part.regressors for part in parts])
    return Motion(
        time=joined([np.zeros(0), *(part.time for part in parts)]),
        x=joined([np.zeros(0), *x]),
        v=joined([np.zeros(0), *(np.gradient(part, dt) for part in x)]),
        a=joined([np.zeros(0), *a]),
        u=joined([np.zeros(0), *(part.effort for part in parts)]),
        stretches=tuple(slice(*pair) for pair in pairwise(ends)),
        logs=tuple(slice(ends[a], ends[b]) for a, b in pairwise(firsts)),
        dt=dt,
        cutoff=cutoff,
        noise=max(noises),
        is_rotary=False,
        taps=np.ones(1),
        step=1,
        margin=0,
        unsettled=(0,) * len(parts),
        regressors=regressors,
        channels=dict(zip(names, channels, strict=True)),
    )
