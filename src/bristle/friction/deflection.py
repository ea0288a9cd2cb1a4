r"""The implicit step of a contact with memory: how far it deflects while the body moves.

.. math::
    D = \Delta x\left[1 - \Phi\left(\frac{\bar f \operatorname{sgn} v}{G(v)}\right)\right], \qquad
    \bar f = (1 - \vartheta)\,f_0 + \vartheta\,f_h(z_0 + D), \qquad
    \vartheta = \frac{1}{1 - e^{-\Lambda}} - \frac1\Lambda

with :math:`\Lambda = |\Delta x|\,k_t\,\Phi'/G`: exponentially fitted, of second order, and without ringing however
stiff the contact is in sliding. The right side falls with :math:`D`, so that there is one root, between 0 and the
step without feedback; Newton's method inside that bracket finds it in one or two iterations. Where a gate stays
closed over the whole step nothing is solved at all. The contact moves with the body while it is below the force in
sliding and against it above, so that memory follows the sign of the deflection, not that of the velocity. No motion at
constant velocity passes the force in sliding; a step so long that it would ends there.
"""

from typing import NamedTuple

from bristle.core.kernel import kernel
from bristle.core.mathematics import fitted_weight
from bristle.friction.slip_law import slip, slip_slope, slip_weight
from bristle.hysteresis.turning_points import Branch, StackMove, branch_at, branch_output, branch_slope

__all__ = ["Deflection", "deflect"]

ITERATIONS = 100
# Newton's method squares what is left: neither shows in the force.
RELATIVE = 1e-7
OF_SLIDING = 1e-9


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


@kernel
def deflect(stack, memory, dx, side, G, law, q, tolerance):
    """Return the `Deflection` while the body moves by `dx` [m or rad] in the direction `side`.

    `G` [N or N*m] is the force in sliding at this velocity, `law` the slip law, `q` the measure of the operator. A
    return by no more than `tolerance` [m or rad] is not remembered.
    """
    scale = side / G
    r = scale * stack.f
    far = dx * (1.0 - slip(r, law))
    if far == 0.0:
        return Deflection(stack.f, 0.0, StackMove(stack.z, stack.f, stack.side, stack.depth))
    branch = branch_at(stack, memory, stack.z + far)
    f = branch_output(branch, stack.z + far, q)
    weight = slip_weight(r, scale * f, law)
    change = far
    theta = 0.5
    if weight > 0.0:
        change, theta, branch = slipping(stack, memory, dx, far, weight, scale, law, q, branch)
        f = branch_output(branch, stack.z + change, q)
        if (side * f - G) * (r - 1.0) < 0.0:
            change, branch = reaching(stack, memory, change, side * G, q, branch)
            f = branch_output(branch, stack.z + change, q)
    mean = stack.f + theta * (f - stack.f)
    if abs(change) <= tolerance and change * stack.side < 0.0:
        return Deflection(mean, change, StackMove(stack.z, stack.f, stack.side, stack.depth))
    return Deflection(mean, change, StackMove(stack.z + change, f, branch.side, branch.depth))


@kernel
def slipping(stack, memory, dx, far, weight, scale, law, q, branch):
    """Return deflection, weight of its end in the mean, and branch, where the contact slips; `scale` is sgn(v)/G."""
    r = scale * stack.f
    way = 1.0 if far > 0.0 else -1.0
    travel = abs(dx * scale)
    k = branch_slope(onward(stack, memory, way), stack.z, q)
    theta = fitted_weight(travel * k * weight)
    near = 0.0
    # The first step of Newton's method from the start, or from the far end while a gate is closed at the start.
    change = far / (1.0 + travel * theta * k * slip_slope(r, law))
    for _ in range(ITERATIONS):
        u = stack.z + change
        if way * (u - branch.begin) < 0.0 or way * (u - branch.end) >= 0.0:
            branch = branch_at(stack, memory, u)
        mean = r + theta * (scale * branch_output(branch, u, q) - r)
        k = branch_slope(branch, u, q)
        residual = change - dx * (1.0 - slip(mean, law))
        if way * residual > 0.0:
            far = change
        else:
            near = change
        step = residual / (1.0 + travel * theta * k * slip_slope(mean, law))
        change -= step
        if abs(step) <= RELATIVE * abs(change) or k * abs(scale * step) <= OF_SLIDING:
            break
        if (change - near) * (change - far) >= 0.0:
            change = 0.5 * (near + far)
    u = stack.z + change
    if way * (u - branch.begin) < 0.0 or way * (u - branch.end) >= 0.0:
        branch = branch_at(stack, memory, u)
    return change, theta, branch


@kernel(inline=False)
def reaching(stack, memory, far, level, q, branch):
    """Return the deflection, short of `far`, at which the force reaches `level` [N or N*m], and the branch there."""
    way = 1.0 if far > 0.0 else -1.0
    near = 0.0
    change = far
    for _ in range(ITERATIONS):
        u = stack.z + change
        if way * (u - branch.begin) < 0.0 or way * (u - branch.end) >= 0.0:
            branch = branch_at(stack, memory, u)
        residual = branch_output(branch, u, q) - level
        if way * residual > 0.0:
            far = change
        else:
            near = change
        slope = branch_slope(branch, u, q)
        change -= residual / slope if slope > 0.0 else 0.0
        if abs(residual) <= OF_SLIDING * abs(level):
            break
        if way * (change - near) <= 0.0 or way * (change - far) >= 0.0:
            change = 0.5 * (near + far)
    return change, branch_at(stack, memory, stack.z + change)
