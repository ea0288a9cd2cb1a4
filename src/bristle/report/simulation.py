"""The report of a simulated experiment: its variants, the gain of compensation, and its cost."""

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from bristle.core import NORMAL_95, Diagnostic, Status, unit_of
from bristle.exports import promise_of_law
from bristle.prediction import Claim
from bristle.report.cards import COMPARE, Card, Step
from bristle.report.compensation import (
    change_text,
    closing_sentences,
    gain_of,
    is_alike,
    pair_of,
    standing,
    variant_of,
)
from bristle.report.loops import (
    direction_table,
    focus_of,
    law_lines,
    loop_doubts,
    loop_warnings,
    parts_table,
    run_table,
    variant_table,
    variants_as_data,
)
from bristle.report.messages import as_data
from bristle.report.page import Block, Front, Ruling, Section, about, report_page
from bristle.report.table import fixed, length_text
from bristle.simulation import SimulationResult, VariantResult, swing_at_worst_reversal

BETTER = "find better gains: `bristle design EXPERIMENT.toml`"
ON_THE_MACHINE = f"record the machine without and with compensation: {COMPARE}"


def simulation_report(
    result: SimulationResult,
    *,
    warnings: Sequence[str] = (),
    doubts: Sequence[str] | None = None,
    claims: Sequence[Claim] = (),
    **options: Any,
) -> str:
    """Return the report of a simulated experiment as an HTML page, with `claims` of its best variant; options as of `report_page`."""
    variants, is_open = result.experiment.variants, _is_open(result)
    facts: dict[str, Any] = {
        "simulation": result,
        "open_loop": result if is_open else None,
        "focus": None if is_open else focus_of(result),
        "gain_pair": None,
    }
    if (rank := None if is_open else standing(result)) is not None:
        facts |= {
            "at_reversal": list(dict.fromkeys((rank.base.name, rank.best.name))),
            "loops": result,
        }
    gain = None if is_open else gain_of(result)
    if gain is not None and gain.alone and len(gain.steps) > 1:
        facts["gain_pair"] = tuple(step.name for step in gain.steps[-2:])
    if is_open:
        basis = [
            "An open loop: without a controller, the given effort is constant over each sample."
        ]
        basis += [
            f"Effort of {variant.name}: {variant.effort.description}."
            for variant in variants
            if variant.effort is not None
        ]
    else:
        basis = [
            "The following error is reference minus encoder reading. The true error is reference minus true position."
        ]
    best = None if rank is None else Block("items", _values_of(result, rank.best, claims))
    sections = [
        Section(
            "variants",
            "Motions and efforts" if is_open else "Errors and efforts",
            [variant_table(result)],
            "Variants",
        ),
        Section(
            "results",
            "Results",
            [*(f"{warning}." for warning in warnings), *closing_sentences(result), best],
            "Results",
        ),
        Section(
            "directions",
            "Forward and backward",
            [None if is_open else direction_table(result)],
            "Variants",
        ),
        Section(
            "assumptions",
            "Simulated variants",
            [*basis, run_table(variants), *map(parts_table, variants)],
            "Models",
        ),
    ]
    front = _front(result, warnings if doubts is None else doubts)
    return report_page("simulation", facts, front, sections, **options)


def simulation_summary(
    result: SimulationResult,
    *,
    files: Mapping[str, str],
    provenance: Mapping[str, str],
    diagnostics: Sequence[Diagnostic] = (),
    claims: Sequence[Claim] = (),
) -> dict[str, Any]:
    """Return a simulated experiment in numbers, in SI units of the axis.

    It names the log `files`, the `diagnostics` of the loops, and the moves that the feedforward of the best variant helps.
    """
    kind = result.experiment.kind
    return {
        "name": result.experiment.name,
        "kind": kind,
        "error_unit": unit_of("length", kind),
        "effort_unit": unit_of("force", kind),
        "runs": max((variant.runs for variant in result.variants.values()), default=0),
        "variants": variants_as_data(result)
        | {
            name: {"status": reason, "completed": False, "runs": 0}
            for name, reason in result.refused.items()
        },
        "claims": [claim._asdict() for claim in claims],
        "files": files,
        "verdict": simulation_ruling(result, loop_doubts(diagnostics)).as_data(),
        "warnings": loop_warnings(diagnostics),
        "diagnostics": as_data(diagnostics),
        "provenance": provenance,
    }


def _is_open(result: SimulationResult) -> bool:
    """Return whether all variants are open loops."""
    return all(variant.effort is not None for variant in result.experiment.variants)


def simulation_ruling(result: SimulationResult, warnings: Sequence[str] = ()) -> Ruling:
    """Return the verdict on the variants of an experiment, with its reasons."""
    completed = [
        variant for variant in result.variants.values() if variant.status is not Status.NOT_FINITE
    ]
    failed = [f"{name}: {reason}" for name, reason in result.refused.items()]
    failed += [
        f"{name}: {variant.status.sentence}"
        for name, variant in result.variants.items()
        if variant not in completed
    ]
    # A refused variant has the same text among the warnings.
    doubts = tuple(dict.fromkeys([*warnings, *failed]))
    if not completed:
        return Ruling("no", "It does not run", doubts)
    level = "with_care" if doubts else "usable"
    if _is_open(result):
        return Ruling(level, "No loop: the effort is given", doubts)
    rank = standing(result)
    if rank is None:
        return Ruling("with_care", "The present loop does not run: no comparison", doubts)
    if len(completed) == 1:
        return Ruling(level, "It runs, but there is no second loop to compare", doubts)
    if rank.best is rank.base:
        subject = "Compensation" if gain_of(result) is not None else "Another loop"
        return Ruling(
            "no",
            f"{subject} does not help",
            (f"no variant is better than {rank.base.name}", *doubts),
        )
    fed, plain = (
        variant_of(result, variant.name).feedforward.friction for variant in (rank.best, rank.base)
    )
    # Friction feedforward must help without the change of the law.
    pair = pair_of(result.experiment, variant_of(result, rank.best.name))
    partner = None if pair is None else result.variants.get(pair[0].name)
    by_itself = (
        partner is None or partner.status is Status.NOT_FINITE or not is_alike(rank.best, partner)
    )
    is_compensation = fed is not None and plain is None and (rank.alike or by_itself)
    helps = "hardly helps" if rank.alike else "helps"
    subject = "Compensation" if is_compensation else "Another loop"
    return Ruling(
        "with_care" if rank.alike else level, f"{subject} {helps}", (rank.instead, *doubts)
    )


def _front(result: SimulationResult, warnings: Sequence[str]) -> Front:
    count, runs = (
        len(result.experiment.variants) + len(result.refused),
        max((loop.runs for loop in result.variants.values()), default=0),
    )
    facts = about(
        f"{count} {'variant' if count == 1 else 'variants'}",
        f"mean of {runs} runs" if runs > 1 else "",
    )
    rank = None if _is_open(result) else standing(result)
    ruling, heading = simulation_ruling(result, warnings), f"{result.experiment.name}: simulated"
    if rank is not None and rank.best is not rank.base and rank.instead in ruling.reasons[:1]:
        ruling = ruling.beyond_title
    kind, unit, gain = (
        result.experiment.kind,
        unit_of("force", result.experiment.kind),
        gain_of(result),
    )
    front = Front(heading, facts, ruling, title="No variant completed", basis="(simulated)")
    if rank is None:
        completed = [
            loop for loop in result.variants.values() if loop.status is not Status.NOT_FINITE
        ]
        if moved := [loop for loop in completed if loop.is_open]:
            front = front._replace(
                title=f"The open loop moves by {length_text(moved[0].motion.peak_to_peak, kind)}"
            )
        return front._replace(
            cards=[
                Card(f"Effort, {loop.name}", fixed(loop.effort_rms, unit), "rms")
                for loop in completed[:4]
            ]
        )
    best, base, subject = rank.best, rank.base, rank.best.error_word
    spread = best.spread.get(best.compared, {}).get("peak_to_peak")
    (old, old_rms), (peak, rms) = (
        (error.peak_to_peak, error.rms) for error in (base.compared_error, best.compared_error)
    )
    title = f"{subject}: {change_text(old, peak, partial(length_text, kind=kind), 'peak to peak')}"
    if gain is not None and gain.alone and len(gain.steps) > 1:
        title = gain.headline
    elif best is base:
        title = f"{subject} {length_text(peak, kind)} peak to peak"
    half = (
        100.0 * NORMAL_95 * float(spread) / math.sqrt(best.runs) / peak
        if spread and best.runs > 1 and peak
        else None
    )
    swings = [_swing(result, loop) for loop in (best, base)]
    cards = [
        Card("Error, peak to peak", length_text(peak, kind), best.name, half),
        Card("Error, rms", length_text(rms, kind), _instead(best, base, old_rms)),
    ]
    if swings[0] is not None and swings[1] is not None:
        cards.append(
            Card("Worst reversal", length_text(swings[0], kind), _instead(best, base, swings[1]))
        )
    cards.append(
        Card("Effort, rms", fixed(best.effort_rms, unit), f"peak {fixed(best.effort_peak, unit)}")
    )
    return front._replace(
        title=title, cards=cards, next=Step.of(BETTER if best is base else ON_THE_MACHINE)
    )


def _instead(best: VariantResult, base: VariantResult, length: float) -> str:
    return "" if best is base else f"instead of {length_text(length, best.kind)}"


def promised_in(result: SimulationResult) -> tuple[Claim, ...]:
    """Return the moves that the friction feedforward of the best variant helps."""
    rank = None if _is_open(result) else standing(result)
    return () if rank is None else promise_of_law(variant_of(result, rank.best.name))


def _values_of(result: SimulationResult, best: VariantResult, claims: Sequence[Claim]) -> list[str]:
    """Return the gains of the best variant, whether its drive is at its limit, and the scatter of its runs."""
    variant, spread = (
        variant_of(result, best.name),
        best.spread.get("following_error", {}).get("peak_to_peak"),
    )
    lines = [f"{best.name}: {law}" for law in law_lines(variant, claims)]
    if math.isfinite(limit := variant.run.effort_limit) and best.effort_peak >= limit:
        lines.append("the drive is at its limit")
    if best.runs > 1 and spread:
        lines.append(
            f"{best.runs} runs with different noise: standard deviation {length_text(float(spread), best.kind)}"
        )
    return lines


def _swing(result: SimulationResult, variant: VariantResult) -> float | None:
    """Return the swing of the error at its worst reversal, after the settling time."""
    run = variant_of(result, variant.name).run
    judged = slice(round(run.settle / run.sample_time), None)
    reference = variant.reference[judged]
    return swing_at_worst_reversal(reference, variant.error[judged]) if reference.size else None
