"""The reports of hysteresis operators: what was fitted to recorded curves, and what an operator says of others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from bristle.core import number, unit_of, with_unit
from bristle.report.messages import picked
from bristle.report.page import Block, Front, Ruling, Section, about, answered, report_page
from bristle.report.table import Quantity, Table, fixed, percent_text, short_text

if TYPE_CHECKING:
    from bristle.core import Model
    from bristle.hysteresis.identification import OperatorFit, OperatorIdentification, OperatorPrediction
    from bristle.logs import Curves


def operator_summary(identification: OperatorIdentification, *, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return the identification of an operator in numbers: the best one on top, all of them under ``models``."""
    best, kind = identification.best, identification.recorded.kind
    return {
        "model": best.name,
        "kind": kind,
        "parameters": _parameters(best.operator, best.offset),
        "verdict": operator_ruling(best.prediction.error_percent, best.held_out and best.held_out.mean_percent, fitted=True).as_data(),
        "metrics": best.metrics,
        "notes": best.notes,
        "congruency": picked(identification.congruency, "alike", "anywhere"),
        "models": [
            picked(fit, "name", "rank", "metrics", "notes") | {"parameters": _parameters(fit.operator, fit.offset)}
            for fit in identification.fits
        ],
        "log": _log(identification.recorded),
        "unfinished": identification.unfinished or None,
        "provenance": provenance,
    }


def operator_prediction_summary(
    prediction: OperatorPrediction, operator: Model, recorded: Curves, *, provenance: Mapping[str, str]
) -> dict[str, Any]:
    """Return in numbers what an operator says of recorded curves."""
    metrics = {"error_percent": prediction.error_percent, "rmse": prediction.rmse}
    return {
        "model": operator.name,
        "kind": operator.kind,
        "mode": "operator",
        "verdict": operator_ruling(prediction.error_percent, None, fitted=False).as_data(),
        "metrics": metrics | {"unit": unit_of("force", operator.kind), "full_scale": prediction.full_scale},
        "log": _log(recorded),
        "provenance": provenance,
    }


def operator_report(identification: OperatorIdentification, **options: Any) -> str:
    """Return the report of the identification of an operator as one HTML page; options as of `operator_prediction_report`."""
    best, fits = identification.best, identification.fits
    compared = comparison_of_operators(identification) if len(fits) > 1 else None
    title = f"{best.name} identified"
    return _page(best.prediction, best.operator, identification.recorded, fits, title, compared, identification.notes, **options)


def operator_prediction_report(prediction: OperatorPrediction, operator: Model, recorded: Curves, **options: Any) -> str:
    """Return the report of recorded curves, predicted by an operator, as one HTML page.

    Options are the `name` of the axis, and `command`, `provenance` and `banner` of every report.
    """
    return _page(prediction, operator, recorded, (), f"prediction by {operator.name}", None, (), **options)


def _page(
    prediction: OperatorPrediction,
    operator: Model,
    recorded: Curves,
    fits: Sequence[OperatorFit],
    title: str,
    compared: Table | None,
    notes: Sequence[str],
    *,
    name: str,
    **options: Any,
) -> str:
    read = [
        ("Curves", str(len(recorded.curves))),
        ("Samples", str(sum(curve.u.size for curve in recorded.curves))),
        ("Each begins", recorded.start),
        ("Full scale", with_unit(recorded.full_scale, unit_of("force", recorded.kind))),
        *(("Note", note) for note in recorded.notes),
    ]
    parameters = []
    for parameter, variable in operator.component.variables.items():
        value = operator.values[parameter]
        # Of a list, how many numbers it has.
        is_list = hasattr(value, "__len__") and not isinstance(value, str)
        text = f"{len(value)} numbers, in the model file" if is_list else value
        text = text if isinstance(text, str) else with_unit(float(value), variable.unit(operator.kind))
        parameters.append([parameter, text, variable.description])
    sections = [
        Section("operators", "Operators compared" if compared else "", [compared, Block("items", notes)]),
        Section("model", "The operator", [Table(operator.name, ("Parameter", "Value", "Meaning"), parameters)]),
        Section("log", "The data", [Block("facts", read, ("What was read",))], folded=True),
    ]
    front = _front(prediction, f"{name}: {title}", recorded, fits)
    facts = {"recorded": recorded, "outputs": prediction.outputs, "log_name": recorded.source.name.strip("<>")}
    return report_page("operator", facts, front, sections, **options)


def operator_ruling(error: float, held_out: float | None, *, fitted: bool) -> Ruling:
    """Return whether an operator is usable, and why."""
    decisive = error if held_out is None else held_out
    place = "on what it was not fitted to" if held_out is not None else "on these curves"
    reasons = [f"it misses {percent_text(decisive)} of full scale {place}"]
    if fitted and held_out is None:
        reasons.append("nothing was held out: its error says nothing of other curves")
    # Too many parameters: the error outside the fit is much larger.
    if held_out is not None and held_out > 2.0 * error:
        reasons.append(f"on the curves that it was fitted to it misses no more than {percent_text(error)}")
    # Beyond 20 % of full scale it is of no use.
    if decisive > 20.0:
        return Ruling("no", "Not usable", tuple(reasons))
    care = decisive > 5.0 or len(reasons) > 1  # up to 5 % of full scale an operator is usable
    return Ruling("with_care" if care else "usable", "Use with care" if care else "Usable", tuple(reasons))


def _front(prediction: OperatorPrediction, heading: str, recorded: Curves, fits: Sequence[OperatorFit]) -> Front:
    """Return the first page of an operator, identified or held against other curves; `fits` are best first."""
    held_out, unit = fits[0].held_out if fits else None, unit_of("force", recorded.kind)
    curves = f"{len(recorded.curves)} {'curve' if len(recorded.curves) == 1 else 'curves'}"
    then = "predict curves that it has not seen: `bristle predict model.toml CURVES --axis axis.toml`"
    answers = answered(
        [
            f"off by {fixed(prediction.rmse, unit)} of {fixed(recorded.full_scale, unit)}, root mean square",
            f"error on {held_out.of} that it was not fitted to: {percent_text(held_out.mean_percent)}" if held_out is not None else "",
        ],
        ["the model file, model.toml, as it is written" if fits else "nothing new: the model file as it is"],
        [
            f"beside it: {percent_text(fit.prediction.error_percent if fit.held_out is None else fit.held_out.mean_percent)} by {fit.name}"
            for fit in fits[1:4]
        ]
        or ["no other operator was compared"],
        [f"{curves}, each begins: {recorded.start}", *(list(filter(None, fits[0].notes))[:2] if fits else ())],
        [then if fits else "where it misses: record more curves there, and identify again"],
        third="How others do",
    )
    ruling = operator_ruling(prediction.error_percent, held_out and held_out.mean_percent, fitted=bool(fits))
    return Front(heading, about(curves), ruling, answers, "model")


def comparison_of_operators(identification: OperatorIdentification) -> Table:
    """Return the operators compared, best first."""
    rmse = Quantity.of(unit_of("force", identification.recorded.kind), [fit.prediction.rmse for fit in identification.fits])
    rows = [
        {
            "Operator": fit.name,
            "Rank": str(fit.rank),
            "Error on what was not fitted [% of full scale]": f"{short_text(fit.held_out.mean_percent)} ± "
            f"{number(fit.held_out.std_percent, digits=2)}"
            if fit.held_out
            else "–",
            "Fitted [% of full scale]": short_text(fit.prediction.error_percent),
            rmse.head("Fitted"): short_text(fit.prediction.rmse * rmse.scale.factor),
        }
        for fit in identification.fits
    ]
    return Table.of("Operators compared", rows)


def _parameters(operator: Model, offset: float) -> dict[str, Any]:
    """Return the parameters that are single numbers; tables stand in the model file."""
    values = {
        name: {"value": value, "unit": variable.unit(operator.kind), "description": variable.description}
        for name, variable in operator.component.variables.items()
        if not hasattr(value := operator.values[name], "__len__") or isinstance(value, str)
    }
    level = {"value": offset, "unit": unit_of("force", operator.kind), "description": "constant output beside it"}
    return values if "offset" in values else values | {"offset": level}


def _log(recorded: Curves) -> dict[str, Any]:
    counts = {"curves": len(recorded.curves), "samples": sum(curve.u.size for curve in recorded.curves)}
    return counts | picked(recorded, "start", "full_scale", "notes")
