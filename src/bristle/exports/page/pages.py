"""What pages hold: that of the lab with every friction model, and the part of a report in which parameters move.

In the loop of a report the axis stays as it was simulated, with what the model does not explain pushing it; what is fed
forward is the model with the values that are moved.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.status import Status
from bristle.core.typography import typeset
from bristle.core.variable import unit_of
from bristle.exports.page.described import model_described, variables_of
from bristle.exports.page.loop import loop_described, trace_described
from bristle.exports.page.packing import as_json, packed
from bristle.exports.page.rows import fitted_rows
from bristle.exports.page.switches import common_described, example_described, slots_described, switched
from bristle.friction import MODELS
from bristle.identification.result import Identification
from bristle.prediction.following import Following
from bristle.simulation.compensation import COMPENSATED
from bristle.simulation.result import SimulationResult

Uncertainty = Mapping[str, Mapping[str, Any]]


def lab_described(first: str | Model, loop: Mapping[str, Any], **known: Any) -> dict[str, Any]:
    """Return the data of the lab: the examples of all models, one of them first or one with values of its own, slots and a loop.

    What else is `known` of a model with values of its own is that of `switched`.
    """
    models, place = [example_described(name) for name in MODELS], 0
    if isinstance(first, str):
        place = list(MODELS).index(first)
    else:
        models.insert(0, switched(first, **known))
    data = {
        "models": models,
        "first": place,
        "loop": loop,
        "common": common_described(),
        "slots": {kind: slots_described(kind) for kind in sorted({row["kind"] for row in models})},
    }
    content = as_json(data).encode("utf-8")
    return {"code": packed(content), "size": len(content)}


def living_described(
    identification: Identification,
    axis: Axis | None,
    simulation: SimulationResult | None,
    following: Following | None,
    *,
    uncertainty: Uncertainty,
    around: float,
    kept: Callable[[np.ndarray], np.ndarray],
) -> dict[str, Any] | None:
    """Return what makes the report of an identification move; None where the model cannot be computed on a page.

    Sliders go `around` times up and down from an identified value; of a line, the samples that are `kept` are drawn.
    """
    fit = identification.best
    rows = fitted_rows(fit, identification.log, axis, identification.treatment)
    if rows is None:
        return None
    try:
        model = model_described(fit.friction, uncertainty=uncertainty, around=around, proven=False)
    except InputError:
        return None
    moved = [column.name for column in rows.mechanical if column.name]
    plant = [row for row in variables_of(fit.plant, moved, model["scales"]["force"], uncertainty, around) if not row["fixed"]]
    return {
        "model": model,
        "plant": plant,
        "rows": rows.as_data(),
        "effort": typeset(unit_of("force", fit.plant.kind)),
        "word": "torque" if fit.plant.kind == "rotational" else "force",
        "logs": 1 + len(identification.further_logs),
        "loop": followed_described(fit.friction, simulation, following, kept),
    }


def followed_described(
    friction: Model, simulation: SimulationResult | None, following: Following | None, kept: Callable[[np.ndarray], np.ndarray]
) -> dict[str, Any] | None:
    """Return how the loop followed, and what computes it; None where nothing followed."""
    errors = _errors(simulation, following)
    if not errors:
        return None
    loop: dict[str, Any] | None = None
    variants = () if simulation is None else simulation.experiment.variants
    variant = next((variant for variant in variants if variant.name == COMPENSATED), None)
    if following is not None and following.contradiction is not None:
        reason = "the log contradicts the simulated loop"
    elif variant is None:
        reason = "no loop was simulated, for which the axis file needs a controller"
    else:
        loop, reason = loop_described(variant, friction)
    traces = [trace_described(name, time, error, kept(error)) for name, time, error in errors]
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
