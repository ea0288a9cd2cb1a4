"""Tables, sentences and numbers of loops: errors and efforts of variants, their parts, gains and warnings."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core import (
    GREEK,
    Diagnostic,
    Model,
    Status,
    Variant,
    number,
    scale_of,
    typeset,
    unit_of,
    with_unit,
)
from bristle.files import Said, as_toml, key_of
from bristle.prediction import Claim
from bristle.report.compensation import helped_text, names_text, pair_in
from bristle.report.messages import as_data, message, notes_of
from bristle.report.sentences import SENTENCES
from bristle.report.table import MICROMETRE, Quantity, Table, fixed

if TYPE_CHECKING:
    from bristle.simulation import (
        Assessment,
        Prediction,
        SimulationResult,
        Statistics,
        VariantResult,
    )

# Unit of a gain at the motor, by its unit on a carriage.
MOTOR = {"N*s/m": "N*m*s/rad", "N/m": "N*m/rad", "N/(m*s)": "N*m/(rad*s)"}


def variant_table(result: SimulationResult, measured: Statistics | None = None) -> Table:
    """Return the errors and efforts of the variants of a loop; for open loops their motions.

    The first row has the measured error if it is given.
    """
    is_open = bool(result.variants) and all(variant.is_open for variant in result.variants.values())
    completed, kind = _completed(result), result.experiment.kind
    effort = Quantity.of(unit_of("force", kind), (variant.effort_peak for variant in completed))
    if is_open:
        words = {
            "Position, peak to peak": "motion.peak_to_peak",
            "lowest": "motion.min",
            "highest": "motion.max",
        }
        length = Quantity.of(
            unit_of("length", kind), (variant.motion.peak_to_peak for variant in completed)
        )
    else:
        words = {
            "Following error, peak to peak": "following_error.peak_to_peak",
            "rms": "following_error.rms",
            "mean": "following_error.mean",
            "True error, peak to peak": "true_error.peak_to_peak",
        }
        length = _error_column(result)
    efforts = {
        f"{'Torque' if kind == 'rotational' else 'Force'}, rms": "effort_rms",
        "peak": "effort_peak",
    }
    heads = ("Variant", *map(length.head, words), *map(effort.head, efforts), "Remark")
    rows = []
    if measured is not None:
        rows.append(
            (
                "measured",
                *map(length.cell, (measured.peak_to_peak, measured.rms, measured.mean)),
                "–",
                "–",
                "–",
                "",
            )
        )
    for variant in result.variants.values():
        cells = [length.cell(attrgetter(name)(variant)) for name in words.values()]
        cells += [effort.cell(getattr(variant, name)) for name in efforts.values()]
        cells = ["–"] * len(cells) if variant.status is Status.NOT_FINITE else cells
        rows.append(
            (variant.name, *cells, "" if variant.status is Status.OK else variant.status.sentence)
        )
    return Table(
        "The variants" if is_open else "The variants of the loop", heads, rows
    ).without_empty_columns()


def direction_table(result: SimulationResult) -> Table:
    """Return the following error of each variant while the reference moves forward and backward."""
    length = _error_column(result)
    words = {"mean": "Mean", "rms": "rms", "peak_to_peak": "Peak to peak"}
    rows = [
        {"Variant": variant.name, "Direction": direction}
        | {length.head(word): length.cell(getattr(error, key)) for key, word in words.items()}
        for variant in _completed(result)
        for direction, error in variant.by_direction.items()
    ]
    return Table.of("Following error by direction of the reference", rows)


def _completed(result: SimulationResult) -> list[VariantResult]:
    return [
        variant for variant in result.variants.values() if variant.status is not Status.NOT_FINITE
    ]


def _error_column(result: SimulationResult) -> Quantity:
    """Return the column for following errors, scaled to the smallest error."""
    smallest = min(
        (variant.following_error.peak_to_peak for variant in _completed(result)), default=0.0
    )
    scale = scale_of(unit_of("length", result.experiment.kind), max(smallest, MICROMETRE))
    return Quantity(scale, 0.1 * smallest * scale.factor)


def component_table(title: str, models: Iterable[tuple[str, Model | None]]) -> Table:
    """Return the parameters of the parts of a loop."""
    rows = []
    for part, model in models:
        if model is None:
            rows.append((part, "none", ""))
        else:
            values = []
            for name, value in model.values.items():
                unit, text = model.component.variables[name].unit(model.kind), str(value)
                if isinstance(value, (float, int)):
                    text = with_unit(float(value), unit, 4)
                elif (array := np.asarray(value)).dtype.kind in "fi":
                    text = f"{array.size} values, {number(array.min())} to {number(array.max())} {typeset(unit)}".rstrip()
                values.append(f"{name} = {text}")
            rows.append((part, model.name, ", ".join(values)))
    return Table(title, ("Part", "Model", "Parameters"), rows)


def parts_table(variant: Variant) -> Table:
    """Return the parameters of the parts of a variant; an open loop has no controller."""
    models: list[tuple[str, Model | None]] = [
        ("Plant", variant.plant),
        ("Friction", variant.friction),
        ("Sensor", variant.sensor),
    ]
    if variant.effort is None:
        models.insert(2, ("Controller", variant.controller))
        models += [
            ("Reference", variant.reference),
            ("Friction feedforward", variant.feedforward.friction),
        ]
    return component_table(f"The parts of {variant.name}", models)


def run_table(variants: Sequence[Variant]) -> Table:
    """Return the run settings of each variant."""
    rows = []
    for variant in variants:
        run, kind = variant.run, variant.plant.kind
        rows.append(
            {
                "Variant": variant.name,
                "Duration": with_unit(run.duration, "s", 4),
                "Left out at the start": with_unit(run.settle, "s", 4),
                "Sample time": with_unit(run.sample_time, "s", 4),
                "Steps in a sample": f"adaptive, to within {with_unit(run.tolerance, unit_of('length', kind))} of position"
                if run.tolerance
                else str(run.substeps),
                "Delay [samples]": str(run.delay),
                "Effort limit": with_unit(run.effort_limit, unit_of("force", kind), 4),
                "Mass feedforward": with_unit(variant.feedforward.mass, unit_of("mass", kind), 4),
                "Factor on friction feedforward": f"{variant.feedforward.gain:g}",
            }
        )
    return Table.of("Run settings", rows)


def law_lines(variant: Variant, claims: Sequence[Claim] = ()) -> list[str]:
    """Return the gains of a loop, also at its motor if known, and its feedforward with the moves that it helps."""
    fed, law, gains = variant.feedforward, variant.controller, []
    for name, value in law.values.items():
        if (
            isinstance(value, (int, float))
            and not isinstance(value, bool)
            and 0.0 < abs(value) < math.inf
        ):
            unit, key = law.component.variables[name].unit(law.kind), key_of(name)
            text = f"{GREEK.get(key, key)} {with_unit(float(value), unit, 4)}".replace(
                " ", "\u00a0"
            )
            motor = _at_the_motor(float(value), unit, variant)
            gains.append(f"{text} ({motor})" if motor else text)
    lines = [f"law {law.name}: {', '.join(gains)}"]
    if fed.friction is not None:
        share = "" if fed.gain == 1.0 else f" × {fed.gain:g}"
        lines.append(
            f"friction feedforward: {fed.friction.name}{share}, along the {fed.along} motion{helped_text(claims, law.kind)}"
        )
    if fed.mass > 0.0:
        lines.append(
            f"inertia feedforward: acceleration × {fixed(fed.mass, unit_of('mass', variant.plant.kind))}"
        )
    return lines


def controller_text(variant: Variant) -> str:
    """Return control law and inertia feedforward of a loop as tables of an experiment file."""
    controller, mass = variant.controller, variant.feedforward.mass
    table: dict[str, Any] = {"model": controller.name}
    for name, value in controller.values.items():
        unit = controller.component.variables[name].unit(controller.kind)
        if isinstance(value, (str, int)) or unit == "1":
            table[key_of(name)] = value
        elif math.isfinite(value):
            table[key_of(name)] = Said(f"{value:.6g} {unit}", _at_the_motor(value, unit, variant))
    if mass > 0.0:
        table["feedforward"] = {"mass": f"{mass:.6g} {unit_of('mass', controller.kind)}"}
    return as_toml({"controller": table}).rstrip()


def _at_the_motor(value: float, unit: str, variant: Variant) -> str:
    """Return a gain at the motor of a screw; empty without a screw."""
    arm = None if variant.axis is None else variant.axis.arm
    return f"{value * arm * arm:.4g} {MOTOR[unit]} at the motor" if arm and unit in MOTOR else ""


def about_loops(
    judged: Mapping[str, Assessment], further: Mapping[str, Diagnostic]
) -> list[Diagnostic]:
    """Return the diagnostics of loops that are unstable or have small margins, with their names in ``variants``."""
    by_message: dict[str, tuple[Diagnostic, list[str]]] = {}
    for name, assessment in judged.items():
        for doubt in assessment.doubts if assessment.is_stable else (assessment.finding,):
            # Equal messages are merged.
            by_message.setdefault(message(doubt), (doubt, []))[1].append(name)
    complete = [
        *by_message.values(),
        *((diagnostic, [name]) for name, diagnostic in further.items()),
    ]
    return [
        replace(diagnostic, numbers={**diagnostic.numbers, "variants": tuple(names)})
        for diagnostic, names in complete
    ]


def loop_warnings(diagnostics: Sequence[Diagnostic]) -> list[str]:
    """Return diagnostics of loops as sentences, each after the names of its variants."""
    heads = (
        f"{', '.join(map(str, _names(about)))}: {'warning: ' if about.severity == 'warning' else ''}"
        for about in diagnostics
    )
    return [
        f"{head}{message(diagnostic)}" for head, diagnostic in zip(heads, diagnostics, strict=True)
    ]


def loop_doubts(diagnostics: Sequence[Diagnostic]) -> list[str]:
    """Return diagnostics of loops in short: errors as sentences, warnings by their meaning."""
    doubts = [diagnostic for diagnostic in diagnostics if diagnostic.severity == "warning"]
    grave = loop_warnings(
        [diagnostic for diagnostic in diagnostics if diagnostic.severity == "error"]
    )
    return grave + [
        f"{SENTENCES[doubt.code].means}: {names_text(_names(doubt))}" for doubt in doubts
    ]


def _names(diagnostic: Diagnostic) -> Sequence[object]:
    names = diagnostic.numbers["variants"]
    return names if isinstance(names, tuple) else (names,)


def variants_as_data(result: SimulationResult) -> dict[str, Any]:
    """Return the variants of an experiment in numbers, by name."""
    return {
        name: variant.as_dict() | {"completed": variant.status is not Status.NOT_FINITE}
        for name, variant in result.variants.items()
    }


def focus_of(result: SimulationResult) -> tuple[str, ...]:
    """Return the variants to compare first, which differ only in friction feedforward."""
    return tuple(variant.name for variant in pair_in(result) or ())


def prediction_as_data(prediction: Prediction) -> dict[str, Any]:
    """Return only the numbers of a prediction."""
    return {
        "mode": prediction.mode,
        "metrics": dict(prediction.metrics),
        "inside_band_percent": prediction.inside_percent,
        "position_inside_band_percent": prediction.position_inside_percent,
        "status": prediction.status.sentence,
        "completed": prediction.status is not Status.NOT_FINITE,
        "notes": notes_of(prediction),
        "diagnostics": as_data(prediction.diagnostics),
    }
