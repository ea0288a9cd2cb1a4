"""The report of an identification: verdict, parameters, table for the drive, figures and assumptions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from bristle.core import Axis, Kind, unit_of, with_unit
from bristle.prediction import fit_at_samples, largest_deviation, reversal_distance, steady_curve
from bristle.report.brief import advice_to_record
from bristle.report.cards import COMPARE, Step, cards_of, gain_card, no_gain
from bristle.report.compensation import about_loop, gain_of
from bristle.report.explained import tables_of
from bristle.report.judgement import (
    WRITTEN_BY,
    comparison_with,
    feedforward_of,
    is_one_sided,
    misfit,
    next_measurements,
    ruling_of,
)
from bristle.report.log_tables import (
    break_away_table,
    log_facts,
    passage_table,
    scatter_facts,
    treatment_facts,
)
from bristle.report.loops import focus_of, variant_table
from bristle.report.messages import (
    advice_of,
    assumptions_of,
    message,
    notes_of,
    terms_in,
    warnings_of,
    why_effective,
)
from bristle.report.model_tables import (
    as_csv,
    certificate_table,
    changed_settings,
    comparison_table,
    drive_rows,
    parameter_table,
    values_to_enter,
)
from bristle.report.page import Block, Figures, Front, Section, about, report_page, worded
from bristle.report.sweep import sweep_table
from bristle.report.table import Table, capital, fixed, percent_text
from bristle.report.two_masses import (
    SIMULATE_BOTH,
    elastic_cards,
    models_of,
    title_of,
    two_masses_table,
)

if TYPE_CHECKING:
    from bristle.identification import Explanation, Fit, Identification
    from bristle.prediction import Following
    from bristle.report.compensation import Gain
    from bristle.report.figures.report_figure import Facts
    from bristle.report.living import Living
    from bristle.simulation import Prediction, SimulationResult
    from bristle.simulation.certificates import Certificate

ENTER = f"enter the values on the machine, record again, and measure the gain with {COMPARE}"
PAIRS_SHOWN = 20
BY_POSITION = """bristle fitted the model to the position. The figures below show the effort along the measured motion, from which the
search started. This effort is noisy, because the second derivative of the position amplifies noise."""
FIT_FOR_USE = """A feedforward along the desired motion needs only a well-posed model, because it replays a known motion. The last
column lists the uses that need the other certificates."""
DRIVE_TABLE = """Friction at constant speed, with offset and without inertia. Zero speed has two rows, one per direction.
Friction that falls with speed is left out. Straight lines between the rows {}."""


def identification_report(
    identification: Identification,
    *,
    prediction: Prediction | None = None,
    simulation: SimulationResult | None = None,
    table: Sequence[tuple[float, float]] | None = None,
    axis_name: str,
    certificates: Mapping[str, Certificate] | None = None,
    following: Following | None = None,
    axis: Axis | None = None,
    living: Living | None = None,
    **options: Any,
) -> str:
    """Return the report of an identification as an HTML page; options as of `report_page`."""
    fit, kind, log = identification.best, identification.best.plant.kind, identification.log
    gain = None if simulation is None else gain_of(simulation)
    contradicted = following is not None and following.contradiction is not None
    if simulation is not None and contradicted:
        # The report leaves out the gain of a loop that the log contradicts.
        recorded = simulation.experiment.variants[:1]
        results = {variant.name: simulation.variants[variant.name] for variant in recorded}
        simulation = replace(
            simulation,
            experiment=replace(simulation.experiment, variants=recorded),
            variants=results,
        )
    log_name = log.source.name.strip("<>") + (
        f" and {len(identification.further_logs)} more" if identification.further_logs else ""
    )
    ruling = ruling_of(identification, following)
    usable = ruling.level != "measure_again"
    shows_gain = usable and gain is not None and len(gain.steps) > 1 and not contradicted
    distance = (
        0.0
        if fit.plant.values.get("k")
        else reversal_distance(fit.friction, float(np.max(np.abs(fit.traces.velocity))))
    )
    masses, elastic = identification.two_masses, identification.response is not None
    sides = masses.sides if masses is not None and masses.load is not None else {}
    facts: Facts = {
        "identification": identification,
        "fit": fit,
        "kind": kind,
        "log": log,
        "log_name": log_name,
        "curve": steady_curve(fit),
        "curve_band": [half for _, half in steady_curve(fit, band=True)],
        "passages": identification.passages,
        "simulation": simulation,
        "following": following,
        "prediction": prediction,
        "focus": None if simulation is None else focus_of(simulation),
        "gain_pair": tuple(step.name for step in gain.steps[-2:])
        if gain is not None and shows_gain
        else None,
        "at_samples": fit_at_samples(fit, log, axis, identification.treatment)
        if distance
        else None,
        "distance": distance,
        "both_sides": identification if sides else None,
        "elastic": identification if elastic and not sides else None,
        "explanation": explained_in(identification),
        "curves": [steady_curve(side.best) for side in sides.values()],
    }
    loop = _loop(simulation, gain, following, kind, contradicted=contradicted)
    sections = _sections(
        identification, loop, prediction, table, axis, certificates, following, usable=usable
    )
    title = (
        "Friction is not identified"
        if is_one_sided(fit)
        else f"Model error {percent_text(fit.error_percent)}"
    )
    again = advice_to_record(fit)
    step = (
        Step(again)
        if again
        else Step.of(ENTER if ruling.level == "usable" else next_steps(fit, usable=usable)[0])
    )
    front = Front(
        f"{axis_name}: identified friction",
        about(f"log {log_name}, {fixed(log.duration, 's')}", f"model {models_of(identification)}"),
        ruling if sides else ruling._replace(reasons=_merged(ruling.reasons)),
        title=gain.headline if gain is not None and shows_gain else title,
        basis=f"(simulated on {log_name})" if shows_gain else f"({log_name})",
        cards=[
            *cards_of(fit, axis, usable=usable),
            *([] if shows_gain else [no_gain(simulation, following, axis, usable=usable)]),
        ],
        next=step.in_full(options["command"]),
        csv=as_csv(table, kind) + "\n" if table and usable else "",
        feedforward=feedforward_of(identification),
    )
    if sides or elastic:
        front = _of_two_masses(
            front,
            identification,
            axis,
            gain if shows_gain else None,
            usable=usable,
            again=bool(again),
        )
    # The movable parameters are those of one mass.
    return report_page(
        "identification", facts, front, sections, living=None if sides else living, **options
    )


def _loop(
    simulation: SimulationResult | None,
    gain: Gain | None,
    following: Following | None,
    kind: Kind,
    *,
    contradicted: bool,
) -> Section:
    """Return the section on the following error: of the log alone, or of the simulated loop beside it."""
    if simulation is None:
        return Section(
            "following", "Following error in the log", about_loop(None, following, kind), "Loop"
        )
    heading = (
        "as recorded, measured and simulated"
        if contradicted
        else "without and with compensation, simulated"
    )
    variants = variant_table(simulation, following.measured if following else None)
    return Section(
        "following",
        f"Following error {heading}",
        [variants, *about_loop(gain, following, kind)],
        "Loop",
    )


def explained_in(identification: Identification) -> Explanation | None:
    """Return the explanation of a log that shows terms beside friction; None without terms."""
    explanation = identification.explanation
    if explanation is None or not explanation.terms:
        return None
    return explanation


def _sections(
    identification: Identification,
    loop: Section,
    prediction: Prediction | None,
    table: Sequence[tuple[float, float]] | None,
    axis: Axis | None,
    certificates: Mapping[str, Certificate] | None,
    following: Following | None,
    *,
    usable: bool,
) -> list[Section]:
    """Return the sections below the first screen."""
    fit = identification.best
    notes = (
        []
        if prediction is None
        else [f"{prediction.mode} prediction: {note}" for note in notes_of(prediction)]
    )
    thresholds = "`summary.json` lists all thresholds of these checks under `settings`."
    assumptions = [
        Block("items", [*assumptions_of(fit), *notes]),
        changed_settings(identification.settings),
        thresholds,
    ]
    by_position = [Figures("position"), BY_POSITION] if fit.position_rmse is not None else []
    quality = f"{'. '.join(map(capital, misfit(fit)))}. {terms_in(fit)}"
    explanation = explained_in(identification)
    forces = list[object]()
    if explanation is not None:
        forces += [explanation.verdict, *tables_of(explanation), *explanation.notes]
    certified = [FIT_FOR_USE, certificate_table(fit.name, certificates)] if certificates else []
    return [
        Section(
            "values",
            "Values to enter",
            [values_to_enter(fit, axis) if usable else None],
            "Drive table",
        ),
        Section(
            "drive",
            "Table for the drive",
            _for_the_drive(fit, table, axis) if table and usable else [],
            "Drive table",
        ),
        Section(
            "parameters",
            "Parameters",
            _parameters(identification, axis),
            "Drive table" if usable else "",
        ),
        Section("doubts", "Limits of this log", _doubts(fit, following), "Limits"),
        loop,
        Section(
            "fit",
            "Fit of the model",
            [*by_position, quality, Figures("fit"), _correlations(fit)],
            "Fit",
        ),
        Section(
            "models",
            "Models compared",
            [comparison_table(identification)] if identification.fits[1:] else [],
            "Models",
        ),
        Section("explanation", "Forces in the log", forces, "Log"),
        Section("certificates", "Certificates", certified, "Models"),
        Section("assumptions", "Assumptions", assumptions, "Limits"),
        Section("log", "The log", _read(identification), "Log"),
    ]


def _doubts(fit: Fit, following: Following | None) -> list[object]:
    """Return what limits the result, and what to measure next."""
    warned = [*warnings_of(fit)]
    if following is not None and following.contradiction:
        warned.append(message(following.contradiction))
    doubts: list[object] = [
        why_only_similar(fit),
        Block("items", warned, ("warnings",)) if warned else "This log determines every parameter.",
    ]
    measurements = next_measurements(fit)
    if measurements:
        motions = [
            Markup("<strong>{}</strong>: {}").format(worded(names), worded(motion))
            for names, motion in measurements
        ]
        doubts += ["Measure next:", Block("items", motions)]
    return doubts


def _of_two_masses(
    front: Front,
    identification: Identification,
    axis: Axis | None,
    gain: Gain | None,
    *,
    usable: bool,
    again: bool,
) -> Front:
    """Return the first screen of one mass as that of two masses."""
    masses = identification.two_masses
    if usable:
        front = front._replace(
            cards=[
                *elastic_cards(identification, axis),
                front.cards[-1] if gain is None else gain_card(gain),
            ]
        )
    step = (
        SIMULATE_BOTH
        if usable and not again and masses is not None and masses.is_elastic
        else front.next
    )
    return front._replace(
        title=title_of(identification), basis=front.basis.replace("simulated on ", ""), next=step
    )


def _read(identification: Identification) -> list[object]:
    """Return the contents of the log, and its treatment."""
    fit, log, kind = identification.best, identification.log, identification.best.plant.kind
    treated = treatment_facts(identification.treatment, kind) + scatter_facts(fit)
    return [
        passage_table([segment.as_data() for segment in identification.passages], kind),
        break_away_table(identification),
        Figures("log"),
        Block(
            "facts",
            log_facts(log, identification.further_logs) + treated,
            ("The log and its treatment",),
        ),
        Block("items", identification.notes),
    ]


def _merged(reasons: Sequence[str]) -> tuple[str, ...]:
    """Return reasons without those about the same parameters as an earlier reason."""
    names = [reason.partition(": ")[2] for reason in reasons]
    return tuple(
        reason
        for place, reason in enumerate(reasons)
        if not names[place] or names[place] not in names[:place]
    )


def why_only_similar(fit: Fit) -> str:
    """Return why the values hold only for similar motions; empty if they hold in general."""
    return (
        f"These are effective values, valid only for similar motions, because {why_effective(fit)}."
        if fit.effective
        else ""
    )


def _parameters(identification: Identification, axis: Axis | None) -> list[object]:
    """Return the parameters of two masses, if the log shows them, those of the best model, and those of sweeps."""
    return [
        two_masses_table(identification),
        Block("table", parameter_table(identification.best, axis), ("long",)),
        sweep_table(identification),
    ]


def _correlations(fit: Fit) -> Table:
    """Return the pairs of parameters with the strongest correlation, strongest first."""
    pairs = [
        (float(fit.correlation[i][j]), i, j)
        for i, j in combinations(range(len(fit.correlation_names)), 2)
    ]
    # A correlation that rounds to zero or is undefined is left out.
    strongest = sorted(
        (pair for pair in pairs if abs(pair[0]) >= 0.005), key=lambda pair: -abs(pair[0])
    )[:PAIRS_SHOWN]
    rows = [
        (fit.correlation_names[i], fit.correlation_names[j], f"{value:+.2f}".replace("-", "−"))
        for value, i, j in strongest
    ]
    return Table(
        "Correlation of the estimates, strongest first. Near ± 1 the two parameters are confounded",
        ("Parameter", "With", "Correlation"),
        rows,
    )


def _for_the_drive(
    fit: Fit, table: Sequence[tuple[float, float]], axis: Axis | None
) -> list[object]:
    """Return the table for the drive, with the largest deviation of its straight lines."""
    kind, deviation, lines = fit.plant.kind, largest_deviation(fit, table), "follow the model"
    # Beyond rounding.
    if deviation > 1e-6 * max(abs(effort) for _, effort in table):
        lines = f"deviate from the model by {with_unit(deviation, unit_of('force', kind))} at most"
    lead = Markup('<p class="lead">{}</p>').format(DRIVE_TABLE.format(lines))
    return [
        lead,
        Block(
            "table_beside",
            drive_rows(table, kind, axis),
            ("The same table in SI units, to be copied:", as_csv(table, kind)),
        ),
    ]


def next_steps(fit: Fit, *, usable: bool) -> list[str]:
    """Return the next steps: how to record again, models with a missing force, motions for open parameters."""
    lines = advice_of(doubt.code for doubt in fit.diagnostics if doubt.severity == "error")
    models = [
        str(doubt.numbers["model"]) for doubt in fit.diagnostics if doubt.numbers.get("model")
    ]
    lines += (
        [f"try a model with the missing force: `{comparison_with(fit, models)}`"] if models else []
    )
    by_motion: dict[str, list[str]] = {}
    for names, motion in next_measurements(fit):
        sentence, _, command = motion.partition(WRITTEN_BY)
        by_motion.setdefault(
            f"generate a motion with {command}" if command else sentence, []
        ).append(names)
    lines += [f"for {', '.join(names)}: {motion}" for motion, names in by_motion.items()]
    return lines or [
        ENTER if usable else "record the axis again, in both directions and at several speeds"
    ]
