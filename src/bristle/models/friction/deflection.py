r"""The implicit step of a contact with memory: its deflection while the body moves.

.. math::
    D = \Delta x\left[1 - \Phi\left(\frac{\bar f \operatorname{sgn} v}{G(v)}\right)\right], \qquad
    \bar f = (1 - \vartheta)\,f_0 + \vartheta\,f_h(z_0 + D), \qquad
    \vartheta = \frac{1}{1 - e^{-\Lambda}} - \frac1\Lambda

with :math:`\Lambda = |\Delta x|\,k\,\Phi'/G` and :math:`k` the slope of a chord of the curve. The step is exponentially
fitted, of second order, and free of ringing for any stiffness of the contact in sliding. The right side falls with
:math:`D`, so there is a single root, between 0 and the step without feedback. Newton's method finds it, with bisection
whenever a step does not halve the last one. A long step is made in parts that grow. A part with a closed gate needs no
solution. The contact moves with the body while its force is below that of sliding, and against the body above it, so
memory follows the sign of the deflection, not that of the velocity. Motion at constant velocity never passes the force
in sliding; a step long enough to pass it ends there.
"""

import math
from typing import NamedTuple

from bristle.core.kernel import kernel
from bristle.core.mathematics import NEWTON_LAST, fitted_weight, newton_from, newton_next
from bristle.models.friction.slip_law import FIRST, GROWTH, PARTS, slip_point, slip_weight
from bristle.models.hysteresis.turning_points import (
    Branch,
    StackMove,
    branch_at,
    branch_output,
    branch_point,
    branch_slope,
    branch_with,
)

# Newton's method squares the error: neither shows in the force.
RELATIVE = 1e-7
OF_SLIDING = 1e-9
ALONG_TANGENT = 1e-7  # of the force in sliding: a tangent over so short a way has the square of this as its error
TOLERANCE = 1e-12
CHORD = 0.125  # of the step without feedback
SHORTEST = (
    1e-280  # chord, over the length over which the operator turns: keeps the slope a finite number
)


class Deflection(NamedTuple):
    """A step of the contact: mean hysteretic force [N or N*m], deflection [m or rad], and the move."""

    mean: float
    change: float
    move: StackMove


@kernel
def onward(stack, memory, side):
    """Return the branch that a small motion in the direction `side` follows."""
    depth = stack.depth + int(side * stack.side < 0.0)
    if depth == 0:
        return Branch(0.0, 0.0, side, 0, stack.z, stack.z)
    return Branch(
        memory[depth - 1], memory[memory.size // 2 + depth - 1], side, depth, stack.z, stack.z
    )


class Start(NamedTuple):
    """Start of a part of a step: deflection [m or rad], force [N or N*m], and the slope of the slip there."""

    z: float
    f: float
    steepness: float


class Stroke(NamedTuple):
    """A part of a step: mean hysteretic force [N or N*m], deflection [m or rad], force and branch at its end."""

    mean: float
    z: float
    f: float
    branch: Branch


class Run(NamedTuple):
    """A long step so far: its place, the remaining length, the integral of the force, and the longest next part."""

    z: float
    f: float
    branch: Branch
    left: float
    total: float
    part: float


class Reached(NamedTuple):
    """Point where a part of a step reaches sliding: its deflection [m or rad], the force [N or N*m], and the branch."""

    change: float
    f: float
    branch: Branch


@kernel
def deflect(stack, memory, dx, side, G, law, q, scale, smallest):
    """Return the `Deflection` while the body moves by `dx` [m or rad] in the direction `side`.

    `G` [N or N*m] is the force in sliding at this velocity, `law` the slip law, `q` the measure of the operator, and
    `scale` [m or rad] the length over which it turns, f_p/s. A reversal by at most `smallest` [m or rad] is not
    stored.
    """
    inverse = side / G
    slipped, steepness = slip_point(inverse * stack.f, law)
    far = dx * (1.0 - slipped)
    unmoved = StackMove(stack.z, stack.f, stack.side, stack.depth)
    if far == 0.0:
        return Deflection(stack.f, 0.0, unmoved)
    if abs(far) <= FIRST * scale:
        branch = branch_at(stack, memory, stack.z + far)
        done = stroke(
            stack,
            memory,
            Start(stack.z, stack.f, steepness),
            dx,
            far,
            inverse,
            law,
            q,
            scale,
            branch,
        )
    else:
        done = in_parts(stack, memory, dx, inverse, law, q, scale)
    change = done.z - stack.z
    if change == 0.0 or (abs(change) <= smallest and change * stack.side < 0.0):
        return Deflection(done.mean, change, unmoved)
    return Deflection(
        done.mean, change, StackMove(done.z, done.f, done.branch.side, done.branch.depth)
    )


@kernel(inline=False)
def in_parts(stack, memory, dx, inverse, law, q, scale):
    """Return the `Stroke` of a long step: none of its parts deflects by more than a length that grows.

    The last part takes the remainder, however short, so the result has no jump as the step grows.
    """
    first = math.copysign(FIRST * scale, dx)
    run = Run(stack.z, stack.f, branch_at(stack, memory, stack.z + first), dx, 0.0, first)
    if law.rho >= 0.0 and inverse * stack.f <= law.rho:
        run = closed_run(stack, memory, run, inverse, law, q)
    z, f, branch, left, total = run.z, run.f, run.branch, run.left, run.total
    longest = abs(run.part)
    for k in range(PARTS):
        if left == 0.0:
            break
        slipped, steepness = slip_point(inverse * f, law)
        free = 1.0 - slipped
        part = left
        if abs(left * free) > longest and k < PARTS - 1:
            part = math.copysign(longest / free, dx)
        far = part * free
        if far == 0.0:
            total += f * part
        else:
            if is_beside(branch, math.copysign(1.0, far), z + far):
                branch = branch_at(stack, memory, z + far)
            start = Start(z, f, steepness)
            stroked = stroke(stack, memory, start, part, far, inverse, law, q, scale, branch)
            total += stroked.mean * part
            z, f, branch = stroked.z, stroked.f, stroked.branch
        left -= part
        longest *= GROWTH
    return Stroke(total / dx, z, f, branch)


@kernel
def closed_run(stack, memory, run, inverse, law, q):
    """Return the `Run` up to the part in which the gate opens: before it the contact does not slip."""
    z, f, branch, left, total, part = run
    way = math.copysign(1.0, left)
    for _ in range(PARTS):
        if way * (left - part) <= 0.0:
            part = left
        u = z + part
        if way * (u - branch.end) >= 0.0:
            branch = branch_at(stack, memory, u)
        end = branch_output(branch, u, q)
        if inverse * end > law.rho:
            break
        total += (f + 0.5 * (end - f)) * part
        z, f = u, end
        left -= part
        if left == 0.0:
            break
        part *= GROWTH
    return Run(z, f, branch, left, total, part)


@kernel
def mean_output(stack, memory, u, f, q, scale):
    """Return the mean output [N or N*m] on the way to the input `u` [m or rad], where the output is `f`.

    By the trapezoidal rule; a long way in parts, as in `deflect`. `scale` is the length over which the operator turns.
    """
    if abs(u - stack.z) <= FIRST * scale:
        return 0.5 * (stack.f + f)
    z, before, total, longest = stack.z, stack.f, 0.0, math.copysign(FIRST * scale, u - stack.z)
    branch = branch_at(stack, memory, z + longest)
    for k in range(PARTS):
        if abs(u - z) <= abs(longest) or k == PARTS - 1:
            break
        if is_beside(branch, branch.side, z + longest):
            branch = branch_at(stack, memory, z + longest)
        after = branch_output(branch, z + longest, q)
        total += 0.5 * (before + after) * longest
        z, before = z + longest, after
        longest *= GROWTH
    return (total + 0.5 * (before + f) * (u - z)) / (u - stack.z)


@kernel
def stroke(stack, memory, start, dx, far, inverse, law, q, scale, branch):
    """Return the `Stroke` from the `Start`; without feedback it would be `far` [m or rad] long and end on `branch`."""
    z, f = start.z, start.f
    if law.rho < 0.0:
        # A power law slips at every force: the end of the step without feedback is not needed.
        return slipping(stack, memory, start, dx, far, f, inverse, law, q, scale, branch)
    after = branch_output(branch, z + far, q)
    if slip_weight(inverse * f, inverse * after, law) > 0.0:
        return slipping(stack, memory, start, dx, far, after, inverse, law, q, scale, branch)
    return Stroke(f + 0.5 * (after - f), z + far, after, branch)


@kernel
def slipping(stack, memory, start, dx, far, after, inverse, law, q, scale, branch):
    """Return the `Stroke` of a slipping contact.

    Without feedback it would end on `branch`, and pass a gate at the force `after`.
    """
    z, f = start.z, start.f
    r = inverse * f
    way = math.copysign(1.0, far)
    travel, reach = abs(dx * inverse), abs(far)
    # The chord of the curve has no jump where a loop is wiped out; the tangent at the start has a jump.
    ahead = z + CHORD * far
    near = branch
    if is_beside(near, way, ahead):
        near = branch_at(stack, memory, ahead)
    chord = max(
        way * (branch_output(near, ahead, q) - f) * (1.0 / max(CHORD * reach, SHORTEST * scale)),
        0.0,
    )
    r_far = r + inverse * chord * far if law.rho < 0.0 else inverse * after
    theta = fitted_weight(travel * chord * slip_weight(r, r_far, law))
    if (
        start.steepness == 0.0
        and inverse * after <= 1.0
        and r + theta * (inverse * after - r) <= law.rho
    ):
        # The gate opens only at the end: it is closed for the mean of the step.
        return Stroke(f + theta * (after - f), z + far, after, branch)
    if law.rho < 0.0:
        # The first step of Newton's method takes the tangent, which is known already.
        share = 1.0 / (1.0 + 0.5 * travel * max(branch_slope(near, z, q), 0.0) * start.steepness)
    else:
        share = share_left(r, start.steepness, far / dx, travel * theta * chord)
    search = newton_from(reach, reach * share)
    x = search.x
    u = z + way * x
    if is_beside(branch, way, u):
        branch = branch_at(stack, memory, u)
    after, k = branch_point(branch, u, q)
    steepest = chord
    for _ in range(NEWTON_LAST):
        mean = r + theta * (inverse * after - r)
        steepest = max(steepest, k)
        slipped, slope = slip_point(mean, law)
        residual, rise = x - way * dx * (1.0 - slipped), 1.0 + travel * theta * k * slope
        # The residual rises with a slope of at least 1: the distance to the root is at most the residual.
        if abs(residual) <= RELATIVE * x or steepest * abs(inverse * residual) <= OF_SLIDING:
            x -= residual / max(rise, 1.0)
            break
        if residual < 0.0 and (inverse * after - 1.0) * (r - 1.0) < 0.0:
            break
        search = newton_next(search, residual, rise)
        before = u
        x = search.x
        u = z + way * x
        if u == before:
            break
        if is_beside(branch, way, u):
            branch = branch_at(stack, memory, u)
        after, k = branch_point(branch, u, q)
    change = way * x
    last = z + change
    if is_beside(branch, way, last) or k * abs(inverse * (last - u)) > ALONG_TANGENT:
        branch = branch_at(stack, memory, last)
        after = branch_output(branch, last, q)
    else:
        # So short a step runs along the tangent: its error is of second order.
        after += k * (last - u)
    if (inverse * after - 1.0) * (r - 1.0) < 0.0:
        change, after, branch = reaching(stack, memory, z, change, 1.0 / inverse, q)
    return Stroke(f + theta * (after - f), z + change, after, branch)


@kernel
def share_left(r, steepness, free, bend):
    """Return the approximate share of a step from the ratio `r` that remains with feedback.

    `free` is the share that does not slip at the start, `steepness` the slope of the slip there, and `bend` the change
    of the mean ratio over the whole step. Between `r` and sliding the slip is approximated by a parabola.
    """
    if steepness == 0.0:
        return 1.0
    linear = 1.0 + bend * steepness
    if r >= 1.0:
        return 1.0 / linear
    scaled = bend / (1.0 - r)
    curved = scaled * scaled * free * (free - steepness * (1.0 - r))
    return min(2.0 / (linear + math.sqrt(max(linear * linear + 4.0 * curved, 0.0))), 1.0)


@kernel
def is_beside(branch, way, u):
    """Return whether the deflection `u`, ahead in the direction `way`, lies on another branch."""
    return way * (u - branch.begin) < 0.0 or way * (u - branch.end) >= 0.0


@kernel(inline=False)
def reaching(stack, memory, z, far, level, q):
    """Return the `Reached` between `z` and `far` beyond it, where the force equals `level` [N or N*m].

    The memory names the branch. On a branch the slope falls, so Newton's method comes from the start without passing.
    """
    way = math.copysign(1.0, far)
    side = math.copysign(1.0, z + far - stack.z)
    branch = branch_with(stack, memory, side, memory.size // 2, level)
    search = newton_from(abs(far), max(side * (branch.begin - z), 0.0))
    for _ in range(NEWTON_LAST):
        before = search.x
        after, k = branch_point(branch, z + way * before, q)
        residual = way * (after - level)
        search = newton_next(search, residual, k)
        # The last step runs along the tangent: its error is of second order.
        if abs(residual) <= ALONG_TANGENT * abs(level) or search.x == before:
            break
    return Reached(way * search.x, level, branch)
