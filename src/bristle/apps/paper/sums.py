r"""Equations (13) to (15): the force of a Preisach operator summed over the extremes of its input.

With maxima :math:`M_1 > M_2 > \dots` and minima :math:`m_1 < m_2 < \dots` after saturation at :math:`m_0 = -X`, and
:math:`F` the integral of the measure over a *triangle*, the paper gives for rising and falling input

.. math::
    S &= \sum_{k=1}^{N} [F(M_k, m_{k-1}) - F(M_k, m_k)] + F(z, m_N) \\
    S &= \sum_{k=1}^{N-1} [F(M_k, m_{k-1}) - F(M_k, m_k)] + F(M_N, m_{N-1}) - F(M_N, z)

that is the integral over the relays that are up, trapezoid by trapezoid (13). It omits the values of the relays.
Friction is as far below zero at one saturation as above it at the other, hence

.. math:: f = S - \tfrac12 F(X, -X) \quad \text{with relays of 0 and 1,} \qquad
          f = 2S - F(X, -X) \quad \text{with relays of} \pm 1

For one operator the measure of relays of 0 and 1 is twice that of relays of :math:`\pm 1`, :math:`F = 2E` with the
Everett function :math:`E`: the first lacks one constant, :math:`E(X, -X)`, and the second also a factor.
"""

from collections.abc import Sequence

from bristle.core import Model, everett


def half_the_loop(operator: Model, reach: float) -> float:
    """Return half the height [N or N*m] of the loop between -reach and reach [m or rad]."""
    return everett(reach, -reach, operator.component.measure(operator.parameters))


def summed(operator: Model, path: Sequence[float]) -> float:
    """Return the force [N or N*m] from the corrected sums over the extremes."""
    return 2.0 * _over_extremes(operator, path) - half_the_loop(operator, -path[0])


def summed_as_printed(operator: Model, path: Sequence[float], *, lower: int = 0) -> float:
    """Return the force [N or N*m] from the sums as printed in the paper."""
    # The measure of a relay over its jump: a relay of -1 and 1 jumps by 2.
    return 2.0 / (1.0 - lower) * _over_extremes(operator, path)


def _over_extremes(operator: Model, path: Sequence[float]) -> float:
    """Return the integral [N or N*m] of the measure of relays of -1 and 1 over those in state up."""
    q = operator.component.measure(operator.parameters)
    minima = path[:-1:2]
    maxima = path[1:-1:2]
    now = path[-1]
    rising = len(minima) > len(maxima)
    closed = maxima
    if not rising:
        closed = maxima[:-1]
    total = sum(
        everett(M, before, q) - everett(M, after, q)
        for M, before, after in zip(closed, minima, minima[1:], strict=False)
    )
    if rising:
        return total + everett(now, minima[-1], q)
    return total + everett(maxima[-1], minima[-1], q) - everett(maxima[-1], now, q)
