"""Parts and results that apps make, by name: a room imports no app."""

from pkgutil import resolve_name
from typing import Any

PARTS = {
    "living": "bristle.apps.lab.living:living_part",  # the movable parameters of a report
    "design": "bristle.apps.design.analysis:design",  # a loop before it is built
    "runs": "bristle.apps.study.store:Runs",  # the runs of a study
    "widget": "bristle.apps.lab.widget:Widget",  # the view of a model in a notebook
}


def part(name: str) -> Any:
    """Return a function or a class of an app; its first use loads the app."""
    return resolve_name(PARTS[name])
