"""How components travel to other processes: by where they are defined, as functions and classes do.

A component arrives as the one object that it is there, so that what compares by identity holds across processes. A
module that the other process could not import says by ``__travels_as__`` what it is made from.
"""

from __future__ import annotations

import importlib
import pickle
import sys
from types import ModuleType
from typing import Protocol

from bristle.core.described import Described
from bristle.core.errors import InputError

__all__ = ["Source", "component_in", "whereabouts"]

MAIN = ("__main__", "__mp_main__")
MEND = "Put it into a file of its own, by a name at the left margin such as MODEL, and import it from there"


class Source(Protocol):
    """What a module is made from that cannot be imported; it travels itself."""

    def module(self) -> ModuleType:
        """Return the module, the same one whenever asked in one process."""
        ...


def whereabouts(component: Described) -> tuple[Source | str, str]:
    """Return the module of a component, or its source, and its name there: the arguments of `component_in`."""
    for home in _homes(component):
        held = getattr(sys.modules.get(home), "__dict__", {})
        for name, value in list(held.items()):
            if value is component:
                return held.get("__travels_as__", home), name
    place = f"{component.family} {component.name}"
    raise pickle.PicklingError(str(InputError("stands in no module, where another process would look for it", path=place, mend=MEND)))


def _homes(component: Described) -> tuple[str, ...]:
    """Return the modules that a component may stand in, its own first: hardly ever is it in another.

    Then come all others in the order in which they were imported, so that what defines it comes before what has it from
    there, and the one that a person types last.
    """
    return component.module, *sorted(sys.modules, key=MAIN.__contains__)


def component_in(source: Source | str, name: str) -> Described:
    """Return the component of this name in a module."""
    module = importlib.import_module(source) if isinstance(source, str) else source.module()
    component = vars(module).get(name)
    if component is None:
        place = f"{module.__name__}.{name}"
        raise pickle.UnpicklingError(str(InputError("is not to be found in this process", path=place, mend=MEND)))
    return component
