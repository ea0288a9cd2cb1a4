r"""A sine of one frequency whose amplitude varies: loops within loops, as in the experiments of the source paper.

.. math:: x(t) = c + A(t) \sin(2\pi f t)

where :math:`A` passes through the given amplitudes at equal intervals of the duration, monotonically in between
(piecewise cubic Hermite). The motion begins at the centre :math:`c`, and at rest if the first amplitude is 0. After the
duration the sine keeps its last amplitude.

References
----------
.. [1] F. N. Fritsch, R. E. Carlson, "Monotone piecewise cubic interpolation", SIAM Journal on Numerical Analysis
   17(2), 1980. doi:10.1137/0717021
"""

from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import Relation, Trajectory, Variable


class Parameters(NamedTuple):
    """Parameters of the varied sine."""

    amplitudes: Annotated[
        np.ndarray, Variable("length", "amplitudes, at equal intervals of the duration")
    ]
    frequency: Annotated[float, Variable("frequency", "frequency", min=1e-9)]
    duration: Annotated[float, Variable("time", "time to pass through all amplitudes", min=1e-9)]
    offset: Annotated[float, Variable("length", "centre of the motion")] = 0.0


class State(NamedTuple):
    """A varied sine has no state."""


def sample(t: np.ndarray, p: Parameters) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position [m or rad], velocity and acceleration at the times `t` [s], each of the shape of `t`."""
    from scipy.interpolate import PchipInterpolator

    amplitude = PchipInterpolator(np.linspace(0.0, p.duration, p.amplitudes.size), p.amplitudes)
    inside = t < p.duration
    at = np.minimum(t, p.duration)
    A, A_dot, A_ddot = amplitude(at), amplitude(at, 1) * inside, amplitude(at, 2) * inside
    omega = 2.0 * np.pi * p.frequency
    s, c = np.sin(omega * t), np.cos(omega * t)
    return (
        p.offset + A * s,
        A_dot * s + A * omega * c,
        A_ddot * s + 2.0 * A_dot * omega * c - A * omega**2 * s,
    )


MODEL = varied_sine = Trajectory(
    name="varied_sine",
    description="a sine of constant frequency whose amplitude varies",
    Parameters=Parameters,
    State=State,
    sample=sample,
    relations=(
        Relation(
            "at least 2 amplitudes",
            lambda p: len(p.amplitudes) >= 2,
            "Give at least two amplitudes",
        ),
    ),
    reference="doi:10.1137/0717021",
)
