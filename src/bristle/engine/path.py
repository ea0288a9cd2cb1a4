"""Hysteresis and effort along a path of the input, and the lead of a motor: no time, one pass."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from bristle.core import Model, array, guarded
from bristle.engine import entry_points
from bristle.engine.checks import OPERATOR
from bristle.engine.compilation import compiled
from bristle.engine.instance import Instance, entry_of, memory_of, warn_of_lost
from bristle.engine.signature import Vector
from bristle.models.plants.terms import Place, effort_at, gravity_at


class Lead(NamedTuple):
    """Lead of a motor over its table: angle [rad], rate and acceleration at each sample, and the effort in the step after it."""

    position: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    effort: np.ndarray


@guarded(operator=OPERATOR, u=array())
def output_along(
    operator: Model, u: Any, *, state: Any = None, memory: np.ndarray | None = None
) -> np.ndarray:
    """Return the output of a hysteresis operator along an input."""
    part = Instance(operator)
    part.begin(state)
    return _follow(part, memory_of(operator, memory), u)


@guarded(operator=OPERATOR, history=array())
def after(operator: Model, history: Any) -> tuple[Any, np.ndarray]:
    """Return the state and the memory of a hysteresis operator after a history of its input."""
    part, memory = Instance(operator), memory_of(operator, None)
    _follow(part, memory, history)
    return part.state_now, memory


def _follow(part: Instance, memory: np.ndarray, u: np.ndarray) -> np.ndarray:
    output = np.empty(u.size)
    entry_of("output_along", part, entry_points.OutputAlong, entry_points.make_output_along)(
        part.parameters, part.state, memory, u, output
    )
    warn_of_lost(part)
    return output


# (coefficients of gravity and spring, angle of each wave over the position, cosines, sines, positions, efforts).
EffortAlong = Callable[[Vector, Vector, Vector, Vector, Vector, Vector], float]


def effort_entry(numbers, waves, cosines, sines, x, effort):
    """Write the effort at each position."""
    place = Place(numbers[0], numbers[1], waves, cosines, sines, numbers[2], numbers[3], numbers[4])
    for k in range(x.size):
        effort[k] = effort_at(x[k], place)
    return 0.0


def effort_along(x: np.ndarray, place: Place) -> np.ndarray:
    """Return the effort [N or N*m] of gravity, cogging and a spring at some positions [m or rad], shape (sample,)."""
    effort = np.empty(x.size)
    entry = compiled("effort_along", lambda: effort_entry, EffortAlong, (effort_at, gravity_at))
    # Writable copies
    waves = (np.array(part, dtype=float) for part in (place.waves, place.cosines, place.sines))
    entry(
        np.array([place.g_sin, place.g_cos, place.spring_1, place.spring_2, place.spring_3]),
        *waves,
        np.array(x, dtype=float),
        effort,
    )
    return effort
