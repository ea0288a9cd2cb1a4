"""Histories of an operator before the first sample. A virgin operator has no history.

Any sequence of inputs is a history. These functions give the two usual initial states of a measurement.
"""

import numpy as np

from bristle.core import Amount, Variable, amount, guarded, whole


@guarded(extent=amount(Variable("length", "input at the end")))
def saturated(extent: Amount) -> np.ndarray:
    """Return the history of an operator driven to one end.

    Parameters
    ----------
    extent : float or str
        The input at that end [m or rad], of either sign.

    Returns
    -------
    ndarray, shape (1,)
        The history.
    """
    return np.array([float(extent)])


@guarded(
    amplitude=amount(Variable("length", "amplitude", min=0.0), exclusive=True),
    reversals=whole(1, 10**7),
)
def conditioned(amplitude: Amount, reversals: int = 100) -> np.ndarray:
    """Return the history of an operator demagnetised by a sweep whose amplitude falls evenly to 0.

    Parameters
    ----------
    amplitude : float or str
        Amplitude of the first reversal [m or rad]; the sweep erases the earlier history up to this amplitude only.
    reversals : int
        Number of reversals; more come closer to the virgin state and store more turning points.

    Returns
    -------
    ndarray, shape (reversals + 1,)
        The inputs at the reversals, and 0 at the end.

    Raises
    ------
    InputError
        If the amplitude is not positive or there is no reversal.

    Examples
    --------
    >>> conditioned(4.0, 4)
    array([ 4., -3.,  2., -1.,  0.])
    """
    steps = np.arange(reversals + 1)
    return amplitude * (1.0 - steps / reversals) * (1.0 - 2.0 * (steps % 2)) + 0.0
