r"""The implicit step of a contact with memory: how far it deflects while the body moves.

.. math::
    D = \Delta x\left[1 - \Phi\left(\frac{\bar f \operatorname{sgn} v}{G(v)}\right)\right], \qquad
    \bar f = (1 - \vartheta)\,f_0 + \vartheta\,f_h(z_0 + D), \qquad
    \vartheta = \frac{1}{1 - e^{-\Lambda}} - \frac1\Lambda

with :math:`\Lambda = |\Delta x|\,k\,\Phi'/G` and :math:`k` the slope of a chord of the curve: exponentially fitted, of
second order, and without ringing however stiff the contact is in sliding. The right side falls with :math:`D`, so that
there is one root, between 0 and the step without feedback; Newton's method finds it, and the middle of that interval
where a step of it does not halve the last. A long step is made in parts that grow. Where a gate stays closed over a
whole part nothing is solved at all. The contact moves with the body while it is below the force in
sliding and against it above, so that memory follows the sign of the deflection, not that of the velocity. No motion at
constant velocity passes the force in sliding; a step so long that it would ends there.
"""

import math
from typing import NamedTuple

from bristle.core.kernel import kernel
from bristle.core.mathematics import NEWTON_LAST, fitted_weight, newton_from, newton_next
from bristle.friction.slip_law import FIRST, GROWTH, PARTS, slip_point, slip_weight
from bristle.hysteresis.turning_points import Branch, StackMove, branch_at, branch_output, branch_point, branch_slope

__all__ = ["TOLERANCE", "Deflection", "deflect", "mean_output"]

# Newton's method squares what is left: neither shows in the force.
RELATIVE = 1e-7
OF_SLIDING = 1e-9
TOLERANCE = 1e-12
CHORD = 0.125  # of the step without feedback
SHORTEST = 1e-280  # chord, of the length over which the operator turns: one over it is a number


class Deflection(NamedTuple):
    """A step of the contact: mean hysteretic force [N or N*m], deflection [m or rad], and what to commit."""

    mean: float
    change: float
    move: StackMove


@kernel
def onward(stack, memory, side):
    """Return the branch that a small motion in the direction `side` follows."""
    depth = stack.depth + int(side * stack.side < 0.0)
    if depth == 0:
        return Branch(0.0, 0.0, side, 0, stack.z, stack.z)
    return Branch(memory[depth - 1], memory[memory.size // 2 + depth - 1], side, depth, stack.z, stack.z)


class Start(NamedTuple):
    """Where a part of a step begins: deflection [m or rad], force [N or N*m], and the slope of the slip there."""

    z: float
    f: float
    steepness: float


class Stroke(NamedTuple):
    """A part of a step: mean hysteretic force [N or N*m], deflection [m or rad], force and branch at its end."""

    mean: float
    z: float
    f: float
    branch: Branch


@kernel
def deflect(stack, memory, dx, side, G, law, q, scale, smallest):
    """Return the `Deflection` while the body moves by `dx` [m or rad] in the direction `side`.

    `G` [N or N*m] is the force in sliding at this velocity, `law` the slip law, `q` the measure of the operator, and
    `scale` [m or rad] the length over which it turns, f_p/s. A return by no more than `smallest` [m or rad] is not
    remembered.
    """
    inverse = side / G
    slipped, steepness = slip_point(inverse * stack.f, law)
    free = 1.0 - slipped
    far = dx * free
    if far == 0.0:
        return Deflection(stack.f, 0.0, StackMove(stack.z, stack.f, stack.side, stack.depth))
    if abs(far) <= FIRST * scale:
        branch = onward(stack, memory, side if free > 0.0 else -side)
        done = stroke(stack, memory, Start(stack.z, stack.f, steepness), dx, far, inverse, law, q, scale, branch)
    else:
        done = in_parts(stack, memory, dx, slipped, steepness, inverse, law, q, scale)
    change = done.z - stack.z
    if change == 0.0 or (abs(change) <= smallest and change * stack.side < 0.0):
        return Deflection(done.mean, change, StackMove(stack.z, stack.f, stack.side, stack.depth))
    return Deflection(done.mean, change, StackMove(done.z, done.f, done.branch.side, done.branch.depth))


@kernel(inline=False)
def in_parts(stack, memory, dx, slipped, steepness, inverse, law, q, scale):
    """Return the `Stroke` of a long step: none of its parts deflects by more than a length that grows.

    The last one takes what is left, however little: a step that grows goes through no jump. `slipped` and `steepness`
    are the slip and its slope where the step begins.
    """
    z, f, left, total, longest = stack.z, stack.f, dx, 0.0, FIRST * scale
    branch = onward(stack, memory, math.copysign(1.0, dx))
    for k in range(PARTS):
        free = 1.0 - slipped
        part = left
        if abs(left * free) > longest and k < PARTS - 1:
            part = math.copysign(longest / abs(free), left)
        if part * free == 0.0:
            total += f * part
        else:
            start = Start(z, f, steepness)
            stroked = stroke(stack, memory, start, part, part * free, inverse, law, q, scale, branch)
            total += stroked.mean * part
            z, f, branch = stroked.z, stroked.f, stroked.branch
        left -= part
        longest *= GROWTH
        if left == 0.0:
            break
        slipped, steepness = slip_point(inverse * f, law)
    return Stroke(total / dx, z, f, branch)


@kernel
def mean_output(stack, memory, u, f, q, scale):
    """Return the mean output [N or N*m] on the way to the input `u` [m or rad], where it is `f`.

    By trapezia; a long way in parts, as `deflect`. `scale` is the length over which the operator turns.
    """
    if abs(u - stack.z) <= FIRST * scale:
        return 0.5 * (stack.f + f)
    z, before, total, longest = stack.z, stack.f, 0.0, math.copysign(FIRST * scale, u - stack.z)
    for k in range(PARTS):
        if abs(u - z) <= abs(longest) or k == PARTS - 1:
            break
        after = branch_output(branch_at(stack, memory, z + longest), z + longest, q)
        total += 0.5 * (before + after) * longest
        z, before = z + longest, after
        longest *= GROWTH
    return (total + 0.5 * (before + f) * (u - z)) / (u - stack.z)


@kernel
def stroke(stack, memory, start, dx, far, inverse, law, q, scale, branch):
    """Return the `Stroke` from the `Start`; it would be `far` [m or rad] without feedback.

    `branch` is the one that it begins on.
    """
    z, f = start.z, start.f
    r = inverse * f
    if law.rho < 0.0 and law.exponent == 1.0 and law.unloading == 1.0:
        # The slope of the slip is the same wherever the step ends: where it would without feedback need not be known.
        after, weight = f, 1.0
    else:
        branch = branch_at(stack, memory, z + far)
        after = branch_output(branch, z + far, q)
        weight = slip_weight(r, inverse * after, law)
    if weight > 0.0:
        return slipping(stack, memory, start, dx, far, weight, inverse, law, q, scale, branch)
    return Stroke(f + 0.5 * (after - f), z + far, after, branch)


@kernel
def slipping(stack, memory, start, dx, far, weight, inverse, law, q, scale, branch):
    """Return the `Stroke` where the contact slips."""
    z, f = start.z, start.f
    r = inverse * f
    way = 1.0 if far > 0.0 else -1.0
    travel, reach = abs(dx * inverse), abs(far)
    # A chord of the curve that the step runs on has no jump where a loop is wiped out; the tangent at its start has.
    ahead = z + CHORD * far
    if is_beside(branch, way, ahead):
        branch = branch_at(stack, memory, ahead)
    k = max(way * (branch_output(branch, ahead, q) - f) * (1.0 / max(CHORD * reach, SHORTEST * scale)), 0.0)
    theta = fitted_weight(travel * k * weight)
    # The first step of Newton's method from the start, or from the far end while a gate is closed at the start: it
    # takes the tangent, which waits for nothing.
    feedback = 0.5 * travel * max(branch_slope(branch, z, q), 0.0) * start.steepness
    search = newton_from(reach, reach / (1.0 + feedback))
    steepest = k
    u, after = z, f
    for _ in range(NEWTON_LAST):
        u = z + way * search.x
        if is_beside(branch, way, u):
            branch = branch_at(stack, memory, u)
        after, k = branch_point(branch, u, q)
        mean = r + theta * (inverse * after - r)
        steepest = max(steepest, k)
        slipped, slope = slip_point(mean, law)
        residual = search.x - way * dx * (1.0 - slipped)
        search = newton_next(search, residual, 1.0 + travel * theta * k * slope)
        # The residual rises with a slope of 1 at least: the root is no farther away than it is large.
        if abs(residual) <= RELATIVE * search.x or steepest * abs(inverse * residual) <= OF_SLIDING:
            break
    last = z + way * search.x
    if is_beside(branch, way, last) or k * abs(inverse * (last - u)) > OF_SLIDING:
        branch = branch_at(stack, memory, last)
        after = branch_output(branch, last, q)
    else:
        # So short a step runs along the tangent: what it leaves out is of second order.
        after += k * (last - u)
    change = way * search.x
    if (inverse * after - 1.0) * (r - 1.0) < 0.0:
        change, branch = reaching(stack, memory, z, change, 1.0 / inverse, q, branch)
        after = branch_output(branch, z + change, q)
    return Stroke(f + theta * (after - f), z + change, after, branch)


@kernel
def is_beside(branch, way, u):
    """Return whether the deflection `u`, ahead in the direction `way`, lies on another branch."""
    return way * (u - branch.begin) < 0.0 or way * (u - branch.end) >= 0.0


@kernel(inline=False)
def reaching(stack, memory, z, far, level, q, branch):
    """Return the deflection, short of `far`, at which the force reaches `level` [N or N*m], and the branch there."""
    way = 1.0 if far > 0.0 else -1.0
    search = newton_from(abs(far), abs(far))
    for _ in range(NEWTON_LAST):
        u = z + way * search.x
        if is_beside(branch, way, u):
            branch = branch_at(stack, memory, u)
        residual = way * (branch_output(branch, u, q) - level)
        search = newton_next(search, residual, branch_slope(branch, u, q))
        if abs(residual) <= OF_SLIDING * abs(level):
            break
    return way * search.x, branch_at(stack, memory, z + way * search.x)
