"""`Passing`: a desired motion that comes to rest."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from bristle.core.contracts import Trajectory


@dataclass(frozen=True, kw_only=True)
class Passing(Trajectory):
    """A desired motion from rest to rest: ``duration(p)`` is how long it takes [s]."""

    duration: Callable[[Any], float]
