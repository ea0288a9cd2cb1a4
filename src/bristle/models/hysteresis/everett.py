r"""Everett functions in closed form: the measure of a Preisach operator without a table.

The Everett function :math:`E(\alpha, \beta)` is the integral of the Preisach measure :math:`\mu` over the triangle
:math:`\beta \le \beta' \le \alpha' \le \alpha`: half of the change of the output when the input turns at
:math:`\beta` and rises to :math:`\alpha`. With the stiffness :math:`s`, the saturation :math:`f_p` and
:math:`d = \alpha - \beta`:

========================= ==========================================================================================
``dahl_masing``           :math:`f_p\,g(sd/2f_p)`, :math:`g(x) = 1 - [1 + (i-1)x]^{-1/(i-1)}`: the Dahl model of
                          exponent :math:`i` from its virgin state, doubled by Masing's rule. :math:`i = 2` is
                          :math:`x/(1+x)`, :math:`i \to 1` is :math:`1 - e^{-x}`; :math:`i < 1` saturates at a
                          finite travel.
``tip_masing``            :math:`f_r(d/2)`: Masing's rule on the locus of the loop tips below.
``reformed_dahl_exact``   :math:`\tfrac12\,q s d/(q + s d)`, :math:`q = f_p + f_r(\max(\alpha, -\beta))`: gives every
                          symmetric loop of the reformed Dahl model, equations (16) and (17), exactly.
``exp_masing``            :math:`f_p\,(1 - e^{-sd/2f_p})`.
========================= ==========================================================================================

with the tip of the symmetric loop of amplitude :math:`x_r`,
:math:`f_r = 2 f_p k/(\sqrt{1 + 6k + k^2} + 1 + k)`, :math:`k = s x_r/f_p`. The Masing kernels depend on :math:`d` only:
they are Prandtl-Ishlinskii operators, with congruent loops everywhere. A friction operator dissipates because its
measure is negative off the diagonal :math:`\alpha = \beta` and has a positive line mass on it, the stiffness.

References
----------
.. [1] D. H. Everett, "A general approach to hysteresis. Part 4", Trans. Faraday Society 51, 1955.
   doi:10.1039/TF9555101551
"""

import math
from typing import NamedTuple

from bristle.core.dispatch import register
from bristle.core.kernel import kernel
from bristle.core.mathematics import exp, expm1, log1p

KERNELS = ("dahl_masing", "tip_masing", "reformed_dahl_exact", "exp_masing")
DAHL_MASING, TIP_MASING, REFORMED_DAHL_EXACT, EXP_MASING = range(4)
# Every curve has saturated here, and the square of this number is still finite.
FAR = 1e150


class ClosedForm(NamedTuple):
    """A measure by the closed form of its Everett function."""

    kernel: int  # place in KERNELS
    s: float  # stiffness of a fresh branch [N/m or N*m/rad]
    f_p: float  # saturation [N or N*m]
    exponent: float = 2.0  # of dahl_masing


@kernel
def loop_tip(k):
    """Return the tip of the symmetric loop of amplitude `k`, both as multiples of f_p/s and f_p."""
    near = min(k, FAR)
    return 2.0 * near / (math.sqrt(1.0 + near * (6.0 + near)) + 1.0 + near)


@kernel
def loop_tip_slope(k):
    """Return the derivative of `loop_tip`."""
    near = min(k, FAR)
    root = math.sqrt(1.0 + near * (6.0 + near))
    tip = 2.0 * near / (root + 1.0 + near)
    return (1.0 - tip) / root


@kernel
def loading_curve(x, shape, exponent):
    """Return the virgin force over f_p of a Masing kernel at the travel x >= 0 over f_p/s."""
    if shape == DAHL_MASING and exponent == 2.0:
        return x * (1.0 / (1.0 + x))  # the slope needs the same quotient
    return other_curve(x, shape, exponent)


@kernel(inline=False)
def other_curve(x, shape, exponent):
    """Return `loading_curve` of the other kernels; separate, or a step is too long for the compiler to specialise."""
    if shape == TIP_MASING:
        return loop_tip(x)
    if shape == EXP_MASING or abs(exponent - 1.0) < 1e-12:
        return -expm1(-x)
    m = exponent - 1.0
    if m * x <= -1.0:
        return 1.0
    return -expm1(-log1p(m * x) / m)


@kernel
def loading_slope(x, shape, exponent):
    """Return the derivative of `loading_curve`."""
    if shape == DAHL_MASING and exponent == 2.0:
        share = 1.0 / (1.0 + x)
        return share * share
    return other_slope(x, shape, exponent)


@kernel(inline=False)
def other_slope(x, shape, exponent):
    """Return `loading_slope` of the other kernels."""
    if shape == TIP_MASING:
        return loop_tip_slope(x)
    if shape == EXP_MASING or abs(exponent - 1.0) < 1e-12:
        return exp(-x)
    m = exponent - 1.0
    if m * x <= -1.0:
        return 0.0
    return exp(-log1p(m * x) * exponent / m)


@kernel
def loading_inverse(y, shape, exponent):
    """Return the travel over f_p/s at which `loading_curve` reaches y, 0 <= y < 1; NaN beyond."""
    if y >= 1.0:
        return math.nan
    if shape == TIP_MASING:
        return y * (1.0 + y) / (1.0 - y)
    if shape == EXP_MASING or abs(exponent - 1.0) < 1e-12:
        return -log1p(-y)
    if exponent == 2.0:
        return y / (1.0 - y)
    m = exponent - 1.0
    return expm1(-m * log1p(-y)) / m


@kernel
def value(alpha, beta, q):
    """Return E(alpha, beta) [N or N*m] in closed form, alpha >= beta [m or rad]."""
    if q.kernel == REFORMED_DAHL_EXACT:
        return reformed_value(alpha, beta, q)
    return q.f_p * loading_curve((alpha - beta) * (0.5 * q.s / q.f_p), q.kernel, q.exponent)


@kernel(inline=False)
def reformed_value(alpha, beta, q):
    """Return `value` of `reformed_dahl_exact`."""
    x = q.s * (alpha - beta)
    reach = q.f_p * (1.0 + loop_tip(q.s * max(alpha, -beta) / q.f_p))
    return 0.5 * reach * (x / (reach + x))


@kernel
def slope(alpha, beta, side, q):
    """Return the derivative of E with respect to its moving end [N/m or N*m/rad]: alpha for side > 0, else -beta."""
    if q.kernel == REFORMED_DAHL_EXACT:
        return reformed_slope(alpha, beta, side, q)
    return 0.5 * q.s * loading_slope((alpha - beta) * (0.5 * q.s / q.f_p), q.kernel, q.exponent)


@kernel(inline=False)
def reformed_slope(alpha, beta, side, q):
    """Return `slope` of `reformed_dahl_exact`."""
    x = q.s * (alpha - beta)
    moving, fixed = (alpha, -beta) if side > 0.0 else (-beta, alpha)
    k = q.s * max(alpha, -beta) / q.f_p
    reach = q.f_p * (1.0 + loop_tip(k))
    share = reach / (reach + x)
    steep = 0.5 * q.s * share * share
    if moving <= fixed:
        return steep
    part = x / (reach + x)
    return steep + 0.5 * q.s * part * part * loop_tip_slope(k)


@kernel
def virgin(u, q):
    """Return the output [N or N*m] at the first input `u` [m or rad] of a demagnetised operator."""
    k = q.s * abs(u) / q.f_p
    shape = TIP_MASING if q.kernel == REFORMED_DAHL_EXACT else q.kernel
    return math.copysign(q.f_p * loading_curve(k, shape, q.exponent), u)


@kernel
def virgin_slope(u, q):
    """Return the derivative of `virgin` [N/m or N*m/rad]."""
    k = q.s * abs(u) / q.f_p
    shape = TIP_MASING if q.kernel == REFORMED_DAHL_EXACT else q.kernel
    return q.s * loading_slope(k, shape, q.exponent)


register(
    "everett",
    ClosedForm,
    {"value": value, "slope": slope, "virgin": virgin, "virgin_slope": virgin_slope},
)
