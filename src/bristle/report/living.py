"""The part of a report with movable parameters, which an app makes."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from markupsafe import Markup

from bristle.identification import Fit


class Living(NamedTuple):
    """The part of a report with movable parameters; hidden without scripts."""

    policy: str
    style: Markup
    shared: Markup
    script: Markup
    data: Markup


def uncertainty_of(fit: Fit) -> dict[str, Mapping[str, Any]]:
    """Return the status of each parameter, with its 95 % interval if it has an interval."""
    return {
        name: {"status": estimate.status, "interval": estimate.ends}
        for name, estimate in fit.parameters.items()
    }
