"""The reports of hysteresis operators: their identification, and the prediction of further curves."""

from collections.abc import Mapping, Sequence
from typing import Any

from bristle.core import Model, number, unit_of, with_unit
from bristle.identification.hysteresis import (
    OperatorFit,
    OperatorIdentification,
    OperatorPrediction,
)
from bristle.logs import Curves
from bristle.report.cards import Card, Step
from bristle.report.messages import picked
from bristle.report.page import Block, Front, Ruling, Section, about, report_page
from bristle.report.table import Quantity, Table, fixed, percent_text, short_text

MORE = "record more curves where the error is large: `bristle identify CURVES --axis axis.toml --model preisach`"


def operator_summary(
    identification: OperatorIdentification, *, provenance: Mapping[str, str]
) -> dict[str, Any]:
    """Return the identification of operators in numbers: the best operator on top, all operators under ``models``."""
    best, kind = identification.best, identification.recorded.kind
    return {
        "model": best.name,
        "kind": kind,
        "parameters": _parameters(best.operator, best.offset),
        "verdict": operator_ruling(
            best.prediction.error_percent, best.held_out and best.held_out.mean_percent, fitted=True
        ).as_data(),
        "metrics": best.metrics,
        "notes": best.notes,
        "congruency": picked(identification.congruency, "alike", "anywhere"),
        "models": [
            picked(fit, "name", "rank", "metrics", "notes")
            | {"parameters": _parameters(fit.operator, fit.offset)}
            for fit in identification.fits
        ],
        "log": _log(identification.recorded),
        "unfinished": identification.unfinished or None,
        "provenance": provenance,
    }


def operator_prediction_summary(
    prediction: OperatorPrediction,
    operator: Model,
    recorded: Curves,
    *,
    provenance: Mapping[str, str],
) -> dict[str, Any]:
    """Return the prediction of recorded curves by an operator in numbers."""
    metrics = {"error_percent": prediction.error_percent, "rmse": prediction.rmse}
    return {
        "model": operator.name,
        "kind": operator.kind,
        "mode": "operator",
        "verdict": operator_ruling(prediction.error_percent, None, fitted=False).as_data(),
        "metrics": metrics
        | {"unit": unit_of("force", operator.kind), "full_scale": prediction.full_scale},
        "log": _log(recorded),
        "provenance": provenance,
    }


def operator_report(identification: OperatorIdentification, **options: Any) -> str:
    """Return the report of the identification of an operator as an HTML page; options as of `operator_prediction_report`."""
    best = identification.best
    return operator_prediction_report(
        best.prediction,
        best.operator,
        identification.recorded,
        identification=identification,
        **options,
    )


def operator_prediction_report(
    prediction: OperatorPrediction,
    operator: Model,
    recorded: Curves,
    *,
    name: str,
    identification: OperatorIdentification | None = None,
    **options: Any,
) -> str:
    """Return the report of curves, predicted by an operator or identified, of an axis with this name; options as of `report_page`."""
    fits, notes = (
        ((), ()) if identification is None else (identification.fits, identification.notes)
    )
    title = (
        f"prediction by {operator.name}"
        if identification is None
        else f"{operator.name} identified"
    )
    compared = (
        comparison_of_operators(identification)
        if identification is not None and len(fits) > 1
        else None
    )
    read = [
        ("Curves", str(len(recorded.curves))),
        ("Samples", str(sum(curve.u.size for curve in recorded.curves))),
        ("Each begins", recorded.start),
        ("Full scale", with_unit(recorded.full_scale, unit_of("force", recorded.kind))),
        *(("Held out", fit.held_out.of) for fit in fits[:1] if fit.held_out),
        *(("Note", note) for note in recorded.notes),
    ]
    parameters = []
    for parameter, variable in operator.component.variables.items():
        value = operator.values[parameter]
        # For a list, its length.
        is_list = hasattr(value, "__len__") and not isinstance(value, str)
        text = f"{len(value)} numbers, in the model file" if is_list else value
        text = (
            text if isinstance(text, str) else with_unit(float(value), variable.unit(operator.kind))
        )
        parameters.append([parameter, text, variable.description])
    sections = [
        Section(
            "operators",
            "Operators compared" if compared else "Remarks",
            [compared, Block("items", notes)],
        ),
        Section(
            "model",
            "The operator",
            [Table(operator.name, ("Parameter", "Value", "Meaning"), parameters)],
        ),
        Section("log", "The data", [Block("facts", read, ("Recorded curves",))]),
    ]
    front = _front(prediction, f"{name}: {title}", recorded, fits)
    facts = {
        "recorded": recorded,
        "outputs": prediction.outputs,
        "log_name": recorded.source.name.strip("<>"),
    }
    return report_page("operator", facts, front, sections, **options)


def operator_ruling(error: float, held_out: float | None, *, fitted: bool) -> Ruling:
    """Return the verdict on an operator, with its reasons."""
    decisive = error if held_out is None else held_out
    place = "on held-out curves" if held_out is not None else "on these curves"
    reasons = [f"the error is {percent_text(decisive)} of full scale {place}"]
    if fitted and held_out is None:
        reasons.append("without held-out curves, the error on other curves is unknown")
    # Too many parameters: the error outside the fit is much larger.
    if held_out is not None and held_out > 2.0 * error:
        reasons.append(f"the error on the fitted curves is only {percent_text(error)}")
    # An operator with an error above 20 % of full scale is not usable.
    if decisive > 20.0:
        return Ruling("no", "Not usable", tuple(reasons))
    care = decisive > 5.0 or len(reasons) > 1  # limit for a usable operator
    return Ruling(
        "with_care" if care else "usable", "Use with care" if care else "Usable", tuple(reasons)
    )


def _front(
    prediction: OperatorPrediction, heading: str, recorded: Curves, fits: Sequence[OperatorFit]
) -> Front:
    """Return the first page of an operator, identified or compared with further curves; `fits` are best first."""
    held_out, unit = fits[0].held_out if fits else None, unit_of("force", recorded.kind)
    curves = f"{len(recorded.curves)} {'curve' if len(recorded.curves) == 1 else 'curves'}"
    ruling = operator_ruling(
        prediction.error_percent, held_out and held_out.mean_percent, fitted=bool(fits)
    )
    then = "predict further curves: `bristle predict model.toml CURVES --axis axis.toml`"
    error, basis = (
        prediction.error_percent if held_out is None else held_out.mean_percent,
        recorded.source.name.strip("<>"),
    )
    cards = [
        Card("Error", fixed(prediction.rmse, unit), "rms"),
        Card("Full scale", fixed(recorded.full_scale, unit), curves),
        Card("Fitted curves", percent_text(prediction.error_percent)) if fits else None,
        Card("Next best", percent_text(fits[1].prediction.error_percent), fits[1].name)
        if fits[1:]
        else None,
    ]
    return Front(
        heading,
        about(curves),
        ruling.beyond_title,
        title=f"{'Operator' if held_out is None else 'Held-out'} error {percent_text(error)} of full scale",
        basis=f"({basis})" if basis else "",
        cards=[card for card in cards if card is not None],
        next=Step.of(then if fits else MORE),
    )


def comparison_of_operators(identification: OperatorIdentification) -> Table:
    """Return the operators compared, best first."""
    rmse = Quantity.of(
        unit_of("force", identification.recorded.kind),
        [fit.prediction.rmse for fit in identification.fits],
    )
    rows = [
        {
            "Operator": fit.name,
            "Rank": str(fit.rank),
            "Held-out error [% of full scale]": f"{short_text(fit.held_out.mean_percent)} ± {number(fit.held_out.std_percent, digits=2)}"
            if fit.held_out
            else "–",
            "Fitted [% of full scale]": short_text(fit.prediction.error_percent),
            rmse.head("Fitted"): short_text(fit.prediction.rmse * rmse.scale.factor),
        }
        for fit in identification.fits
    ]
    return Table.of("Operators compared", rows)


def _parameters(operator: Model, offset: float) -> dict[str, Any]:
    """Return the scalar parameters; tables are only in the model file."""
    values = {
        name: {
            "value": value,
            "unit": variable.unit(operator.kind),
            "description": variable.description,
        }
        for name, variable in operator.component.variables.items()
        if not hasattr(value := operator.values[name], "__len__") or isinstance(value, str)
    }
    level = {
        "value": offset,
        "unit": unit_of("force", operator.kind),
        "description": "constant output added to the operator",
    }
    return values if "offset" in values else values | {"offset": level}


def _log(recorded: Curves) -> dict[str, Any]:
    counts = {
        "curves": len(recorded.curves),
        "samples": sum(curve.u.size for curve in recorded.curves),
    }
    return counts | picked(recorded, "start", "full_scale", "notes")
