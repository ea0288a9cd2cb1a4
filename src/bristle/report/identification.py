"""The report of an identification: verdict, parameters, table for the drive, figures, and what was assumed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.logs.passages import passages
from bristle.prediction.drive_table import largest_deviation, steady_curve
from bristle.report.advice import next_measurements
from bristle.report.certificates import certificate_table
from bristle.report.compensation import gain_of
from bristle.report.first_page import answers, facts
from bristle.report.front import Front
from bristle.report.further import further_figures
from bristle.report.judgement import judged
from bristle.report.log_facts import log_facts, scatter_facts, treatment_facts
from bristle.report.loop_tables import variant_table
from bristle.report.messages import assumptions_of, message, notes_of, warnings_of
from bristle.report.model_tables import as_csv, comparison_table, drive_rows, parameter_table
from bristle.report.page import render
from bristle.report.passages import break_away_table, passage_table
from bristle.report.pictures import pictures_on
from bristle.report.settings import changed_settings, settings_table
from bristle.report.simulation import focus_of
from bristle.report.verdict import sentences
from bristle.simulation.compensation import AS_RECORDED

if TYPE_CHECKING:
    from bristle.certificates import Certificate
    from bristle.core.axis import Axis
    from bristle.figures.report_figure import Facts, ReportFigure
    from bristle.identification.result import Fit, Identification
    from bristle.prediction.following import Following
    from bristle.report.living import Living
    from bristle.report.page import Picture
    from bristle.simulation.result import Prediction, SimulationResult

__all__ = ["identification_report"]

ROUNDING = 1e-6  # of the largest effort


def identification_report(
    identification: Identification,
    *,
    prediction: Prediction | None = None,
    simulation: SimulationResult | None = None,
    table: Sequence[tuple[float, float]] | None = None,
    command: str,
    axis_name: str,
    provenance: Mapping[str, str],
    certificates: Mapping[str, Certificate] | None = None,
    banner: str | None = None,
    following: Following | None = None,
    axis: Axis | None = None,
    living: Living | None = None,
    figures: Sequence[ReportFigure] = (),
) -> str:
    """Return the report of an identification as one HTML page."""
    fit, kind = identification.best, identification.best.plant.kind
    curve = steady_curve(fit)
    segments = passages(identification.log)
    gain = None if simulation is None else gain_of(simulation)
    contradicted = following is not None and following.contradiction is not None
    if simulation is not None and contradicted:
        simulation = _as_recorded(simulation)
    basis: Facts = {
        "identification": identification,
        "fit": fit,
        "kind": kind,
        "log": identification.log,
        "table": table or (),
        "curve": curve,
        "passages": segments,
        "simulation": simulation,
        "following": following,
        "prediction": prediction,
        "focus": None if simulation is None else focus_of(simulation),
    }
    pictures = pictures_on("identification", basis)
    return render(
        "identification.html",
        provenance=provenance,
        command=command,
        banner=banner,
        axis_name=axis_name,
        front=_front(identification, simulation, following, axis_name, axis, next(iter(pictures["front"]), None)),
        verdict=sentences(identification, axis_name, gain, prediction, following),
        parameters=parameter_table(fit, axis),
        warnings=[*warnings_of(fit), *_contradictions(following)],
        next_measurements=next_measurements(fit),
        drive=None if not table else drive_rows(table, kind, axis),
        deviation=_deviation(fit, table) if table else None,
        drive_csv=None if not table else as_csv(table, kind),
        variants=None if simulation is None else variant_table(simulation, following.measured if following else None),
        contradicted=contradicted,
        comparison=comparison_table(identification),
        by_position=fit.position_rmse is not None,
        pictures=pictures,
        assumptions=_assumed(fit, prediction),
        settings=settings_table(identification.settings, kind),
        changed_settings=changed_settings(identification.settings),
        passages=passage_table([segment.as_data() for segment in segments], kind),
        break_aways=break_away_table(identification.break_aways, kind) if identification.break_aways else None,
        log=log_facts(identification.log, identification.further_logs)
        + treatment_facts(identification.treatment, kind)
        + scatter_facts(fit.resampling, kind),
        certificates=certificate_table(fit.name, certificates) if certificates else None,
        notes=identification.notes,
        living=living,
        further=further_figures(figures, basis),
    )


def _each_once(reasons: Sequence[str]) -> list[str]:
    """Return reasons without those whose parameters another one names already."""
    names = [reason.partition(": ")[2] for reason in reasons]
    return [reason for place, reason in enumerate(reasons) if not names[place] or names[place] not in names[:place]]


def _deviation(fit: Fit, table: Sequence[tuple[float, float]]) -> str:
    """Return how far straight lines between the entries are from the model: not at all where it is straight itself."""
    deviation, largest = largest_deviation(fit, table), max(abs(effort) for _, effort in table)
    if deviation <= ROUNDING * largest:
        return "follow the model"
    return f"deviate from the model by {with_unit(deviation, unit_of('force', fit.plant.kind))} at most"


def _front(
    identification: Identification,
    simulation: SimulationResult | None,
    following: Following | None,
    axis_name: str,
    axis: Axis | None,
    figure: Picture | None,
) -> Front:
    fit = identification.best
    judgement = judged(fit, identification.settings, following)
    return Front(
        f"{axis_name}: identified friction",
        facts(identification),
        judgement.level,
        judgement.words,
        _each_once(judgement.reasons),
        answers(identification, simulation, following, next_measurements(fit), axis, usable=judgement.level != "measure_again"),
        figure,
        "doubts",
        "Nothing in this log speaks against it.",
    )


def _as_recorded(simulation: SimulationResult) -> SimulationResult:
    """Return the loop as it was recorded alone: what it would gain is not told where the log contradicts it."""
    recorded = tuple(variant for variant in simulation.experiment.variants if variant.name == AS_RECORDED)
    results = {variant.name: simulation.variants[variant.name] for variant in recorded}
    return replace(simulation, experiment=replace(simulation.experiment, variants=recorded), variants=results)


def _contradictions(following: Following | None) -> list[str]:
    return [] if following is None or following.contradiction is None else [message(following.contradiction)]


def _assumed(fit: Fit, prediction: Prediction | None) -> list[str]:
    notes = [] if prediction is None else [f"{prediction.mode} prediction: {note}" for note in notes_of(prediction)]
    return [*assumptions_of(fit), *notes]
