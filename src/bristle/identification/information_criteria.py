r"""Information criteria: what a model may cost in parameters for what it explains.

.. math:: \mathrm{AIC} = n \ln\frac{\|r\|^2}{N} + 2 k, \qquad \mathrm{BIC} = n \ln\frac{\|r\|^2}{N} + k \ln n

over `N` rows and `k` free parameters. Residuals that last from row to row are not `N` measurements but

.. math:: n = N\,\frac{1 - \rho}{1 + \rho}

with the correlation :math:`\rho` of neighbouring rows, of the model that leaves least over; with `N` itself the largest
model would always win. Both criteria take the residual for noise. Where all models lack something, the error on
blocks that were held out is the better judge.

References
----------
.. [1] K. P. Burnham, D. R. Anderson, "Multimodel inference: understanding AIC and BIC in model selection",
   Sociological Methods & Research 33(2), 2004. doi:10.1177/0049124104268644
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bristle.identification.result import Fit, Information

__all__ = ["with_information"]

FEWEST = 10.0  # measurements


def with_information(fits: Sequence[Fit]) -> list[Fit]:
    """Return fits to the same rows with their information criteria, which are differences to the smallest ones."""
    squares = [_square(fit) for fit in fits]
    if not fits or min(squares) == 0.0:
        return list(fits)
    best = fits[int(np.argmin(squares))].traces.residual
    rows = best.size
    along = float(np.clip(best[1:] @ best[:-1] / (best @ best), 0.0, 0.999))
    count = max(rows * (1.0 - along) / (1.0 + along), FEWEST)
    sizes = [len(fit.correlation_names) + fit.further for fit in fits]
    plain = [count * float(np.log(square / rows)) for square in squares]
    aic = [term + 2.0 * size for term, size in zip(plain, sizes, strict=True)]
    bic = [term + size * float(np.log(count)) for term, size in zip(plain, sizes, strict=True)]
    return [
        replace(fit, information=Information(fit_aic - min(aic), fit_bic - min(bic), count))
        for fit, fit_aic, fit_bic in zip(fits, aic, bic, strict=True)
    ]


def _square(fit: Fit) -> float:
    """Return the sum of squares of what the fit made small, as if each row held as much of it as the samples do."""
    simulated = fit.position_rmse if fit.loop_rmse is None else fit.loop_rmse
    residual = fit.traces.residual
    return float(residual @ residual) if simulated is None else residual.size * simulated**2
