r"""From a log to regression rows: the standard treatment of inverse dynamics.

The position passes a zero-phase Butterworth filter of fourth order and is differentiated twice by central differences.
The effort and each column of the friction model, its sign included, pass the same filter, so both sides of the
equation lose the same high frequencies. Samples within five periods of the cut-off from an edge are dropped. All
others are decimated. Rows at rest are left out: there friction balances any effort. In a log that only creeps, as in
pre-sliding, rest and motion cannot be distinguished, and all rows are kept.

An effort that a controller holds until its next sample leads the position by half a sample: the mean of two
consecutive values acts at the sample between them.

Filtering both sides is exact for terms linear in the motion. The columns of friction are computed from a motion that
is already filtered. A reversal displaced by the filter, or a shape shorter than its period, remains an error.

References
----------
.. [1] A. Janot, P.-O. Vandanjon, M. Gautier, "A generic instrumental variable approach for industrial robot
   identification", IEEE Transactions on Control Systems Technology 22(1), 2014. doi:10.1109/TCST.2013.2246163
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.errors import InputError, TooShortError, located
from bristle.core.normal import DEVIATION_OVER_MEDIAN
from bristle.core.typography import with_unit
from bristle.core.variable import Kind, unit_of
from bristle.files.arguments import without_short
from bristle.identification.dataset import Alignment, Dataset, Segment, effort_of
from bristle.logs.filters import ahead, derivative, low_passed, through_filter
from bristle.logs.log import Channel, Log
from bristle.logs.turns import rests, whole_cycle, with_sides

CUTOFF_SHARE = 0.1  # of the sampling frequency
DECIMATION = 10
BENT_ROWS = 400  # rows that remain of a short log, for a plant with terms
ROWS_MIN = 50
HIDES, CALM = 0.3, 0.03  # noise as a share of friction: it hides friction, and it does not
CREEPS = 10.0  # range in encoder steps above which an axis counts as moving


def treat_all(
    logs: Sequence[Log],
    axes: Sequence[Axis | None],
    cutoff: float | None = None,
    decimation: int | None = None,
    delay: float = 0.0,
    smoothing: float = 0.0,  # time constant of a filter of the effort, a part of the delay [s]
    position_smoothing: float = 0.0,  # the same for the position [s]
) -> Dataset:
    """Return the regression rows of several logs of one axis, one after the other; the effort lags the position by `delay` [s]."""
    parts = [treat(log, axis, cutoff, decimation) for log, axis in zip(logs, axes, strict=True)]
    first = parts[0]
    for log, part in zip(logs, parts, strict=True):
        path = f"log {log.source.name}"
        if part.kind != first.kind:
            raise InputError(
                "has a different kind of axis than the first log",
                path=path,
                value=part.kind,
                allowed=first.kind,
            )
        # Relative difference below which sample times count as equal.
        if abs(part.sample_time / first.sample_time - 1.0) > 1e-3:
            period, first_period = (
                with_unit(time, "s") for time in (part.sample_time, first.sample_time)
            )
            raise InputError(
                f"was sampled every {period}, the first log every {first_period}",
                path=path,
                mend="Resample one of the logs",
            )
        for name in ("cutoff", "decimation", "held"):
            if getattr(part, name) != getattr(first, name):
                raise InputError(
                    f"has a different {name} than the first log",
                    path=path,
                    value=getattr(part, name),
                    mend=f"Give both logs the same {name}",
                )
    segments, end = [], first.segments[0].time[0]
    for number, part in enumerate(parts):
        # Rows are identified by their time: each log begins where the previous log ends.
        later = end - part.segments[0].time[0]
        segments += [
            replace(segment, log=number, time=segment.time + later) for segment in part.segments
        ]
        end = segments[-1].time[-1] + first.sample_time
    merged = replace(
        first,
        segments=tuple(segments),
        resolution=max(map(attrgetter("resolution"), parts)),
        noise=float(np.sqrt(np.mean([part.noise**2 for part in parts]))),
        effort_noise=float(np.sqrt(np.mean([part.effort_noise**2 for part in parts]))),
    )
    return shifted(merged, delay, smoothing, position_smoothing)


class Treatment(NamedTuple):
    """Cut-off [Hz], samples per row, samples of the transient of the filter, and the stretches that are long enough."""

    cutoff: float
    decimation: int
    dropped: int
    stretches: list[slice]


def stretches_of(
    log: Log, axis: Axis | None, cutoff: float | None = None, decimation: int | None = None
) -> Treatment:
    """Return the treatment of a log; refuse one that is too short for it."""
    # By default, the cut-off is a tenth of the sampling frequency and the decimation is 10, less for a plant with terms.
    dt, axis = float(log.sample_time), axis or Axis(kind=log.kind)
    cutoff = axis.cutoff if cutoff is None else cutoff
    cutoff = CUTOFF_SHARE / dt if cutoff is None else float(cutoff)
    if not (np.isfinite(cutoff) and 0.0 < cutoff < 0.5 / dt):
        raise InputError(
            "out of range",
            path="cutoff",
            value=cutoff,
            allowed=f"between 0 and {0.5 / dt:g} Hz, half the sampling frequency",
        )
    decimation = axis.decimation if decimation is None else decimation
    if decimation is None:
        # An arm swings for a few seconds only; a longer log has the rows of a plant without terms.
        bends = axis.gravity or axis.cogging or axis.spring or axis.regressors
        decimation = min(max(len(log) // BENT_ROWS, 1), DECIMATION) if bends else DECIMATION
    # Of the cut-off frequency: the transient of the filter.
    dropped = max(round(5 / (cutoff * dt)), 1)
    shortest = 2 * dropped + ROWS_MIN * decimation
    parts = log.segments or (slice(0, len(log)),)
    lengths = [len(range(*part.indices(len(log)))) for part in parts]
    if max(lengths) < shortest:
        raise TooShortError(
            "is too short for this filter and decimation",
            path="log",
            value=f"{max(lengths)} samples without a gap",
            allowed=f"at least {shortest}",
            mend="Record a longer motion"
            + ", raise the cut-off" * (dropped > 1)
            + ", lower the decimation" * (decimation > 1),
        )
    return Treatment(
        cutoff,
        decimation,
        dropped,
        [part for part, length in zip(parts, lengths, strict=True) if length >= shortest],
    )


def long_enough(
    pairs: Sequence[tuple[Log, Axis | None]], cutoff: float | None, decimation: int | None
) -> list[tuple[Log, Axis | None]]:
    """Return logs with their axes; of several, without those that are too short for the treatment."""

    def examined(log: Log, axis: Axis | None) -> tuple[Log, Axis | None]:
        with located(path=log.origin.name or str(log.source)):
            stretches_of(log, axis, cutoff, decimation)
        return log, axis

    return (
        without_short([partial(examined, *pair) for pair in pairs])
        if len(pairs) > 1
        else list(pairs)
    )


def treat(
    log: Log,
    axis: Axis | None,
    cutoff: float | None = None,
    decimation: int | None = None,
    like: Dataset | None = None,
) -> Dataset:
    """Return the regression rows of a log, with noise and rows of the data set `like` of the same motion, if given."""
    cutoff, decimation, dropped, stretches = stretches_of(log, axis, cutoff, decimation)
    dt, axis = float(log.sample_time), axis or Axis(kind=log.kind)
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
    resolution = step_of(log, axis)

    def rows(*, creeping: bool) -> Dataset | None:
        noises = None if like is None else (like.noise, like.effort_noise)
        segments, noise, effort_noise = zip(
            *(
                segment_of(
                    log, part, cutoff, resolution, noises, held=bool(axis.held), creeping=creeping
                )
                for part in stretches
            ),
            strict=True,
        )
        moving = tuple(segment for segment in segments if np.any(segment.velocity != 0.0))
        if axis.in_cycle:
            moving = tuple(
                replace(segment, first_cycle=_first_cycle(segment, log.kind)) for segment in moving
            )
        dataset = Dataset(
            moving,
            log.kind,
            dt,
            resolution,
            float(np.mean(noise)),
            cutoff,
            decimation,
            dropped,
            axis.held,
            axis.keeps_rests or creeping,
            row_mask=None if like is None else like.in_motion,
            effort_noise=float(np.mean(effort_noise)),
            creeping=creeping,
            units={name: channel.unit for name, channel in log.surroundings.items()},
        )
        return dataset if moving and dataset.time.size >= ROWS_MIN else None

    moves = float(np.ptp(log.position.values)) > CREEPS * resolution
    dataset = rows(creeping=False) if like is None or not like.creeping else None
    dataset = rows(creeping=True) if dataset is None and moves else dataset
    if dataset is None:
        raise InputError(
            "the position hardly changes",
            path="log.position",
            value=f"a range of {with_unit(float(np.ptp(log.position.values)), unit_of('length', log.kind))}",
            mend="Record a motion in both directions, at the working speeds of the axis",
        )
    return dataset


def step_of(log: Log, axis: Axis | None) -> float:
    """Return the resolution of the encoder of an axis, or the smallest step of a log [m or rad]."""
    return (
        smallest_step(log.position) if axis is None or axis.resolution is None else axis.resolution
    )


def smallest_step(position: Channel) -> float:
    """Return the smallest step between samples, the encoder step [m or rad]; 0 without motion."""
    if position.recorded_step is not None:
        return position.recorded_step
    steps = np.abs(np.diff(position.values))
    steps = steps[steps > 0.0]
    return float(steps.min()) if steps.size else 0.0


def segment_of(
    log: Log,
    part: slice,
    cutoff: float,
    resolution: float,  # encoder step [m or rad]
    noises: tuple[float, float] | None = None,  # estimated if missing
    *,
    held: bool = False,  # the effort acts until the next sample
    creeping: bool = False,  # the axis never rests
) -> tuple[Segment, float, float]:
    """Return a `part` of a log without gaps as a segment, and the standard deviations of the noise of its position and effort."""
    dt, position, effort = log.sample_time, log.position.values[part], effort_of(log)[part]
    # The offset of a long stroke would cost digits in the second difference.
    origin = position[0]
    if held:
        # The mean of two consecutive values acts around the sample between them.
        effort = 0.5 * (effort + np.append(effort[:1], effort[:-1]))
    smooth, smooth_effort = (
        low_passed(position - origin, cutoff, dt),
        low_passed(effort, cutoff, dt),
    )
    if noises is None:
        left_over = (position - origin - smooth, effort - smooth_effort)
        noise, effort_noise = (
            DEVIATION_OVER_MEDIAN * float(np.median(np.abs(part))) for part in left_over
        )
        # White noise above the cut-off determines the total noise.
        noises = noise, effort_noise / max(1.0 - 2.0 * (cutoff * dt), 0.1) ** 0.5
    velocity = np.gradient(smooth, dt)
    # Five periods of the cut-off without an encoder step are a rest.
    window = max(round(5 / (cutoff * dt)), 1)
    rest = (
        velocity == 0.0
        if creeping
        else rests(smooth, window, max(1.5 * resolution, 4.0 * noises[0]))
    )
    segment = Segment(
        time=log.time.values[part],
        position=smooth + origin,
        velocity=with_sides(velocity, rest),
        acceleration=np.gradient(velocity, dt),
        effort=smooth_effort,
        recorded=position,
        surroundings={
            name: low_passed(values.values[part], cutoff, dt)
            for name, values in log.surroundings.items()
        },
        regressors=tuple(low_passed(column.values[part], cutoff, dt) for column in log.regressors),
    )
    return segment, *noises


def _first_cycle(segment: Segment, kind: Kind) -> int:
    """Return the number of samples after which a periodic motion repeats."""
    first = whole_cycle(segment.position, segment.velocity)
    if first is None:
        raise InputError(
            "the position never returns to its first value, so bristle does not know the first cycle",
            path="log.start",
            value=f"cycle, and a first position of {with_unit(float(segment.position[0]), unit_of('length', kind))}",
            mend='Write start = "moving" under [log] of the axis file, or begin the log with a whole cycle',
        )
    return first


def aligned(dataset: Dataset, alignment: Alignment) -> Dataset:
    """Return the rows of a log with its channels aligned in time."""
    smoothing, of_position = alignment.smoothing or 0.0, alignment.of_position
    moved = shifted(
        dataset, alignment.delay or 0.0, *((0.0, -smoothing) if of_position else (smoothing,))
    )
    moved = differentiated(moved) if alignment.slow else moved
    return replace(moved, alignment=alignment)


def shifted(
    dataset: Dataset, delay: float, smoothing: float = 0.0, position_smoothing: float = 0.0
) -> Dataset:
    """Return the rows of a log without its `delay` [s] and the filters that cause it; a negative `smoothing` filters the effort now."""
    if not delay and not smoothing and not position_smoothing:
        return dataset
    dt, moved = dataset.sample_time, []
    for segment in dataset.segments:
        sharp = segment.effort if not smoothing else through_filter(segment.effort, -smoothing, dt)
        changes = {"effort": ahead(sharp, delay / dt)}
        if position_smoothing:
            origin = segment.position[0]
            position, recorded = through_filter(
                np.stack([segment.position, segment.recorded]) - origin, -position_smoothing, dt
            )
            velocity = with_sides(np.gradient(position, dt), segment.velocity == 0.0)
            changes |= {
                "position": position + origin,
                "velocity": velocity,
                "recorded": recorded + origin,
            }
            changes["acceleration"] = np.gradient(velocity, dt)
        moved.append(replace(segment, **changes))
    return replace(dataset, segments=tuple(moved), delay=delay)


def calmed(dataset: Dataset) -> tuple[int, float]:
    r"""Return the decimation at which position noise does not hide friction, and the noise at the present decimation.

    In rows with frequencies up to `f`, white noise :math:`\sigma` of the position causes an inertial force of
    :math:`M (2\pi)^2 \sigma \sqrt{\tfrac{2}{5} \Delta t f^5}`, returned as a share of friction. Where that share is
    large, a higher decimation removes the noise. A lower cut-off would blur the reversals of friction.
    """
    alignment, dt, rows = dataset.alignment, dataset.sample_time, dataset.decimation
    if alignment is None or alignment.mass is None:
        return rows, 0.0
    forces = [
        segment.effort - alignment.mass * segment.acceleration for segment in dataset.segments
    ]
    slow = [dataset.without_edges(low_passed(force, alignment.slow, dt)) for force in forces]
    noise = (
        alignment.mass
        * (2.0 * np.pi) ** 2
        * dataset.noise
        * (0.4 * dt * dataset.bandwidth**5) ** 0.5
    )
    share = noise / max(float(np.std(np.concatenate(slow))), np.finfo(float).tiny)
    if share <= HIDES:
        return rows, share
    bandwidth = dataset.bandwidth * (CALM / share) ** 0.4
    most = rows * dataset.effort.size // 1000  # remaining rows
    return max(min(round(0.5 / (bandwidth * dt)), most), rows), share


def differentiated(dataset: Dataset) -> Dataset:
    """Return the rows of a log with an acceleration of fourth order in the step."""
    dt, moved = dataset.sample_time, []
    for segment in dataset.segments:
        acceleration = derivative(derivative(segment.position - segment.position[0], dt), dt)
        moved.append(replace(segment, acceleration=acceleration))
    return replace(dataset, segments=tuple(moved))
