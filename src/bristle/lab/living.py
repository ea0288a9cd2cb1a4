"""The part of a report in which parameters move: the module of the model, the rows that it was fitted to, and the loop.

In the loop the axis stays as it was simulated, with what the model does not explain pushing it; what is fed forward is
the model with the values that are moved. Law and encoder are a module of their own, as they are in the lab.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup

from bristle.core import Axis, InputError, Model, Status, typeset, unit_of
from bristle.exports import as_json, fitted_rows, loop_described, model_described, trace_described, variables_of
from bristle.identification import Fit, Identification
from bristle.lab.page import joined, policy
from bristle.prediction import Following
from bristle.simulation import COMPENSATED, SimulationResult

SHARED = ("inflate.js", "numbers.js", "physics.js", "loop.js", "move.js")
SCRIPTS = ("paths.js", "rows.js", "plot.js", "pointing.js", "controls.js", "asking.js", "following.js", "living.js")
STYLES = ("controls.css", "living.css")
AROUND = 3.0  # times up and down from an identified value


class Living(NamedTuple):
    """A part of a report in which parameters are moved; without scripts it is not there."""

    policy: str
    style: Markup
    shared: Markup
    script: Markup
    data: Markup
    follows: bool
    macro = "living"


def living_part(
    identification: Identification, axis: Axis | None, simulation: SimulationResult | None = None, following: Following | None = None
) -> Living | None:
    """Return what makes the report of an identification move; None where the model cannot be computed on a page."""
    fit = identification.best
    rows = fitted_rows(fit, identification.log, axis, identification.treatment)
    if rows is None:
        return None
    uncertainty = uncertainty_of(fit)
    try:
        model = model_described(fit.friction, uncertainty=uncertainty, around=AROUND, proven=False)
    except InputError:
        return None
    moved = [column.name for column in rows.mechanical if column.name]
    plant = [row for row in variables_of(fit.plant, moved, model["scales"]["force"], uncertainty, AROUND) if not row["fixed"]]
    data = {
        "model": model,
        "plant": plant,
        "rows": rows.as_data(),
        "effort": typeset(unit_of("force", fit.plant.kind)),
        "word": "torque" if fit.plant.kind == "rotational" else "force",
        "logs": 1 + len(identification.further_logs),
        "loop": followed_part(fit.friction, simulation, following),
    }
    shared, script = joined(SHARED), joined(SCRIPTS)
    texts = (Markup(text) for text in (joined(STYLES), shared, script, as_json(data)))
    return Living(policy([shared, script]), *texts, follows=data["loop"] is not None)


def uncertainty_of(fit: Fit) -> dict[str, Mapping[str, Any]]:
    """Return of each parameter whether it is identified, and its 95 % interval where there is one."""
    return {name: {"status": estimate.status, "interval": estimate.ends} for name, estimate in fit.parameters.items()}


def followed_part(friction: Model, simulation: SimulationResult | None, following: Following | None) -> dict[str, Any] | None:
    """Return how the loop followed, and what computes it; None where nothing followed."""
    errors = _errors(simulation, following)
    if not errors:
        return None
    from bristle.figures.style import envelope

    loop: dict[str, Any] | None = None
    variants = () if simulation is None else simulation.experiment.variants
    variant = next((variant for variant in variants if variant.name == COMPENSATED), None)
    if following is not None and following.contradiction is not None:
        reason = "the log contradicts the simulated loop"
    elif variant is None:
        reason = "no loop was simulated, for which the axis file needs a controller"
    else:
        loop, reason = loop_described(variant, friction)
    # As few points as look the same, by columns of the line.
    traces = [trace_described(name, time, error, envelope(error, 1000)) for name, time, error in errors]
    return {"traces": traces, "reason": reason, "loop": loop}


def _errors(simulation: SimulationResult | None, following: Following | None) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Return name, time and following error of the log and of each loop that the report tells of."""
    rows = [] if following is None else [("measured", following.time, following.error)]
    contradicted = following is not None and following.contradiction is not None
    if simulation is None:
        return rows
    variants = simulation.experiment.variants[: 1 if contradicted else None]
    results = [simulation.variants[variant.name] for variant in variants]
    return rows + [
        (result.name, result.time, result.reference - result.measured) for result in results if result.status is not Status.NOT_FINITE
    ]
