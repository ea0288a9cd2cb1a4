"""The first page of a loop that is designed: whether to keep it, which gains to type in, and what they take."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from bristle.core.typography import number
from bristle.core.variable import unit_of
from bristle.loop import doubts_of, verdict_of
from bristle.report.design_tables import least_phase
from bristle.report.front import Front, Ruling, about, answered, fixed, length_text
from bristle.report.laws import law_lines
from bristle.report.messages import message

if TYPE_CHECKING:
    from bristle.loop import Design, Proposal
    from bristle.report.page import Picture

__all__ = ["LESS", "MORE", "best_of", "counts_much", "design_front", "design_ruling", "peak_of"]

MUCH = 0.5  # of the friction: effort for a single count that is worth a word
LESS, MORE = 0.95, 1.05  # of an error: between them it is about the same
WORTH = 0.8  # of an error: above it other gains are not worth their margins


def peak_of(proposal: Proposal) -> float:
    """Return the simulated following error of a loop, peak to peak [m or rad]; infinite where there is none."""
    return proposal.following_error.peak_to_peak if proposal.following_error is not None else math.inf


def best_of(design: Design) -> Proposal | None:
    """Return which of the loops proposed errs least; None where none was simulated."""
    simulated = [proposal for proposal in design.proposals[1:] if proposal.following_error is not None]
    return min(simulated, key=peak_of, default=None)


def counts_much(design: Design) -> bool:
    """Return whether a single count of the encoder calls up an effort like that of friction."""
    return design.friction > 0.0 and design.proposals[0].count_effort > MUCH * design.friction


def design_ruling(design: Design) -> Ruling:
    """Return whether to keep a loop, and why."""
    chosen, doubts = _chosen(design), tuple(message(doubt) for doubt in doubts_of(design.assessment))
    if not design.is_stable:
        return Ruling("no", "Do not run it", (message(verdict_of(design.assessment)), *doubts))
    if chosen is not design.proposals[0]:
        return Ruling("with_care", "Change the gains", (_instead(chosen, design), *doubts))
    if doubts:
        return Ruling("with_care", "Keep it, with care", doubts)
    return Ruling("usable", "Keep it", (_held(design.proposals[0]), "no loop proposed errs by a fifth less"))


def _chosen(design: Design) -> Proposal:
    """Return the loop to run: the one as it is, unless another one errs less or that one is not stable."""
    present, best = design.proposals[0], best_of(design)
    if best is None:
        return present
    return best if not design.is_stable or peak_of(best) < WORTH * peak_of(present) else present


def _instead(chosen: Proposal, design: Design) -> str:
    kind, present = design.experiment.kind, design.proposals[0]
    beside = "" if present.following_error is None else f" instead of {length_text(peak_of(present), kind)}"
    return f"the loop {chosen.name} errs by {length_text(peak_of(chosen), kind)}{beside}, with margins kept"


def _held(proposal: Proposal) -> str:
    phase = least_phase(proposal.assessment)
    return "it has no crossover, and so no phase margin" if phase is None else f"phase margin {number(phase, digits=3)}°"


def design_front(design: Design, figure: Picture) -> Front:
    """Return the first page of a loop that is designed."""
    ruling, name = design_ruling(design), design.experiment.name
    chosen = _chosen(design)
    title = f"{design.variant.name}, as it is" if chosen is design.proposals[0] else f"{chosen.name}, in its place"
    return Front(
        f"{name}: the loop",
        about(f"variant {design.variant.name}", f"law {design.variant.controller.name}"),
        *ruling[:2],
        ruling.reasons,
        answered(
            _quality(design), [f"loop {title}", *law_lines(chosen.variant)], _cost(chosen, design), _trust(design), _next(chosen, design)
        ),
        figure,
        "summary",
    )


def _quality(design: Design) -> list[str]:
    kind, present = design.experiment.kind, design.proposals[0]
    lines = [f"stable as it is, {_held(present)}" if design.is_stable else "not stable as it is"]
    if design.budget is not None and design.budget.entries:
        first = design.budget.entries[0]
        lines += [
            f"following error {length_text(design.budget.all_causes.peak_to_peak, kind)} peak to peak, simulated",
            f"mostly by {first.cause} ({first.description}): without it {length_text(first.without.peak_to_peak, kind)}",
        ]
    return lines


def _cost(chosen: Proposal, design: Design) -> list[str]:
    present, unit = design.proposals[0], unit_of("force", design.experiment.kind)
    is_change, lines = chosen is not present, []
    if chosen.following_error is not None and present.following_error is not None and is_change:
        new, old = (length_text(peak_of(loop), design.experiment.kind) for loop in (chosen, present))
        lines.append(f"following error {new} instead of {old}")
    for word, new, old in (
        ("effort, root mean square", chosen.effort_rms, present.effort_rms),
        ("effort that one count of the encoder calls up", chosen.count_effort, present.count_effort),
    ):
        if new is not None:
            lines.append(f"{word}: {fixed(new, unit)}" + (f" instead of {fixed(old, unit)}" if is_change and old else ""))
    margins = [least_phase(loop.assessment) for loop in (chosen, present)]
    if is_change and margins[0] is not None and margins[1] is not None:
        lines.append(f"phase margin {number(margins[0], digits=3)}° instead of {number(margins[1], digits=3)}°")
    return lines


def _trust(design: Design) -> list[str]:
    lines = ["margins of the loop as it is sampled, with its delays: no resonance but those of the plant in the file"]
    if design.budget is not None:
        runs = design.budget.runs
        lines.append(f"errors are simulated, {'one run' if runs == 1 else f'{runs} runs'} each, with the friction of the file")
    return lines


def _next(chosen: Proposal, design: Design) -> list[str]:
    lines = []
    if chosen is not design.proposals[0]:
        lines.append("write these gains (below, to be copied) into the experiment file, then `bristle run` it")
    if counts_much(design):
        lines.append("a finer encoder or a lower cut-off of the velocity: much of the effort is noise")
    return [*lines, "on the machine, record before and after, then `bristle compare`"]
