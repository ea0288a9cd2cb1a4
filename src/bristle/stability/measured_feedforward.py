r"""Friction fed forward along the measured motion: a feedback, and a positive one.

Where the axis is stuck, friction of stiffness :math:`s` holds it beside the stiffness :math:`K` of the law. A
compensator of `c` times this friction that follows the measured motion takes :math:`c\,s` away again. What is left
holds the axis only if :math:`K + s - c\,s > 0`, that is :math:`K > (c - 1)\,s`; for the sliding mode law inside its
boundary layer :math:`K = J\lambda(K_1 + K_2/\phi)`. Along the desired motion nothing is taken away.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bristle.core.experiment import Feedforward
from bristle.stability.linear_friction import stiffness_at_rest
from bristle.stability.linear_system import LinearSystem

__all__ = ["Stiffness", "feedback_of"]

SLOW = (1e-7, 1e-6)  # where a law without an integral answers alike [rad/sample]


class Stiffness(NamedTuple):
    """What holds a stuck axis in its place [N/m or N*m/rad].

    Parameters
    ----------
    law : float
        Of the control law: effort over a deviation that lasts; without end for one with an integral.
    friction : float
        Of the friction before it breaks away.
    compensation : float
        What the friction fed forward along the measured motion takes away.
    """

    law: float
    friction: float
    compensation: float

    @property
    def left(self) -> float:
        """What holds the axis after all."""
        return self.law + self.friction - self.compensation

    @classmethod
    def of(cls, law: LinearSystem, friction: float, compensation: float) -> Stiffness:
        """Return what holds an axis under a linear law."""
        slow = np.abs(law.response(np.exp(1j * np.array(SLOW))))
        return cls(float("inf") if slow[0] > 2.0 * slow[1] else float(slow[0]), friction, compensation)


def feedback_of(feedforward: Feedforward, dt: float) -> tuple[LinearSystem, float] | None:
    """Return what friction fed forward along the measured motion feeds back, and its stiffness [N/m or N*m/rad].

    None where it follows the desired motion, or has no stiffness.
    """
    if feedforward.along != "measured" or feedforward.friction is None:
        return None
    stuck = stiffness_at_rest(feedforward.friction, dt)
    if stuck is None:
        return None
    # The mean force over the last sample, from the position before it to the present one.
    spring, damper = 0.5 * feedforward.gain * stuck.k, feedforward.gain * stuck.c / dt
    fed = LinearSystem(np.zeros((1, 1)), np.ones(1), np.array([spring - damper]), spring + damper)
    return fed, 2.0 * spring
