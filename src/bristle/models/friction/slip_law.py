r"""Slip laws: the share of the motion lost to slip, as a function of the force over its value in sliding.

With the ratio :math:`r = f \operatorname{sgn} v / G(v)` the contact deflects by :math:`\dot z = v\,[1 - \Phi(r)]`, and
in steady sliding :math:`r = 1`, :math:`\Phi = 1`:

* power law :math:`\Phi = r^n`, and :math:`-u\,|r|^n` while the motion unloads the contact, :math:`r < 0`;
* gate :math:`\Phi = 0` up to :math:`r = \rho`, :math:`\tfrac12\left[1 + \sin\left(\pi\,\frac{r - (1+\rho)/2}{1-\rho}
  \right)\right] r` up to 1, and :math:`r` beyond.

A power law slips a little at every force: it creeps under a ripple. Below :math:`\rho` the gate is closed and the
contact only deflects.

References
----------
.. [1] P. Dupont, V. Hayward, B. Armstrong, F. Altpeter, "Single state elastoplastic friction models", IEEE
   Transactions on Automatic Control 47(5), 2002. doi:10.1109/TAC.2002.1000274
.. [2] J. Swevers, F. Al-Bender, C. G. Ganseman, T. Prajogo, "An integrated friction model structure with improved
   presliding behavior for accurate friction compensation", IEEE Transactions on Automatic Control 45(4), 2000.
   doi:10.1109/9.847103
"""

from typing import NamedTuple

from bristle.core.kernel import kernel
from bristle.core.mathematics import (
    NEWTON_LAST,
    fitted_weight,
    newton_from,
    newton_next,
    power,
    smooth_step,
    smooth_step_point,
)

# Of a long step: the longest first part, over the length in which the contact turns; the growth of parts; their number.
FIRST, GROWTH, PARTS = 0.05, 1.3, 80
TOLERANCE = 1e-8  # of the ratio; the last step of Newton's method squares it


class SlipLaw(NamedTuple):
    """A slip law: a gate if `rho` is not negative, otherwise a power law."""

    rho: float
    exponent: float
    unloading: float


class Stretch(NamedTuple):
    """A step of a linear contact: the change of its ratio, mean over the step and at its end."""

    mean_change: float
    change: float


@kernel
def slip(r, law):
    r"""Return :math:`\Phi(r)`."""
    if law.rho < 0.0:
        return power(r, law.exponent) if r >= 0.0 else -law.unloading * power(-r, law.exponent)
    if r <= law.rho:
        return 0.0
    if r >= 1.0:
        return r
    return smooth_step((r - law.rho) * (1.0 / (1.0 - law.rho))) * r


@kernel
def slip_point(r, law):
    r"""Return :math:`\Phi(r)` and :math:`d\Phi/dr`: together they cost little more than :math:`\Phi` alone."""
    if law.rho < 0.0:
        share = 1.0 if law.exponent == 1.0 else power(abs(r), law.exponent - 1.0)
        if r < 0.0:
            share *= law.unloading
        return share * r, share * law.exponent
    if r <= law.rho:
        return 0.0, 0.0
    if r >= 1.0:
        return r, 1.0
    steepness = 1.0 / (1.0 - law.rho)
    opened, slope = smooth_step_point((r - law.rho) * steepness)
    return opened * r, opened + slope * (r * steepness)


@kernel
def slip_slope(r, law):
    r"""Return :math:`d\Phi/dr`."""
    return slip_point(r, law)[1]


@kernel
def slip_weight(r, r_far, law):
    r"""Return the slope of :math:`\Phi` that fits the mean of a step to its decay, 0 for a step without slip.

    `r` is the ratio at the start, `r_far` the ratio at the end of the step without feedback. The weight is
    continuous in `r_far`: a weight switched by a gate would make the force jump with the velocity.
    """
    end = max(r, min(r_far, 1.0))
    if law.rho < 0.0:
        return slip_slope(end, law)
    if end <= law.rho:
        return 0.0
    return min((end - law.rho) * (1.0 / (1.0 - law.rho)), 1.0)


@kernel
def stretch(r, kappa, law):
    r"""Return the `Stretch` of a linear contact over a displacement, :math:`dr/d\kappa = 1 - \Phi(r)`.

    `kappa` is the displacement over the deflection in sliding, not negative. Exponentially fitted: exact for the
    power law with exponent 1, otherwise of second order. A long step is made in parts.
    """
    if r + kappa <= law.rho:
        return Stretch(0.5 * kappa, kappa)
    slipped = slip(r, law)
    if abs(kappa * (1.0 - slipped)) <= FIRST:
        return stretch_once(r, kappa, slipped, law)
    return stretch_in_parts(r, kappa, law)


@kernel(inline=False)
def stretch_in_parts(r, kappa, law):
    """Return the `Stretch` of a long step: none of its parts moves the ratio by more than a length that grows.

    The last part takes the remainder, however short, so the result has no jump as the step grows.
    """
    left, total, longest, at = kappa, 0.0, FIRST, r
    if r < law.rho:
        # A closed gate needs no solution.
        part = law.rho - r
        total += part * (r + 0.5 * part)
        left -= part
        at = law.rho
    for k in range(PARTS):
        slipped = slip(at, law)
        free = abs(1.0 - slipped)
        part = left
        if left * free > longest and k < PARTS - 1:
            part = longest / free
        stretched = stretch_once(at, part, slipped, law)
        total += part * (at + stretched.mean_change)
        at += stretched.change
        left -= part
        longest *= GROWTH
        if left <= 0.0:
            break
    return Stretch(total / kappa - r, at - r)


@kernel
def stretch_once(r, kappa, slipped, law):
    """Return the `Stretch` of a short step, or of a part of a long step."""
    theta = fitted_weight(kappa * slip_weight(r, r + kappa, law))
    far = kappa * (1.0 - slipped)
    limit = (1.0 - r) / theta
    far = min(far, limit) if r < 1.0 else max(far, limit)
    way = 1.0 if far > 0.0 else -1.0
    search = newton_from(abs(far), abs(far))
    for _ in range(NEWTON_LAST):
        mean = r + theta * way * search.x
        slipped, slope = slip_point(mean, law)
        before = search.x
        residual = before - way * kappa * (1.0 - slipped)
        search = newton_next(search, residual, 1.0 + kappa * theta * slope)
        # The residual rises with a slope of at least 1: the distance to the root is at most the residual.
        if (
            abs(residual) <= TOLERANCE * search.x
            or abs(residual) <= 1e-3 * TOLERANCE
            or search.x == before
        ):
            break
    # Motion at constant velocity never passes sliding; a step long enough to pass it ends there.
    change = min(way * search.x, 1.0 - r) if r < 1.0 else max(way * search.x, 1.0 - r)
    return Stretch(theta * change, change)
