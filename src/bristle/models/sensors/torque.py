r"""A torque sensor between a motor and its screw, and its limits.

The shaft transmits the effort of the motor minus the effort that accelerates the motor:

.. math:: T = u - J_m \dot\omega = F_p + (J - J_m)\,\dot\omega

This torque equals the friction :math:`F_p` of the equation of motion :math:`J \dot\omega = u - F_p` only while the axis
does not accelerate, or if all of its inertia is before the sensor. A slow loop measured with the sensor is the loop of
the friction; a loop at the frequency of a controller is not.
"""

from typing import Any

import numpy as np

from bristle.core import Amount, InputError, Variable, amount, array, guarded


@guarded(
    effort=array(least=1),
    velocity=array(least=1),
    dt=amount(Variable("time", "sample time", min=0.0), exclusive=True),
    J_m=amount(Variable("mass", "inertia before the sensor", min=0.0)),
)
def torque_seen(effort: Any, velocity: Any, dt: Amount, J_m: Amount) -> np.ndarray:
    """Return the mean torque in the shaft between two samples.

    Parameters
    ----------
    effort : ndarray, shape (sample,)
        Effort of the motor from each sample to the next [N*m].
    velocity : ndarray, shape (sample,)
        Velocity of the motor at each sample [rad/s].
    dt : float
        Sample time [s].
    J_m : float
        Inertia before the sensor, that of the motor [kg*m^2].

    Returns
    -------
    ndarray, shape (sample - 1,)
        Torque [N*m].

    Examples
    --------
    >>> torque_seen(np.array([1.0, 1.0]), np.array([0.0, 0.5]), 0.1, 0.1)
    array([0.5])
    """
    if effort.shape != velocity.shape:
        raise InputError(
            "must have as many samples as effort",
            path="velocity",
            value=velocity.size,
            allowed=f"{effort.size} samples",
        )
    return effort[:-1] - J_m * np.diff(velocity) / dt
