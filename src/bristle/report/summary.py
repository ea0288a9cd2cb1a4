"""An identification as plain data, for JSON output and ``summary.json``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core import Axis, unit_of
from bristle.prediction import (
    drive_units,
    first_gain,
    largest_deviation,
    level_values,
    proposals_of,
    reversal_distance,
)
from bristle.report.judgement import compensation_in, ruling_of
from bristle.report.loops import prediction_as_data, variants_as_data
from bristle.report.messages import as_data, assumptions_of, message, note_of, picked, warnings_of
from bristle.report.model_tables import drive_values
from bristle.report.sweep import sweep_data

if TYPE_CHECKING:
    from bristle.identification import Estimate, Fit, Identification
    from bristle.prediction import Following
    from bristle.simulation import Prediction, SimulationResult
    from bristle.simulation.certificates import Certificate


NOT_SIMULATED: dict[str, Any] = dict.fromkeys(
    ("position_error_percent", "position_rmse", "loop_error_percent", "loop_rmse")
)


def identification_summary(
    identification: Identification,
    *,
    table: Sequence[tuple[float, float]],
    simulation: SimulationResult | None,
    prediction: Prediction | None,
    provenance: Mapping[str, str],
    certificates: Mapping[str, Certificate] | None = None,
    following: Following | None = None,
    axis: Axis | None = None,
) -> dict[str, Any]:
    """Return an identification in numbers: the best model on top, all of them under ``models``."""
    best, log = identification.best, identification.log
    kind = best.friction.kind
    compensation = compensation_in(identification)
    gain = first_gain(best, compensation)
    doubt, ruling = (
        None if following is None else following.contradiction,
        ruling_of(identification, following),
    )
    explanation = None
    if identification.explanation is not None:
        explanation = identification.explanation.as_data(tables=False)
    return {
        "model": best.name,
        "kind": kind,
        "verdict": {"level": ruling.level, "reasons": ruling.reasons},
        "feedforward": {
            "first_gain": gain,
            "error_percent": best.friction_alone_error_percent,
            "reach": compensation.reach,
            "claims": [claim._asdict() for claim in compensation.claims if gain],
        },
        "proposals": proposals_of(best, axis or Axis(kind=kind), identification.second_pass),
        "explanation": explanation,
        "parameters": _parameters(best, axis),
        "combinations": _described(best.combinations),
        "metrics": NOT_SIMULATED | best.metrics,
        "resampling": _resampling(best),
        "certificates": {
            name: vars(certificate) for name, certificate in (certificates or {}).items()
        },
        "warnings": [*warnings_of(best), *((message(doubt),) if doubt else ())],
        "assumptions": assumptions_of(best),
        "diagnostics": as_data([*best.diagnostics, *((doubt,) if doubt else ())]),
        "models": [
            {
                "name": fit.name,
                "rank": fit.rank,
                "parameters": _parameters(fit, axis),
                "metrics": NOT_SIMULATED | fit.metrics,
                "warnings": warnings_of(fit),
                "diagnostics": as_data(fit.diagnostics),
            }
            for fit in identification.fits
        ],
        "correlation": {"names": best.correlation_names, "values": best.correlation},
        "drive_table": {
            "velocity_unit": unit_of("length/time", kind),
            "effort_unit": unit_of("force", kind),
            "velocity": [velocity for velocity, _ in table],
            "effort": [effort for _, effort in table],
            "largest_deviation": largest_deviation(best, table) if table else None,
        },
        "drive_levels": _levels(best, axis),
        "following_error": None if following is None else following.as_data(),
        "compensation": None if simulation is None else variants_as_data(simulation),
        "prediction": None if prediction is None else prediction_as_data(prediction),
        "log": {"samples": len(log)} | picked(log, "sample_time", "duration", "notes"),
        "unfinished": identification.unfinished or None,
        "left_out": dict(identification.left_out),
        "further_logs": [log.origin.name for log in identification.further_logs],
        "treatment": identification.treatment,
        "settings": identification.settings.as_data(),
        "break_aways": [break_away._asdict() for break_away in identification.break_aways],
        "provenance": provenance,
    } | _where_shown(identification)


def _where_shown(identification: Identification) -> dict[str, Any]:
    """Return the entries of logs with two masses, and with sweeps of small amplitude."""
    masses = identification.two_masses
    return ({} if masses is None else {"two_masses": masses.as_data()}) | sweep_data(identification)


def _levels(fit: Fit, axis: Axis | None) -> dict[str, Any] | None:
    """Return the levels for a drive in SI and in each unit of the drive."""
    levels, units = level_values(fit), drive_units(axis, fit.plant.kind)
    if levels is None:
        return None
    viscous = {
        "viscous_forward": levels.viscous_forward,
        "viscous_backward": levels.viscous_backward,
    }
    forces = {
        name: value for name, value in levels._asdict().items() if name not in ("inertia", *viscous)
    }
    of_units = {
        unit.name: {
            name: None if value is None else unit.of(value) for name, value in forces.items()
        }
        for unit in units.efforts
    }
    of_units |= {unit.name: {"inertia": unit.of(levels.inertia)} for unit in units.inertias}
    of_units |= {
        unit.name: {
            name: None if value is None else unit.of(value) for name, value in viscous.items()
        }
        for unit in units.of("force*time/length")
    }
    distance = reversal_distance(fit.friction, float(np.max(np.abs(fit.traces.velocity))))
    of_units |= {unit.name: {"reversal_distance": unit.of(distance)} for unit in units.lengths}
    presliding = {"reversal_distance": distance, "lag": fit.lag}
    return levels._asdict() | presliding | {"units": of_units}


def _parameters(fit: Fit, axis: Axis | None) -> dict[str, Any]:
    """Return the parameters, also in the units of the drive."""
    values = drive_values(fit, axis)
    return {
        name: estimate | {"in_drive_units": values.get(name, {})}
        for name, estimate in _described(fit.estimates).items()
    }


def _described(estimates: Sequence[Estimate]) -> dict[str, Any]:
    names = (
        "value",
        "unit",
        "std",
        "relative_std_percent",
        "robust_std",
        "interval_percent",
        "interval",
        "status",
    )
    return {
        estimate.name: picked(estimate, *names)
        | {"note": note_of(estimate), "description": estimate.description}
        for estimate in estimates
    }


def _resampling(fit: Fit) -> dict[str, Any] | None:
    """Return further results of the fits to simulated logs, in SI."""
    resampling = fit.resampling
    if resampling is None:
        return None
    of_bands = (
        "noise",
        "unexplained",
        "lasting",
        "inflation",
        "left_in_closed_loop",
        "left_in_open_loop",
    )
    facts = picked(resampling, "half_cycles", "resolution") | picked(resampling.bands, *of_bands)
    return facts | {
        "draws": resampling.bands.count,
        "scatter": resampling.scatter._asdict(),
        "virgin_curve": {
            name: [row[column] for row in resampling.curve]
            for column, name in enumerate(("x", "force", "low", "high"))
        },
        "virgin_curve_from": resampling.curve_from,
    }
