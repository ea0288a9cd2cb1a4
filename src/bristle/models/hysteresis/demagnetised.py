r"""The first branch of a demagnetised operator, whose turning points shrank evenly to zero, from its Everett function.

.. math:: f(u) = f_0 + \operatorname{sgn}(u)\, E(|u|, -|u|)
"""

from bristle.core.dispatch import everett, everett_slope
from bristle.core.kernel import kernel
from bristle.core.mathematics import direction


@kernel
def virgin(u, q):
    """Return the output [N or N*m] at the first input `u` [m or rad] of a demagnetised operator."""
    return q.offset + direction(u) * everett(abs(u), -abs(u), q)


@kernel
def virgin_slope(u, q):
    """Return the derivative of `virgin` [N/m or N*m/rad]."""
    z = abs(u)
    return everett_slope(z, -z, 1.0, q) + everett_slope(z, -z, -1.0, q)
