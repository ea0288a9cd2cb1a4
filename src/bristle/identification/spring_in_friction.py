r"""Friction of a model that grows along the stroke, as the force of a spring, a cable or gravity does.

Friction of a virgin contact in slow motion is :math:`F(x)`. If it consists of elements that slip, those that slip within
:math:`x` hold :math:`F - x\,dF/dx`, and the others hold the rest. Elements that slip within a hundredth of the stroke are a
contact. If others slip only beyond a tenth, and few between, the others may be a force over the position: over strokes of equal
length, both are the same. Friction that builds up over a single distance, of any length, has no such gap.
"""

import numpy as np

from bristle.core.contracts import Model
from bristle.engine.motion import CREEP, FARTHER, SLOW, along
from bristle.models.friction import unvaried

# Of the stroke: a contact slips within the first, a spring grows beyond the second.
BOUNDS = (0.01, 0.1)
CONTACT = 0.1  # of the force: without a contact, friction builds up over the stroke
SPRING = 0.01  # of the force: smallest share that matters


def spring_share(friction: Model, stroke: float) -> float:
    """Return the share of friction that may be a spring over a stroke [m or rad]; 0 if there is none."""
    ahead, back = (along(unvaried(friction), side * stroke * CREEP, SLOW) for side in (1.0, -1.0))
    force = 0.5 * (ahead - back)  # without a constant force
    way = FARTHER[1:] - 0.5 * np.diff(FARTHER)  # of the stroke, in the middle of each step
    slipped = np.interp(BOUNDS, way, force - way * np.gradient(force, way))
    within, before = slipped.tolist()
    total = float(force[-1])
    beyond = total - before
    if within > CONTACT * abs(total) and beyond > max(SPRING * abs(total), before - within):
        return beyond / total
    return 0.0
