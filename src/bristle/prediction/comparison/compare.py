"""Comparison of two sides of an axis: the changes, with their uncertainty."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise, product

import numpy as np

from bristle.core import InputError, guarded
from bristle.core.diagnostic import Diagnostic, Number, Severity
from bristle.core.variable import Kind
from bristle.logs.log import Log
from bristle.prediction.comparison.cycles import SAME_PERIOD, LogAndAxis, Side, sides_of
from bristle.prediction.comparison.measures import (
    Measure,
    SlidingRows,
    course_of,
    level_measures,
    turn_courses,
    turn_measures,
)
from bristle.prediction.comparison.resampling import MANY, Plan, changed, plan_of
from bristle.prediction.comparison.result import ROUNDING, Change, Comparison, Shared

WINDOW = 0.1  # of the time between two reversals
FEW = 6  # cycles of a side

Sides = tuple[Side, Side]


@guarded()
def compare(
    before: Sequence[LogAndAxis], after: Sequence[LogAndAxis], window: float | None = None
) -> Comparison:
    """Compare two sides of one or several logs, each with its axis file; search `window` [s] after each reversal for its peak error."""
    _refuse_unlike(before, after)
    logs = [log for log, _ in (*before, *after)]
    follows = all(log.reference is not None for log in logs)
    tells_effort = all(log.effort is not None for log in logs)
    if not follows and not tells_effort:
        raise InputError(
            "must all contain a reference, or all contain an effort",
            path="logs",
            mend="Record the reference, or the effort",
        )
    low, high, complete = sides_of(before, after, follows=follows, tells_effort=tells_effort)
    plan = plan_of(low.kinds, high.kinds, low.logs, high.logs)._replace(in_turn=_in_turn(logs))
    if not plan.before.size:
        signals = "positions (compared because a log has no reference)"
        if follows:
            signals = "references"
        raise InputError(
            f"no cycle of the {signals} is the same before and after the change",
            path="after",
            mend="Record both logs with the same reference: the same positions at the same speed",
        )
    sides = ((low, plan.before), (high, plan.after))
    used: Sides = tuple(
        replace(side, cycles=[side.cycles[number] for number in numbers]) for side, numbers in sides
    )  # type: ignore[assignment]
    kind = logs[0].kind
    sample_time = used[0].cycles[0].recording.sample_time
    reason = low.reason or high.reason
    measures: list[Measure] = []
    turns = ()
    seconds = None
    at_speeds = {}
    if follows:
        measures += level_measures("error", "following_error", "length")
        samples = _window_samples(used, window)
        if samples:
            measures += turn_measures(samples)
            turns = turn_courses(*used, samples)
            seconds = samples * sample_time
    if tells_effort:
        measures += level_measures("effort", "effort", "force")
    if tells_effort and reason is None:
        rows = SlidingRows(*used)
        measures += rows.measures()
        at_speeds = {
            f"friction.at_speeds.{number}": speed for number, speed in enumerate(rows.speeds)
        }
    changes, as_one = _changes(measures, used, plan, kind)
    in_common = set(low.kinds) & set(high.kinds)
    counts = [
        [(cycle.count, cycle.kind in in_common) for cycle in side.cycles] for side in (low, high)
    ]
    shares = [
        100.0 * sum(count for count, is_in in side if is_in) / sum(count for count, _ in side)
        for side in counts
    ]
    motions = np.unique(plan.kinds_before).size
    shared = Shared(
        shares[0],
        shares[1],
        plan.before.size,
        plan.after.size,
        motions,
        complete,
        plan.paired,
        float(np.median(as_one)),
    )
    return Comparison(
        kind=kind,
        changes={name: change for name, change in changes.items() if name not in at_speeds},
        friction_curve=[
            (speed, changes[name]) for name, speed in at_speeds.items() if name in changes
        ],
        shared=shared,
        window=seconds,
        course=course_of(*used, follows=follows),
        turns=turns,
        logs_before=tuple(log for log, _ in before),
        logs_after=tuple(log for log, _ in after),
        diagnostics=_diagnostics(before, after, shared, changes, reason),
    )


def _in_turn(logs: Sequence[Log]) -> bool:
    """Return whether the logs follow each other in time, so that their order is known."""
    spans = sorted((float(log.time.values[0]), float(log.time.values[-1])) for log in logs)
    return all(end < begin for (_, end), (begin, _) in pairwise(spans))


def _refuse_unlike(before: Sequence[LogAndAxis], after: Sequence[LogAndAxis]) -> None:
    for name, logs in {"before": before, "after": after}.items():
        if not len(logs):
            raise InputError(
                "has no logs",
                path=name,
                mend="Name a log from before the change, and another log from after the change",
            )
    kinds = {log.kind for log, _ in (*before, *after)}
    if len(kinds) > 1:
        raise InputError(
            "are of different kinds of axis",
            path="logs",
            value=" and ".join(sorted(kinds)),
            mend="Compare logs of one axis",
        )
    for (first, _), (second, _) in product(before, after):
        channels = dict(first.channels())
        further = dict(second.channels())
        is_alike = len(first) == len(second) and list(channels) == list(further)
        if is_alike and all(
            np.array_equal(channel.values, further[name].values)
            for name, channel in channels.items()
        ):
            raise InputError(
                "is also the log from before the change",
                path=second.origin.name or "after",
                mend="Name a log from before the change, and another log from after the change",
            )


def _window_samples(sides: Sides, window: float | None) -> int | None:
    """Return the number of samples in the window after a reversal; None without reversals."""
    cycles = [cycle for side in sides for cycle in side.cycles]
    if window is not None:
        longest = min(cycle.recording.motion.size * cycle.recording.sample_time for cycle in cycles)
        if not 0.0 < window <= longest:
            raise InputError(
                "out of range",
                path="window",
                value=window,
                allowed=f"up to {longest:.3g} s, the shortest log",
            )
        return max(round(window / cycles[0].recording.sample_time), 1)
    turns = [
        turns
        for turns in {id(cycle.recording): cycle.recording.turns for cycle in cycles}.values()
        if turns.size
    ]
    between = np.concatenate([np.empty(0), *map(np.diff, turns)])
    if turns and not between.size:
        between = np.array([cycle.count for cycle in cycles])
    if between.size:
        return max(round(WINDOW * float(np.median(between))), 4)
    return None


def _changes(
    measures: Sequence[Measure], sides: Sides, plan: Plan, kind: Kind
) -> tuple[dict[str, Change], list[float]]:
    """Return each quantity that both sides have, and the number of correlated cycles for each."""
    changes: dict[str, Change] = {}
    as_one = []
    sums = {}
    for measure in measures:
        if measure.sums not in sums:  # several quantities share their sums
            sums[measure.sums] = [measure.sums(side) for side in sides]
        low, high = sums[measure.sums]
        outcome = changed(measure.value, low, high, plan)
        if outcome is not None and np.isfinite(outcome.before) and np.isfinite(outcome.after):
            changes[measure.name] = Change(
                measure.name,
                measure.quantity,
                outcome.before,
                outcome.after,
                outcome.interval,
                kind,
            )
            as_one.append(outcome.as_one)
    return changes, as_one


def _diagnostics(
    before: Sequence[LogAndAxis],
    after: Sequence[LogAndAxis],
    shared: Shared,
    changes: dict[str, Change],
    reason: InputError | None,
) -> tuple[Diagnostic, ...]:
    """Return warnings, then remarks on the basis of the comparison."""
    sides = {"before": [log for log, _ in before], "after": [log for log, _ in after]}
    logs = [*sides["before"], *sides["after"]]
    lacking = {
        code: {
            "sides": tuple(
                name
                for name, own in sides.items()
                if any(getattr(log, channel) is None for log in own)
            )
        }
        for channel, code in (("reference", "no_reference"), ("effort", "no_effort"))
    }
    percents = {"before_percent": shared.before_percent, "after_percent": shared.after_percent}
    with_interval = [
        change
        for change in changes.values()
        if change.interval is not None and change.before != 0.0
    ]
    cycles: dict[str, Number] = {}
    fewest = min(shared.cycles_before, shared.cycles_after)
    if with_interval:
        cycles["cycles"] = fewest
    fewest_logs = min(len(before), len(after))
    periods = [log.sample_time for log in logs]
    # Such a narrow interval means cycles without scatter.
    identical = any(
        0.5 * float(np.ptp(change.interval)) < ROUNDING * abs(change.before)  # type: ignore[arg-type]
        for change in with_interval
    )
    is_judged = "friction.level" in changes or any(log.effort is None for log in logs)
    said: list[tuple[Severity, str, bool, dict[str, Number]]] = [
        *(
            ("warning", code, bool(numbers["sides"]), {**numbers})
            for code, numbers in lacking.items()
        ),
        ("warning", "motions_differ", min(percents.values()) < 99.0, {**percents}),
        ("warning", "pieces_for_cycles", not shared.complete, {}),
        ("warning", "few_cycles", not with_interval or (shared.complete and fewest < FEW), cycles),
        ("warning", "cycles_identical", identical, {}),
        ("warning", "friction_not_told", not is_judged, {"why": str(reason or "")}),
        ("note", "cycles_alike", shared.as_one > 2.0, {"cycles": shared.as_one}),
        (
            "note",
            "sample_times_differ",
            max(periods) > min(periods) * (1.0 + SAME_PERIOD),
            {"longest": max(periods)},
        ),
        ("note", "one_recording", fewest_logs == 1, {}),
        (
            "note",
            "few_recordings",
            2 <= fewest_logs < MANY and not shared.paired,
            {"logs": fewest_logs},
        ),
    ]
    return tuple(
        Diagnostic(code, "", severity, numbers, logs[0].kind)
        for severity, code, holds, numbers in said
        if holds
    )
