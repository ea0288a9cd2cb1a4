r"""The memory of a Preisach operator: a stack of turning points, and the current branch.

With the last stored turning point :math:`(z_n, f_n)` the output on the current branch is

.. math:: f = f_n \pm 2E(\max(z, z_n), \min(z, z_n))

When the input reaches :math:`z_{n-1}` again the loop closes and both points are forgotten (wiping-out). With a single
point left the branch merges with the virgin curve at :math:`-z_1`. A reversal stores a point. This is the double
integral over the Preisach plane, in amortised constant time. Summed from the start, the branches are equations (14)
and (15) of the source paper: for relays of :math:`\pm 1` with a factor 2 and the offset :math:`-E(\alpha_0, \beta_0)`,
for relays of 0 and 1, whose measure is twice this measure, with the offset alone.

The kernels accept a measure of either sign, for magnets and for friction. ``memory`` has the inputs of the points in its
first half and their outputs in the second half. Above the last point is the present point, ready for a reversal. In a
full memory the innermost pair is forgotten first, which keeps the output continuous there and the points in order, and
is counted in ``lost``.

A model that moves the input (friction with a deflection) takes the same steps: `branch_at` finds the branch once, and
`branch_output` and `branch_slope` evaluate it anywhere between ``begin`` and ``end``. `stack_trial` and `stack_commit`
do the whole step.
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import Variable, kernel
from bristle.core.dispatch import everett, everett_slope, virgin_curve, virgin_slope

# With fewer, forgetting the innermost pair would leave no outer loop to return to.
SMALLEST_CAPACITY = 4


def stack_size(capacity: int) -> int:
    """Return the size of the memory for this many turning points and the present one."""
    return 2 * (capacity + 1)


class Stack(NamedTuple):
    """State of an operator with turning points: its place, the direction of its motion, and the size of its memory."""

    z: Annotated[float, Variable("length", "input")] = 0.0
    f: Annotated[float, Variable("force", "output")] = 0.0
    side: Annotated[
        float, Variable("1", "direction of the last move; 0 before the first", min=-1.0, max=1.0)
    ] = 0.0
    depth: Annotated[int, Variable("1", "number of stored turning points", min=0)] = 0
    lost: Annotated[int, Variable("1", "number of pairs forgotten for lack of room", min=0)] = 0


class Branch(NamedTuple):
    """The current curve: from the turning point (z, f), or the virgin curve for depth 0.

    It is valid between the inputs ``begin`` and ``end``, in the direction ``side``; ``depth`` counts the turning points
    under it, its start included.
    """

    z: float
    f: float
    side: float
    depth: int
    begin: float
    end: float


class StackMove(NamedTuple):
    """Result of a trial, applied by commit."""

    z: float
    f: float
    side: float
    depth: int


@kernel
def branch_at(stack, memory, u):
    """Return the branch with the input `u`, reached from ``stack.z`` in one move."""
    # By its sign bit: no processor can predict a branch on the direction of the input.
    side = math.copysign(1.0, u - stack.z) if u != stack.z else stack.side
    return branch_with(stack, memory, side, 0, u)


@kernel
def branch_with(stack, memory, side, place, value):
    """Return the branch with an input (`place` 0) or an output (half the memory) of this value, reached in one move."""
    # The point that a reversal would store is ready above the last point.
    depth = stack.depth + int(side * stack.side < 0.0)
    begin = stack.z
    if depth >= 2 and side * (value - memory[place + depth - 2]) >= 0.0:
        depth -= 2 * pairs_passed(memory, place + depth - 2, int(0.5 * depth), side, value)
        begin = memory[depth]
    if depth >= 2:
        return Branch(
            memory[depth - 1],
            memory[memory.size // 2 + depth - 1],
            side,
            depth,
            begin,
            memory[depth - 2],
        )
    if depth == 1:
        if side * (value + memory[place]) < 0.0:
            return Branch(memory[0], memory[memory.size // 2], side, 1, begin, -memory[0])
        begin = -memory[0]
    return Branch(0.0, 0.0, side, 0, begin, side * math.inf)


@kernel(inline=False)
def pairs_passed(memory, top, pairs, side, value):
    """Return how many pairs of points from `top` down the way to a value passes: found by halving, for they may be hundreds."""
    passed = 0
    while passed < pairs:
        middle = int(0.5 * (passed + pairs))
        if side * (value - memory[top - 2 * middle]) >= 0.0:
            passed = middle + 1
        else:
            pairs = middle
    return passed


@kernel
def branch_output(branch, u, q):
    """Return the output on a branch at the input `u`; `q` is the measure, by its Everett function."""
    if branch.depth == 0:
        return virgin_curve(u, q)
    return branch.f + 2.0 * branch.side * everett(max(u, branch.z), min(u, branch.z), q)


@kernel
def branch_slope(branch, u, q):
    """Return the derivative of `branch_output` with respect to the input."""
    if branch.depth == 0:
        return virgin_slope(u, q)
    alpha, beta = (u, branch.z) if branch.side > 0.0 else (branch.z, u)
    return 2.0 * everett_slope(alpha, beta, branch.side, q)


@kernel
def branch_point(branch, u, q):
    """Return `branch_output` and `branch_slope` at the input `u`: together they cost little more than the output."""
    if branch.depth == 0:
        return virgin_curve(u, q), virgin_slope(u, q)
    alpha, beta = (u, branch.z) if branch.side > 0.0 else (branch.z, u)
    return branch.f + 2.0 * branch.side * everett(alpha, beta, q), 2.0 * everett_slope(
        alpha, beta, branch.side, q
    )


@kernel
def stack_trial(stack, memory, u, tolerance, q):
    """Return the output at the input `u` and the move there.

    A return by at most `tolerance` is not a reversal: the operator does not move, and rounding stores no points.
    """
    if abs(u - stack.z) <= tolerance and (u - stack.z) * stack.side < 0.0:
        return stack.f, StackMove(stack.z, stack.f, stack.side, stack.depth)
    branch = branch_at(stack, memory, u)
    f = branch_output(branch, u, q)
    return f, StackMove(u, f, branch.side, branch.depth)


@kernel
def stack_commit(stack, memory, move):
    """Return the stack after a move; a reversal keeps the point where it turned."""
    capacity = memory.size // 2
    depth, lost = move.depth, stack.lost
    if depth >= capacity:
        memory[depth - 3], memory[capacity + depth - 3] = (
            memory[depth - 1],
            memory[capacity + depth - 1],
        )
        depth -= 2
        lost += 1
    memory[depth], memory[capacity + depth] = move.z, move.f
    return Stack(move.z, move.f, move.side, depth, lost)
