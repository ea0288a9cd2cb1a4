"""The first page of a simulated experiment: whether compensation helps there, by how much, and what it takes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from bristle.core.status import Status
from bristle.core.typography import number
from bristle.core.variable import unit_of
from bristle.report.best import Standing, is_alike, percent_text, standing
from bristle.report.compensation import gain_of, pair_of
from bristle.report.front import Front, Ruling, about, answered, fixed, length_text
from bristle.report.laws import law_lines
from bristle.simulation.reversals import swing_at_worst_reversal

if TYPE_CHECKING:
    from bristle.core.experiment import Variant
    from bristle.report.page import Picture
    from bristle.simulation.result import SimulationResult, VariantResult

__all__ = ["is_open", "simulation_front", "simulation_ruling"]

MANY = 10.0  # times less: told as a factor
ON_THE_MACHINE = "record the machine without and with it, then `bristle compare before.csv after.csv --axis axis.toml`"


def is_open(result: SimulationResult) -> bool:
    """Return whether no variant has a loop."""
    return all(variant.effort is not None for variant in result.experiment.variants)


def simulation_ruling(result: SimulationResult, warnings: Sequence[str] = ()) -> Ruling:
    """Return whether the variants of an experiment are worth having, and why."""
    failed = [f"{name}: {reason}" for name, reason in result.refused.items()]
    completed = []
    for name, variant in result.variants.items():
        if variant.status is Status.NOT_FINITE:
            failed.append(f"{name}: {variant.status.sentence}")
        else:
            completed.append(variant)
    # What is refused was warned of in the same words.
    doubts = tuple(dict.fromkeys([*warnings, *failed]))
    if not completed:
        return Ruling("no", "It does not run", doubts)
    level = "with_care" if doubts else "usable"
    if is_open(result):
        return Ruling(level, "No loop: the effort is given", doubts)
    rank = standing(result)
    if rank is None:
        return Ruling("with_care", "Nothing to compare with", doubts)
    if len(completed) == 1:
        return Ruling(level, "It runs: one loop, nothing to compare with", doubts)
    return _compared(result, rank, level, doubts)


def _compared(result: SimulationResult, rank: Standing, level: str, doubts: tuple[str, ...]) -> Ruling:
    fed, plain = (_variant(result, variant.name).feedforward.friction for variant in (rank.best, rank.base))
    is_compensation = fed is not None and plain is None and (rank.alike or _is_friction(result, rank))
    subject = "Compensation" if is_compensation else "Another loop"
    if rank.best is rank.base:
        subject = "Compensation" if gain_of(result) is not None else "Another loop"
        return Ruling("no", f"{subject} does not help", (f"no variant errs less than {rank.base.name}", *doubts))
    if rank.alike:
        return Ruling("with_care", f"{subject} hardly helps", (_instead(rank, result), *doubts))
    return Ruling(level, f"{subject} helps", (_instead(rank, result), *doubts))


def _is_friction(result: SimulationResult, rank: Standing) -> bool:
    """Return whether the friction fed forward helps by itself, and not the other law alone that stands beside it."""
    pair = pair_of(result.experiment, _variant(result, rank.best.name))
    plain = None if pair is None else result.variants.get(pair[0].name)
    return plain is None or plain.status is Status.NOT_FINITE or not is_alike(rank.best, plain)


def _instead(rank: Standing, result: SimulationResult) -> str:
    kind = result.experiment.kind
    new, old = (length_text(variant.following_error.peak_to_peak, kind) for variant in (rank.best, rank.base))
    less = "hardly less" if rank.alike else _less(rank)
    return f"following error {new} ({rank.best.name}) instead of {old} ({rank.base.name}) peak to peak, {less}"


def _less(rank: Standing) -> str:
    """Return by how much the error is less: a factor where percent would all be 99 and some."""
    ratio = rank.base.following_error.peak_to_peak / rank.best.following_error.peak_to_peak
    if ratio > MANY * MANY:
        return "less than a hundredth"
    if ratio > MANY:
        return f"by a factor of {number(ratio, digits=2)}"
    return f"{percent_text(rank.base, rank.best)} less".replace(" ", "\u00a0")


def _variant(result: SimulationResult, name: str) -> Variant:
    return next(variant for variant in result.experiment.variants if variant.name == name)


def simulation_front(result: SimulationResult, warnings: Sequence[str], figure: Picture | None) -> Front:
    """Return the first page of a simulated experiment."""
    ruling, count = simulation_ruling(result, warnings), len(result.experiment.variants) + len(result.refused)
    name, runs = result.experiment.name, max((variant.runs for variant in result.variants.values()), default=0)
    of = f"mean of {runs} runs" if runs > 1 else ""
    facts = about(f"simulated, {count} {'variant' if count == 1 else 'variants'}", of)
    rank = None if is_open(result) else standing(result)
    answers = _open_answers(result) if rank is None else _loop_answers(result, rank)
    return Front(f"{name}: simulated", facts, *ruling[:2], ruling.reasons, answers, figure, "variants")


def _open_answers(result: SimulationResult) -> list[tuple[str, list[str]]]:
    kind = result.experiment.kind
    completed = [variant for variant in result.variants.values() if variant.status is not Status.NOT_FINITE]
    went = [f"moves by {length_text(variant.motion.peak_to_peak, kind)} ({variant.name})" for variant in completed if variant.is_open]
    return answered(
        went or ["nothing completed against which an error could be measured"],
        ["nothing: no loop was compared with another"],
        [f"effort {_effort(variant)} ({variant.name})" for variant in completed] or ["nothing completed"],
        ["it is a simulation: what the models leave out, it leaves out"],
        ["mend what the verdict names" if not completed else "compare the motion with a log of the same effort"],
    )


def _loop_answers(result: SimulationResult, rank: Standing) -> list[tuple[str, list[str]]]:
    best = _variant(result, rank.best.name)
    place = "as it is" if rank.best is rank.base else "of the file"
    return answered(
        _quality(rank, result),
        [f"variant {best.name}, {place}", *law_lines(best)],
        _cost(rank, result),
        _trust(rank, result),
        _next(rank, result),
    )


def _quality(rank: Standing, result: SimulationResult) -> list[str]:
    kind, best = result.experiment.kind, rank.best
    lines = [
        f"following error {length_text(best.following_error.peak_to_peak, kind)} peak to peak, "
        f"{length_text(best.following_error.rms, kind)} root mean square ({best.name})"
    ]
    swings = [_at_reversal(result, variant) for variant in (rank.best, rank.base)]
    if swings[0] is None or swings[1] is None:
        return lines
    new, old = (length_text(swing, kind) for swing in swings if swing is not None)
    beside = "" if best is rank.base else f" instead of {old}"
    return [*lines, f"at its worst reversal: {new}{beside}"]


def _at_reversal(result: SimulationResult, variant: VariantResult) -> float | None:
    run = _variant(result, variant.name).run
    judged = slice(round(run.settle / run.sample_time), None)
    reference = variant.reference[judged]
    return swing_at_worst_reversal(reference, reference - variant.measured[judged]) if reference.size else None


def _effort(variant: VariantResult) -> str:
    unit = unit_of("force", variant.kind)
    return f"{fixed(variant.effort_rms, unit)} root mean square, {fixed(variant.effort_peak, unit)} at its peak"


def _cost(rank: Standing, result: SimulationResult) -> list[str]:
    kind, gain = result.experiment.kind, gain_of(result)
    lines = []
    if gain is not None and len(gain.steps) > 1 and gain.alone:
        before, after = gain.steps[-2:]
        lines.append(
            f"friction fed forward alone: from {length_text(before.peak_to_peak, kind)} ({before.name}) to "
            f"{length_text(after.peak_to_peak, kind)}"
        )
    beside = "" if rank.best is rank.base else f"; that of {rank.base.name} {_effort(rank.base)}"
    lines.append(f"effort {_effort(rank.best)}{beside}")
    limit = _variant(result, rank.best.name).run.effort_limit
    if math.isfinite(limit) and rank.best.effort_peak >= limit:
        lines.append("the drive is at its limit")
    return lines


def _trust(rank: Standing, result: SimulationResult) -> list[str]:
    gain, runs = gain_of(result), rank.best.runs
    lines = [gain.caveat if gain is not None else "This is a simulation: confirm it on the machine."]
    spread = rank.best.spread.get("following_error", {}).get("peak_to_peak")
    if runs > 1 and spread:
        lines.append(f"{runs} runs with other noise: ± {length_text(float(spread), result.experiment.kind)}")
    return lines


def _next(rank: Standing, result: SimulationResult) -> list[str]:
    if rank.best is rank.base:
        return ["what limits this loop, and gains for it: `bristle design EXPERIMENT.toml`"]
    return [ON_THE_MACHINE, "what the loop still errs by: `bristle design EXPERIMENT.toml`"]
