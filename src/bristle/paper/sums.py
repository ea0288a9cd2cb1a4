r"""Equations (14) and (15): the force of a Preisach operator summed over the extremes of its input.

With maxima :math:`M_1 > M_2 > \dots` and minima :math:`m_1 < m_2 < \dots` after saturation at :math:`m_0 = -X`, relays
of :math:`\pm 1` and the Everett function :math:`E` of a *triangle*, while the input rises and falls

.. math::
    f &= -E(X, -X) + 2\sum_{k=1}^{N} [E(M_k, m_{k-1}) - E(M_k, m_k)] + 2E(z, m_N) \\
    f &= -E(X, -X) + 2\sum_{k=1}^{N-1} [E(M_k, m_{k-1}) - E(M_k, m_k)] + 2[E(M_N, m_{N-1}) - E(M_N, z)]

The paper prints them without the factor 2 and without the offset.
"""

from __future__ import annotations

from collections.abc import Sequence

from bristle.core.contracts import Model
from bristle.core.dispatch import everett

__all__ = ["summed"]


def summed(operator: Model, path: Sequence[float], *, as_printed: bool = False) -> float:
    """Return the force [N or N*m] by the sums over the extremes.

    Parameters
    ----------
    operator : Model
        An operator with an Everett function.
    path : sequence of float
        Saturation at -X first, then extremes each inside the ones before it, the present input last [m or rad].
    as_printed : bool
        Whether to leave out the factor 2 and the offset, as the paper does.
    """
    q = operator.component.measure(operator.parameters)
    minima, maxima, now = path[:-1:2], path[1:-1:2], path[-1]
    rising = len(minima) > len(maxima)
    closed = maxima if rising else maxima[:-1]
    total = sum(
        everett(M, before, q) - everett(M, after, q)
        for M, before, after in zip(closed, minima, minima[1:], strict=False)
    )
    if rising:
        total += everett(now, minima[-1], q)
    else:
        total += everett(maxima[-1], minima[-1], q) - everett(maxima[-1], now, q)
    return total if as_printed else 2.0 * total - everett(-path[0], path[0], q)
