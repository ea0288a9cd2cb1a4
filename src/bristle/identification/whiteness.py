"""Whether what a fit leaves over is white: only then does the plain covariance of least squares hold."""

from __future__ import annotations

import numpy as np

from bristle.identification.settings import DEFAULT, Settings

__all__ = ["is_white"]


def is_white(residual: np.ndarray, settings: Settings = DEFAULT) -> bool:
    """Return whether the autocorrelation of a residual, shape (row,), is that of independent errors.

    References
    ----------
    .. [1] G. M. Ljung, G. E. P. Box, "On a measure of lack of fit in time series models", Biometrika 65(2), 1978.
       doi:10.1093/biomet/65.2.297
    """
    from scipy.stats import chi2

    most = int(settings.white_lags)
    centred = residual - np.mean(residual)
    power, count = float(centred @ centred), centred.size
    if power == 0.0 or count <= 2 * most:
        return False
    lags = np.arange(1, most + 1)
    correlation = np.array([float(centred[lag:] @ centred[:-lag]) for lag in lags]) / power
    return bool(count * (count + 2) * np.sum(correlation**2 / (count - lags)) < chi2.ppf(settings.white_level, most))
