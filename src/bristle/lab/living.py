"""The part of a report in which parameters move: the module of the model, and the rows that it was fitted to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from bristle.core.errors import InputError
from bristle.core.normal import NORMAL_95
from bristle.core.typography import typeset
from bristle.core.variable import unit_of
from bristle.lab.described import described, variables_of
from bristle.lab.followed import followed_part
from bristle.lab.packing import as_json
from bristle.lab.page import joined, policy
from bristle.lab.rows import fitted_rows
from bristle.report.page import Living

if TYPE_CHECKING:
    from bristle.core.axis import Axis
    from bristle.identification.result import Estimate, Fit, Identification
    from bristle.prediction.following import Following
    from bristle.simulation.result import SimulationResult

__all__ = ["living_part", "uncertainty_of"]

SHARED = ("inflate.js", "numbers.js", "physics.js", "loop.js", "move.js")
SCRIPTS = ("paths.js", "rows.js", "plot.js", "pointing.js", "controls.js", "asking.js", "following.js", "living.js")
STYLES = ("controls.css", "living.css")
AROUND = 3.0  # times up and down from an identified value


def living_part(
    identification: Identification, axis: Axis | None, simulation: SimulationResult | None = None, following: Following | None = None
) -> Living | None:
    """Return what makes the report of an identification move; None where the model cannot be computed on a page."""
    data = _data(identification, axis)
    if data is None:
        return None
    data["loop"] = followed_part(identification.best.friction, simulation, following)
    shared, script = joined(SHARED), joined(SCRIPTS)
    return Living(
        policy([shared, script]),
        Markup(joined(STYLES)),
        Markup(shared),
        Markup(script),
        Markup(as_json(data)),
        follows=data["loop"] is not None,
    )


def _data(identification: Identification, axis: Axis | None) -> dict[str, Any] | None:
    fit = identification.best
    rows = fitted_rows(fit, identification.log, axis, identification.treatment)
    if rows is None:
        return None
    uncertainty = uncertainty_of(fit)
    try:
        model = described(fit.friction, uncertainty=uncertainty, around=AROUND, proven=False)
    except InputError:
        return None
    moved = [column.name for column in rows.mechanical if column.name]
    plant = [row for row in variables_of(fit.plant, moved, model["scales"]["force"], uncertainty, AROUND) if not row["fixed"]]
    return {
        "model": model,
        "plant": plant,
        "rows": rows.as_data(),
        "effort": typeset(unit_of("force", fit.plant.kind)),
        "word": "torque" if fit.plant.kind == "rotational" else "force",
        "logs": 1 + len(identification.further_logs),
    }


def uncertainty_of(fit: Fit) -> dict[str, Mapping[str, Any]]:
    """Return of each parameter whether it is identified, and its 95 % interval where there is one."""
    return {name: _uncertainty_of(estimate) for name, estimate in fit.parameters.items()}


def _uncertainty_of(estimate: Estimate) -> Mapping[str, Any]:
    interval = estimate.interval
    if interval is None and estimate.larger_std is not None:
        half = NORMAL_95 * estimate.larger_std
        interval = (estimate.value - half, estimate.value + half)
    return {"status": estimate.status, "interval": interval}
