"""The interactive part of a report: its scripts and their data."""

from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple

from markupsafe import Markup

from bristle.core import Axis
from bristle.exports import as_json, living_described
from bristle.identification import Fit, Identification
from bristle.lab.page import joined, policy
from bristle.prediction import Following
from bristle.simulation import SimulationResult

SHARED = ("numbers.js", "physics.js", "loop.js", "move.js")
SCRIPTS = ("paths.js", "rows.js", "controls.js", "asking.js", "following.js", "living.js")
STYLES = ("controls.css", "living.css")
AROUND = 3.0  # factor up and down from an identified value


class Living(NamedTuple):
    """The part of a report with movable parameters; hidden without scripts."""

    policy: str
    style: Markup
    shared: Markup
    script: Markup
    data: Markup


def living_part(
    identification: Identification, axis: Axis | None, simulation: SimulationResult | None = None, following: Following | None = None
) -> Living | None:
    """Return the interactive part for an identification, or None if a page cannot compute the model."""
    from bristle.figures.style import envelope

    uncertainty = uncertainty_of(identification.best)
    thinned = partial(envelope, columns=1000)  # the fewest points with the same picture, by columns of the line
    data = living_described(identification, axis, simulation, following, uncertainty=uncertainty, around=AROUND, thinned=thinned)
    if data is None:
        return None
    shared, script = joined(SHARED), joined(SCRIPTS)
    texts = (Markup(text) for text in (joined(STYLES), shared, script, as_json(data)))
    return Living(policy([shared, script]), *texts)


def uncertainty_of(fit: Fit) -> dict[str, Mapping[str, Any]]:
    """Return the status of each parameter, with its 95 % interval if it has an interval."""
    return {name: {"status": estimate.status, "interval": estimate.ends} for name, estimate in fit.parameters.items()}
