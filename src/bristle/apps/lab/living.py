"""The interactive part of a report: its scripts and their data."""

from functools import partial

from markupsafe import Markup

from bristle.apps.targets.page.loop import living_described
from bristle.apps.targets.page.packing import as_json
from bristle.core import Axis
from bristle.identification import Identification
from bristle.prediction import Following
from bristle.report.assets import joined, policy
from bristle.report.living import Living, uncertainty_of
from bristle.simulation import SimulationResult

PACKAGE = "bristle.apps.lab"
SHARED = ("numbers.js", "physics.js", "loop.js", "move.js")
SCRIPTS = ("paths.js", "rows.js", "controls.js", "asking.js", "following.js", "living.js")
STYLES = ("controls.css", "living.css")
AROUND = 3.0  # factor up and down from an identified value


def living_part(
    identification: Identification,
    axis: Axis | None,
    simulation: SimulationResult | None = None,
    following: Following | None = None,
) -> Living | None:
    """Return the interactive part for an identification, or None if a page cannot compute the model."""
    from bristle.report.figures.style import envelope

    uncertainty = uncertainty_of(identification.best)
    # The fewest points with the same picture, by columns of the line.
    thinned = partial(envelope, columns=1000)
    data = living_described(
        identification,
        axis,
        simulation,
        following,
        uncertainty=uncertainty,
        around=AROUND,
        thinned=thinned,
    )
    if data is None:
        return None
    shared, script = joined(SHARED, PACKAGE), joined(SCRIPTS, PACKAGE)
    texts = (Markup(text) for text in (joined(STYLES, PACKAGE), shared, script, as_json(data)))
    return Living(policy([shared, script]), *texts)
