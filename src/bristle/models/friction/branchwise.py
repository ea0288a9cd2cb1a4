r"""A contact with memory in continuous time: smooth between events, one branch at a time.

.. math:: \dot z = v\,[1 - \Phi(r)], \qquad r = \frac{f_h(z) \operatorname{sgn} v}{G(v)}

is smooth until an event: the velocity reverses, the force passes its value in sliding (there the deflection turns), the
branch reaches the turning point that wipes it out, or the ratio passes :math:`\rho`. At each event a margin falls below
zero. A `Piece` has the directions, the branch and the gate between two events. Past its end the equations continue
unchanged: a step across an event is as smooth as any other, and the solver can find the event in it.

In sliding the deflection follows :math:`G(v)` closely, and rounding alone would reverse it again and again. Therefore
it turns only after the ratio has passed 1 by a small `PASSED`, and the gate closes only that far below :math:`\rho`.
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import Variable, kernel
from bristle.core.mathematics import sin
from bristle.models.friction.deflection import onward
from bristle.models.friction.slip_law import slip
from bristle.models.hysteresis.turning_points import Branch, branch_output

PASSED = 1e-9


class Contact(NamedTuple):
    """Variable of the equations: the deflection [m or rad]."""

    z: Annotated[float, Variable("length", "deflection of the contact")]


class Piece(NamedTuple):
    """Constants until the next event: directions of motion and deflection, the branch and its end, and the gate."""

    side: float
    way: float
    z: float
    f: float
    depth: int
    end: float
    is_open: float


class Flow(NamedTuple):
    """Hysteretic force [N or N*m], rate of the deflection [m/s or rad/s], and distance to the next event, relative."""

    f: float
    z_dot: float
    margin: float


@kernel
def piece_at(stack, memory, side, G, law):
    """Return the `Piece` that begins at this state of the stack, for motion in the direction `side`."""
    r = side * stack.f / G
    passed = PASSED if side * stack.side > 0.0 else -PASSED
    way = side if 1.0 - r + passed > 0.0 else -side
    branch = onward(stack, memory, way)
    end = way * math.inf
    if branch.depth > 0:
        end = memory[branch.depth - 2] if branch.depth >= 2 else -memory[0]
    return Piece(side, way, branch.z, branch.f, branch.depth, end, 1.0 if r > law.rho else 0.0)


@kernel
def deflection_rate(z, piece, v, G, law, q):
    """Return the `Flow` at the deflection `z` and the velocity `v`; `G` is the force in sliding, `q` the measure."""
    branch = Branch(piece.z, piece.f, piece.way, piece.depth, piece.z, piece.end)
    # Behind its turning point a branch continues as its mirror image: smooth, for steps that reach back a little.
    behind = piece.depth > 0 and piece.way * (z - piece.z) < 0.0
    f = (
        2.0 * piece.f - branch_output(branch, 2.0 * piece.z - z, q)
        if behind
        else branch_output(branch, z, q)
    )
    r = piece.side * f / G
    margin = piece.way * (piece.end - z) * q.s / q.f_p
    if piece.way * piece.side > 0.0:
        margin = min(margin, 1.0 - r + PASSED)
    else:
        margin = min(margin, r - 1.0 + PASSED)
    share = 0.0
    if law.rho < 0.0:
        share = slip(r, law)
    elif piece.is_open == 0.0:
        margin = min(margin, law.rho - r)
    else:
        margin = min(margin, r - law.rho + PASSED)
        share = r
        if piece.way * piece.side > 0.0:
            share = 0.5 * (1.0 + sin(math.pi * (r - 0.5 * (1.0 + law.rho)) / (1.0 - law.rho))) * r
    return Flow(f, v * (1.0 - share), margin)
