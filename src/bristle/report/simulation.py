"""The report of a simulated experiment: its variants side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from bristle.core.status import Status
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.report.best import closing_sentences, standing
from bristle.report.compensation import pair_in
from bristle.report.fronts.simulation import is_open, simulation_front
from bristle.report.further import further_figures
from bristle.report.loop_tables import component_table, direction_table, run_table, variant_table
from bristle.report.page import render
from bristle.report.pictures import pictures_on

if TYPE_CHECKING:
    from bristle.core.contracts import Model
    from bristle.core.experiment import Variant
    from bristle.figures.report_figure import Facts, ReportFigure
    from bristle.simulation.result import SimulationResult

__all__ = ["focus_of", "simulation_report"]


def simulation_report(
    result: SimulationResult,
    *,
    command: str,
    provenance: Mapping[str, str],
    banner: str | None = None,
    warnings: Sequence[str] = (),
    doubts: Sequence[str] | None = None,
    figures: Sequence[ReportFigure] = (),
) -> str:
    """Return the report of a simulated experiment as one HTML page."""
    variants, open_ = result.experiment.variants, is_open(result)
    basis: Facts = {
        "simulation": result,
        "open_loop": result if open_ else None,
        "focus": None if open_ else focus_of(result),
        "at_reversal": None if open_ else _at_reversal(result),
    }
    pictures = pictures_on("simulation", basis)
    return render(
        "simulation.html",
        provenance=provenance,
        command=command,
        banner=banner,
        front=simulation_front(result, warnings if doubts is None else doubts, next(iter(pictures["front"]), None)),
        name=result.experiment.name,
        verdict=[*(f"{warning}." for warning in warnings), *_sentences(result)],
        is_open=open_,
        variants=variant_table(result),
        directions=None if open_ else direction_table(result),
        pictures=pictures,
        loops=[component_table(f"The parts of {variant.name}", _parts(variant)) for variant in variants],
        efforts=[f"{variant.name}: {variant.effort.description}" for variant in variants if variant.effort is not None],
        runs=run_table(variants),
        further=further_figures(figures, basis),
    )


def _at_reversal(result: SimulationResult) -> tuple[list[str], list[str]] | None:
    """Return the loop as it stands and the best one, and those of them to be shown close up."""
    rank = standing(result)
    if rank is None:
        return None
    # Close up stand the two that differ in the friction fed forward alone: the lag of a loop would flatten both.
    pair, best = pair_in(result), rank.best.name
    near = (pair[0].name, best) if pair is not None and pair[1].name == best else (rank.base.name, best)
    names, close = (list(dict.fromkeys(group)) for group in ((rank.base.name, *near), near))
    return names, close


def focus_of(result: SimulationResult) -> tuple[str, ...]:
    """Return the variants that are compared first: those that differ in the friction fed forward alone."""
    return tuple(variant.name for variant in pair_in(result) or ())


def _sentences(result: SimulationResult) -> list[str]:
    failed = [variant.name for variant in result.variants.values() if variant.status is Status.NOT_FINITE]
    lines = [f"{name}: {Status.NOT_FINITE.sentence}." for name in failed]
    unit = unit_of("length", result.experiment.kind)
    lines += [
        f"{variant.name}: moves by {with_unit(variant.motion.peak_to_peak, unit)} peak to peak."
        if variant.is_open
        else f"{variant.name}: following error {with_unit(variant.following_error.peak_to_peak, unit)} peak to peak, "
        f"{with_unit(variant.following_error.rms, unit)} root mean square."
        for variant in result.variants.values()
        if variant.name not in failed
    ]
    return lines + closing_sentences(result)


def _parts(variant: Variant) -> list[tuple[str, Model | None]]:
    if variant.effort is not None:
        return [("Plant", variant.plant), ("Friction", variant.friction), ("Sensor", variant.sensor)]
    return [
        ("Plant", variant.plant),
        ("Friction", variant.friction),
        ("Controller", variant.controller),
        ("Sensor", variant.sensor),
        ("Reference", variant.reference),
        ("Friction fed forward", variant.feedforward.friction),
    ]
