"""Two sides of one axis, held against each other: what changed, and how sure that is."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from bristle.comparison.course import course_of, turn_courses
from bristle.comparison.findings import Findings, findings_of
from bristle.comparison.measures import Measure, SlidingRows, effort_measures, error_measures, turn_measures
from bristle.comparison.resampling import Plan, changed, plan_of
from bristle.comparison.result import Change, Comparison, Shared
from bristle.comparison.sides import LogAndAxis, Side, sides_of
from bristle.core.errors import InputError
from bristle.core.variable import Kind
from bristle.logs.log import Log

__all__ = ["compare"]

WINDOW = 0.1  # of the time between two reversals
LEAST_WINDOW = 4  # samples

Sides = tuple[Side, Side]


def compare(before: Sequence[LogAndAxis], after: Sequence[LogAndAxis], window: float | None = None) -> Comparison:
    """Compare two sides.

    Parameters
    ----------
    before, after : sequence of (Log, Axis or None)
        The logs of each side, at least one, with what is known of the axis.
    window : float, optional
        Time behind a reversal in which its peak is looked for [s]; a tenth of the time between two of them by default.

    Returns
    -------
    Comparison
        What changed.

    Raises
    ------
    InputError
        If the logs are of different kinds of axis, one stands on both sides, one has neither reference nor effort, or
        they share no motion.
    """
    logs = [log for log, _ in (*before, *after)]
    _refuse_unlike(before, after)
    follows = all(log.reference is not None for log in logs)
    tells_effort = all(log.effort is not None for log in logs)
    if not follows and not tells_effort:
        raise InputError(
            "have neither all a reference nor all an effort: there is nothing to compare",
            path="logs",
            mend="Record the reference, or the effort",
        )
    low, high, complete = sides_of(before, after, follows=follows, tells_effort=tells_effort)
    plan = plan_of(low.kinds, high.kinds)
    if not plan.before.size:
        _refuse_other_motion(follows=follows)
    used, kind = (low.of(plan.before), high.of(plan.after)), logs[0].kind
    samples = _window_samples(used, window) if follows else None
    rows = SlidingRows(*used) if tells_effort and not (low.reason or high.reason) else None
    measures = [
        *(error_measures() if follows else ()),
        *(turn_measures(samples) if samples else ()),
        *(effort_measures() if tells_effort else ()),
        *(rows.measures() if rows else ()),
    ]
    changes, as_one = _changes(measures, used, plan, kind)
    shared = _shared((low, high), plan, complete=complete, as_one=float(np.median(as_one)))
    sides = tuple(log for log, _ in before), tuple(log for log, _ in after)
    return Comparison(
        kind=kind,
        changes={name: change for name, change in changes.items() if "at_speeds" not in name},
        friction_curve=_friction_curve(rows, changes),
        shared=shared,
        window=samples * used[0].recordings[0].sample_time if samples else None,
        course=course_of(*used, follows=follows),
        turns=turn_courses(*used, samples) if samples else (),
        logs_before=sides[0],
        logs_after=sides[1],
        diagnostics=findings_of(
            Findings(*sides, shared, "friction.level" in changes, reason=low.reason or high.reason, kind=kind, widths=_widths(changes))
        ),
    )


def _refuse_unlike(before: Sequence[LogAndAxis], after: Sequence[LogAndAxis]) -> None:
    kinds = {log.kind for log, _ in (*before, *after)}
    if len(kinds) > 1:
        raise InputError(
            "are of different kinds of axis", path="logs", value=" and ".join(sorted(kinds)), mend="Compare two logs of one axis"
        )
    for (first, _), (second, _) in product(before, after):
        if _is_same(first, second):
            raise InputError(
                "is the same log on both sides",
                path=second.origin.name or "after",
                mend="Name the log from before the change, and one from after it",
            )


def _is_same(first: Log, second: Log) -> bool:
    names = [name for name, _ in first.channels()]
    if len(first) != len(second) or names != [name for name, _ in second.channels()]:
        return False
    pairs = zip(first.channels(), second.channels(), strict=True)
    return all(np.array_equal(outcome.values, second_channel.values) for (_, outcome), (_, second_channel) in pairs)


def _refuse_other_motion(*, follows: bool) -> None:
    what = "references" if follows else "positions, compared because there is no reference,"
    raise InputError(
        f"the {what} share no motion: no cycle of one is like a cycle of the other",
        path="after",
        mend="Record both with the same reference: same places, same speed",
    )


def _window_samples(sides: Sides, window: float | None) -> int | None:
    """Return how many samples behind a reversal are looked at; None where nothing reverses."""
    between = [
        step for side in sides for number in {cycle.recording for cycle in side.cycles} for step in np.diff(side.recordings[number].turns)
    ]
    sample_time = sides[0].recordings[0].sample_time
    if window is not None:
        return max(round(window / sample_time), 1)
    turns = any(side.recordings[cycle.recording].turns.size for side in sides for cycle in side.cycles)
    if not between:
        between = [cycle.count for side in sides for cycle in side.cycles] if turns else []
    return max(round(WINDOW * float(np.median(between))), LEAST_WINDOW) if between else None


def _changes(measures: Sequence[Measure], sides: Sides, plan: Plan, kind: Kind) -> tuple[dict[str, Change], list[float]]:
    """Return each quantity that both sides tell, and how many cycles count as one in each."""
    changes: dict[str, Change] = {}
    as_one, sums = [], {}
    for measure in measures:
        if measure.sums not in sums:  # several quantities rest on the same ones
            sums[measure.sums] = [measure.sums(side) for side in sides]
        low, high = sums[measure.sums]
        outcome = changed(measure.value, low, high, plan)
        if outcome is not None and np.isfinite(outcome.before) and np.isfinite(outcome.after):
            values = outcome.before, outcome.after, outcome.interval
            changes[measure.name] = Change(measure.name, measure.quantity, *values, kind)
            as_one.append(outcome.as_one)
    return changes, as_one


def _friction_curve(rows: SlidingRows | None, changes: dict[str, Change]) -> list[tuple[float, Change]]:
    if rows is None:
        return []
    at = [changes.get(f"friction.at_speeds.{number}") for number in range(len(rows.speeds))]
    return [(speed, change) for speed, change in zip(rows.speeds, at, strict=True) if change is not None]


def _widths(changes: dict[str, Change]) -> list[float]:
    """Return the half-width of each interval over the value before."""
    is_told = [change for change in changes.values() if change.interval is not None and change.before != 0.0]
    return [0.5 * float(np.ptp(change.interval)) / abs(change.before) for change in is_told]  # type: ignore[arg-type]


def _shared(sides: Sides, plan: Plan, *, complete: bool, as_one: float) -> Shared:
    in_common = set(sides[0].kinds) & set(sides[1].kinds)
    counts = [[(cycle.count, cycle.kind in in_common) for cycle in side.cycles] for side in sides]
    shares = [100.0 * sum(count for count, is_in in side if is_in) / sum(count for count, _ in side) for side in counts]
    return Shared(shares[0], shares[1], plan.before.size, plan.after.size, np.unique(plan.kinds_before).size, complete, plan.paired, as_one)
