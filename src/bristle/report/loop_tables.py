"""Tables of a simulated loop: errors and efforts of its variants, what it is made of, how it was run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from bristle.core.status import Status
from bristle.core.typography import number, typeset, with_unit
from bristle.core.variable import unit_of
from bristle.report.front import MICROMETRE
from bristle.report.table import Quantity, Table

if TYPE_CHECKING:
    from bristle.core.contracts import Model
    from bristle.core.experiment import Variant
    from bristle.simulation.result import SimulationResult, Statistics, VariantResult

__all__ = ["component_table", "direction_table", "run_table", "variant_table"]


def variant_table(result: SimulationResult, measured: Statistics | None = None) -> Table:
    """Return the errors and efforts of the variants of a loop, side by side; of open loops where they went.

    Above them stands what was measured, where that is given.
    """
    if result.variants and all(variant.is_open for variant in result.variants.values()):
        return _open_table(result)
    completed, length = _following(result)
    effort = Quantity.of(unit_of("force", result.experiment.kind), (variant.effort_peak for variant in completed))
    word = "Torque" if result.experiment.kind == "rotational" else "Force"
    heads = (
        "Variant",
        length.head("Following error, peak to peak"),
        length.head("rms"),
        length.head("mean"),
        length.head("True error, peak to peak"),
        effort.head(f"{word}, rms"),
        effort.head("peak"),
        "Remark",
    )
    rows = []
    if measured is not None:
        errors = (measured.peak_to_peak, measured.rms, measured.mean)
        rows.append(("measured", *(length.cell(value) for value in errors), "–", "–", "–", ""))
    for variant in result.variants.values():
        error = variant.following_error
        cells = [length.cell(v) for v in (error.peak_to_peak, error.rms, error.mean, variant.true_error.peak_to_peak)]
        cells += [effort.cell(variant.effort_rms), effort.cell(variant.effort_peak)]
        if variant.status is Status.NOT_FINITE:
            cells = ["–"] * len(cells)
        rows.append((variant.name, *cells, "" if variant.status is Status.OK else variant.status.sentence))
    return Table("The variants of the loop", heads, rows).without_empty_columns()


def _open_table(result: SimulationResult) -> Table:
    """Return where the variants of an experiment without a loop went, and under what efforts."""
    completed = [variant for variant in result.variants.values() if variant.status is not Status.NOT_FINITE]
    kind = result.experiment.kind
    length = Quantity.of(unit_of("length", kind), (variant.motion.peak_to_peak for variant in completed))
    effort = Quantity.of(unit_of("force", kind), (variant.effort_peak for variant in completed))
    word = "Torque" if kind == "rotational" else "Force"
    heads = (
        "Variant",
        length.head("Position, peak to peak"),
        length.head("lowest"),
        length.head("highest"),
        effort.head(f"{word}, rms"),
        effort.head("peak"),
        "Remark",
    )
    rows = []
    for variant in result.variants.values():
        motion = variant.motion
        cells = [length.cell(value) for value in (motion.peak_to_peak, motion.min, motion.max)]
        cells += [effort.cell(variant.effort_rms), effort.cell(variant.effort_peak)]
        if variant.status is Status.NOT_FINITE:
            cells = ["–"] * len(cells)
        rows.append((variant.name, *cells, "" if variant.status is Status.OK else variant.status.sentence))
    return Table("The variants", heads, rows).without_empty_columns()


def direction_table(result: SimulationResult) -> Table:
    """Return the following error of each variant while the reference moves forward and backward."""
    completed, length = _following(result)
    heads = ("Variant", "Direction", length.head("Mean"), length.head("rms"), length.head("Peak to peak"))
    rows = []
    for variant in completed:
        for direction, error in variant.by_direction.items():
            numbers = (error.mean, error.rms, error.peak_to_peak)
            rows.append((variant.name, direction, *(length.cell(v) for v in numbers)))
    return Table("Following error by direction of the reference", heads, rows)


def _following(result: SimulationResult) -> tuple[list[VariantResult], Quantity]:
    """Return the variants that completed, and the column for their following errors, by the smallest of them."""
    completed = [variant for variant in result.variants.values() if variant.status is not Status.NOT_FINITE]
    smallest = min((variant.following_error.peak_to_peak for variant in completed), default=0.0)
    return completed, Quantity.at_least(MICROMETRE, unit_of("length", result.experiment.kind), smallest)


def component_table(title: str, models: Iterable[tuple[str, Model | None]]) -> Table:
    """Return the parameters of the parts of a loop."""
    rows = []
    for part, model in models:
        if model is None:
            rows.append((part, "none", ""))
            continue
        values = [f"{name} = {_value(value, model.component.variables[name].unit(model.kind))}" for name, value in model.values.items()]
        rows.append((part, model.name, ", ".join(values)))
    return Table(title, ("Part", "Model", "Parameters"), rows)


def _value(value: object, unit: str) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, (float, int)):
        return with_unit(float(value), unit, 4)
    array = np.asarray(value)
    if array.dtype.kind in "fi":
        return f"{array.size} values, {number(array.min())} to {number(array.max())} {typeset(unit)}".rstrip()
    return str(value)


def run_table(variants: Sequence[Variant]) -> Table:
    """Return how each variant was run."""
    heads = (
        "Variant",
        "Duration",
        "Left out at the start",
        "Sample time",
        "Steps in a sample",
        "Delay [samples]",
        "Largest effort",
        "Mass fed forward",
        "Factor on the friction fed forward",
    )
    rows = [
        (
            variant.name,
            with_unit(variant.run.duration, "s", 4),
            with_unit(variant.run.settle, "s", 4),
            with_unit(variant.run.sample_time, "s", 4),
            _steps(variant),
            str(variant.run.delay),
            with_unit(variant.run.effort_limit, unit_of("force", variant.plant.kind), 4),
            with_unit(variant.feedforward.mass, unit_of("mass", variant.plant.kind), 4),
            f"{variant.feedforward.gain:g}",
        )
        for variant in variants
    ]
    return Table("How it was simulated", heads, rows)


def _steps(variant: Variant) -> str:
    if not variant.run.tolerance:
        return str(variant.run.substeps)
    return f"as {with_unit(variant.run.tolerance, unit_of('length', variant.plant.kind))} of position ask for"
