"""The part of a report in which parameters move: its scripts, and the data that they compute with."""

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
    from bristle.figures.style import envelope

    uncertainty = uncertainty_of(identification.best)
    thinned = partial(envelope, columns=1000)  # as few points as look the same, by columns of the line
    data = living_described(identification, axis, simulation, following, uncertainty=uncertainty, around=AROUND, thinned=thinned)
    if data is None:
        return None
    shared, script = joined(SHARED), joined(SCRIPTS)
    texts = (Markup(text) for text in (joined(STYLES), shared, script, as_json(data)))
    return Living(policy([shared, script]), *texts, follows=data["loop"] is not None)


def uncertainty_of(fit: Fit) -> dict[str, Mapping[str, Any]]:
    """Return of each parameter whether it is identified, and its 95 % interval where there is one."""
    return {name: {"status": estimate.status, "interval": estimate.ends} for name, estimate in fit.parameters.items()}
