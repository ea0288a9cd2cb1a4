"""Find problems that make a recorded channel unfit for use, and report them.

bristle refuses a log for problems that would spoil a result unnoticed. Legitimate data must pass: a position that rests for
a long time, an effort of zero while the drive is off, a known input that was never switched on.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from bristle.core import Axis, InputError, Model, TooShortError
from bristle.core.diagnostic import Diagnostic, Number
from bristle.logs.channel import Channel, quantisation
from bristle.logs.gather import Gathered
from bristle.logs.turns import runs

FEWEST_SAMPLES = 100
LONG_RUN = 10  # samples
LIMIT_TOLERANCE = 0.05


def problems_of(gathered: Gathered, source: str) -> Iterator[InputError]:
    """Yield problems of the channels of a log, the most severe kind first: one kind at a time."""
    channels = list(gathered.named())
    for name, channel in channels:
        if channel.values.size < FEWEST_SAMPLES:
            place, allowed = (
                f"{source}: column {channel.column!r}",
                f"at least {FEWEST_SAMPLES} samples",
            )
            mend = "Record for longer, or copy the file again"
            yield TooShortError(
                f"is too short to be used as the {name}",
                path=place,
                value=channel.values.size,
                allowed=allowed,
                mend=mend,
            )
            return
    for measure in (_no_measurements, _odd):
        refused = [
            InputError(message, path=f"{source}: column {channel.column!r}", mend=mend)
            for name, channel in channels
            for message, mend in measure(gathered, name, channel)
        ]
        yield from refused
        if refused:
            return


REPAIR = "Correct these samples or delete their rows: bristle splits the log at the gap"


def _no_measurements(gathered: Gathered, name: str, channel: Channel) -> Iterator[tuple[str, str]]:
    values = channel.values
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        reading = "NaN (not a number)" if np.isnan(values[bad[0]]) else "an infinite value"
        yield (
            f"has {reading} in {_samples(bad.size)}, the first at {_moment(gathered, bad[0])}",
            REPAIR,
        )
        return
    far = far_outside(values)
    if far.size:
        at = int(far[np.argmax(np.abs(values[far]))])
        reading = f"{values[at]:.6g} {channel.unit} at {_moment(gathered, at)}"
        yield f"has {reading}, which cannot be a measurement: {_samples(far.size)} in all", REPAIR


def _odd(gathered: Gathered, name: str, channel: Channel) -> Iterator[tuple[str, str]]:
    """Yield constant, clipped or missing readings, among samples that can be measurements."""
    values, unit = channel.values, channel.unit
    # No information if constant.
    if name in ("position", "velocity", "effort", "reference") and np.ptp(values) < SMALLEST:
        mend = "Check that this is the right column and that the axis moved. Remove unnecessary columns from [columns]"
        yield (
            f"is constant ({values[0]:.6g} {unit}), so it gives no information on the {name}",
            mend,
        )
    if name != "position":
        return
    if message := _saturated(gathered, channel):
        yield message, "Widen the range of the sensor or of the recording"
    if lost := spikes(values, channel.step):
        worst = max(lost, key=lambda spike: abs(spike.size))
        yield (
            f"jumps by {worst.size:.6g} {unit} and returns after {_samples(worst.length)} "
            f"at {_moment(gathered, worst.start)}, {len(lost)} such {'place' if len(lost) == 1 else 'places'} in all: "
            "the recording lost readings",
            REPAIR,
        )


def _samples(count: int) -> str:
    return f"{count} {'sample' if count == 1 else 'samples'}"


def longest_run(chosen: np.ndarray) -> tuple[int, int]:
    """Return first index and length of the longest run of true values."""
    longest = max(runs(chosen), key=lambda run: run.stop - run.start, default=slice(0, 0))
    return longest.start, longest.stop - longest.start


def _moment(gathered: Gathered, at: int) -> str:
    time = gathered.channels.get("time")
    has_time = time is not None and at < time.values.size and np.isfinite(time.values[at])
    return f"sample {at}" + (
        f" (t = {time.values[at]:.6g} s)" if time is not None and has_time else ""
    )


def limits_exceeded(gathered: Gathered, axis: Axis) -> Iterator[Diagnostic]:
    """Yield the limits of an axis file that its log exceeds; the limit of the controller is before known inputs."""
    channel = gathered.channels.get("effort")
    if channel is not None:
        own = channel.values
        if all(injected.values.size == own.size for injected in gathered.injected):
            own = own - sum((injected.values for injected in gathered.injected), np.zeros(own.size))
        law = axis.controller.values if isinstance(axis.controller, Model) else {}
        limits = (
            (own, law.get("limit"), "[controller] limit"),
            (channel.values, axis.effort_limit, "[effort] limit"),
        )
        for values, limit, key in limits:
            if limit is not None and np.max(np.abs(values)) > (1 + LIMIT_TOLERANCE) * limit:
                numbers: dict[str, Number] = {
                    "value": float(np.max(np.abs(values))),
                    "limit": float(limit),
                    "key": key,
                }
                yield Diagnostic("beyond_limit", "", "warning", numbers, axis.kind)
                break
    position = gathered.channels.get("position")
    if position is not None and axis.stroke is not None:
        travelled, allowed = float(np.ptp(position.values)), axis.stroke[1] - axis.stroke[0]
        if travelled > (1 + LIMIT_TOLERANCE) * allowed:
            yield Diagnostic(
                "beyond_limit",
                "",
                "warning",
                {"value": travelled, "limit": float(allowed)},
                axis.kind,
            )


class Cut(NamedTuple):
    """Clipping of a signal: the value, the longest run at it, and all samples at it."""

    level: float
    first: int
    longest: int
    samples: int


def clipped(values: np.ndarray, limit: float | None = None, run: int = LONG_RUN) -> Cut | None:
    """Return the clipping of a signal, at a limit if one is known; None if it is not clipped."""
    # A clipped signal is at its extreme far more often than next to it. An effort that is constant at other levels too, like
    # a commanded effort or simulated Coulomb friction, or that moves over few steps of its resolution, is not clipped.
    rounding = 1e-9 * float(np.ptp(values))  # of the range of a channel
    for extreme in (float(values.max()), float(values.min())):
        at_extreme = np.abs(values - extreme) <= rounding
        if limit is not None and abs(extreme) >= (1 - 1e-6) * limit:
            at_extreme = np.sign(extreme) * values >= (1 - 1e-6) * limit
        start, length = longest_run(at_extreme)
        if length < run or extreme == 0:
            continue
        levels, counts = np.unique(np.round(values[~at_extreme] / rounding), return_counts=True)
        if levels.size < 16:  # a commanded effort with few levels is not clipped
            continue
        next_level = counts[-1] if values[at_extreme][0] > values.mean() else counts[0]
        elsewhere = (
            (values < values.max() - rounding) & (values > values.min() + rounding) & (values != 0)
        )
        still = np.append(np.abs(np.diff(values)) <= rounding, False) & elsewhere
        # The extreme has at least 5 times the samples of the next level.
        if at_extreme.sum() >= 5 * next_level and longest_run(still)[1] < length / 2:
            return Cut(extreme, start, length, int(at_extreme.sum()))
    return None


def _saturated(gathered: Gathered, channel: Channel) -> str:
    """Report a position that stops at its extreme within one sample at full speed."""
    # An axis that rests there arrives slowly, or brakes. A clipped reading does neither, while the reference continues.
    values, reference = channel.values, gathered.channels.get("reference")
    speeds = np.abs(np.diff(values))
    # Above 0.05 of the largest speed, an axis cannot stop within one sample.
    abrupt = max(0.05 * float(speeds.max()), 5 * quantisation(values))
    for extreme in (values.max(), values.min()) if np.ptp(values) >= SMALLEST else ():
        start, length = longest_run(values == extreme)
        # Look 7 samples before a stop; below 0.7 of their largest speed the axis brakes.
        before = speeds[max(start - 7, 0) : max(start - 1, 0)]
        if length < LONG_RUN or not before.size or before[-1] <= max(abrupt, 0.7 * before.max()):
            continue
        if reference is not None and reference.values.size == values.size:
            beyond = np.sign(extreme - values.mean()) * (
                reference.values[start : start + length] - extreme
            )
            if beyond.max() <= abrupt:
                continue
        return f"is saturated: it stops abruptly at {extreme:.6g} {channel.unit} at {_moment(gathered, start)}, for {length} samples"
    return ""


LONGEST = 5  # samples
AROUND = 10  # samples on each side that show the possible motion
# No axis is larger or finer in any unit, and products of such numbers stay finite: native solvers of least squares write
# beyond their memory, or hang, if they overflow.
LARGEST, SMALLEST = 1e30, 1e-30


class Spike(NamedTuple):
    """A run of samples that jumps away and returns: first sample, length, and deviation."""

    start: int
    length: int
    size: float


def spikes(values: np.ndarray, resolution: float) -> list[Spike]:
    """Return the places where a position jumps away for a few samples and returns, in order."""
    # Both steps must be far larger than those around: stick-slip, a hard stop, noise and flickering counts have similar
    # neighbours.
    steps = np.diff(values)
    bends = np.abs(np.diff(steps))
    if bends.size < 2 * AROUND:
        return []
    # Threshold relative to the 95 % quantile of the change of step.
    least = max(20.0 * float(np.quantile(bends, 0.95)), 10.0 * resolution)
    chosen: list[Spike] = []
    covered = np.zeros(values.size, dtype=bool)
    for length in range(1, LONGEST + 1):
        ahead, back = steps[:-length], steps[length:]
        suspect = (ahead * back < 0.0) & (np.minimum(np.abs(ahead), np.abs(back)) > least)
        for start in (np.flatnonzero(suspect) + 1).tolist():
            if not covered[start - 1 : start + length + 1].any() and (
                size := _stands_out(values, start, length)
            ):
                covered[start : start + length] = True
                chosen.append(Spike(start, length, size))
    return sorted(chosen)


def _stands_out(values: np.ndarray, start: int, length: int) -> float:
    """Return the deviation of a run of samples from the line between its neighbours; 0 if it can be motion."""
    off = (
        values[start : start + length]
        - np.linspace(values[start - 1], values[start + length], length + 2)[1:-1]
    )
    before = np.diff(values[max(start - AROUND, 0) : start])
    after = np.diff(values[start + length : start + length + AROUND])
    step = max(np.abs(before).max(initial=0.0), np.abs(after).max(initial=0.0))
    bend = max(np.abs(np.diff(before)).max(initial=0.0), np.abs(np.diff(after)).max(initial=0.0))
    edges = np.abs(
        [values[start] - values[start - 1], values[start + length] - values[start + length - 1]]
    )
    stands_out = (
        before.size + after.size >= AROUND
        and (np.all(off > 0.0) or np.all(off < 0.0))
        and np.abs(off).min() > 10.0 * bend  # relative to the largest change of step nearby
        and edges.min() > 3.0 * step  # relative to the largest step nearby
    )
    return float(off[0]) if stands_out else 0.0


def far_outside(values: np.ndarray) -> np.ndarray:
    """Return the samples that cannot be measurements: larger than `LARGEST`, or far off for a few samples."""
    huge = np.flatnonzero(np.abs(values) > LARGEST)
    if huge.size:
        return huge
    low, middle, high = np.quantile(values, (0.01, 0.5, 0.99))
    if high == low:
        return huge
    # Relative to the range of 98 % of the samples.
    far = np.flatnonzero(np.abs(values - middle) > 1e6 * (high - low))
    # A channel that rests for most of the log and then moves is legitimate; its motion lasts more than a few samples.
    return (
        far
        if all(run.size <= LONGEST for run in np.split(far, np.flatnonzero(np.diff(far) > 1) + 1))
        else huge
    )
