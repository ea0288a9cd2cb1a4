r"""The inverse of a Prandtl–Ishlinskii operator in closed form: plays in parallel, from force to displacement.

.. math:: u = c f + \sum_j c_j\,\mathcal P_{h_j}[f]

The virgin curve of the inverse is :math:`\varphi^{-1}`, with the virgin curve :math:`\varphi` of the operator. With the
slope :math:`\varphi'` between the thresholds :math:`r_j` of the operator,

.. math:: h_j = \varphi(r_j), \qquad c = 1/\varphi'(0), \qquad c_j = 1/\varphi'(r_j^+) - 1/\varphi'(r_j^-)

The inverse exists if :math:`\varphi` rises everywhere. The spring must therefore be positive: a force at saturation does not
determine a displacement.

References
----------
.. [1] P. Krejčí, K. Kuhnen, "Inverse control of systems with hysteresis and creep", IEE Proc. Control Theory and
   Applications 148(3), 2001. doi:10.1049/ip-cta:20010375
"""

from typing import Annotated, NamedTuple

import numpy as np

from bristle.core import HysteresisOperator, InputError, Model, Variable, kernel
from bristle.models.hysteresis.play import played
from bristle.models.hysteresis.prandtl_ishlinskii import SAME_LENGTH, Move, State


class Parameters(NamedTuple):
    """Parameters of the inverse."""

    thresholds: Annotated[np.ndarray, Variable("force", "half gap of each play", min=0.0)]
    weights: Annotated[np.ndarray, Variable("length/force", "compliance of each play")]
    compliance: Annotated[float, Variable("length/force", "compliance right after a reversal")] = (
        0.0
    )


@kernel
def trial(state, memory, u, p):
    """Return the displacement [m or rad] at the force `u` [N or N*m], and the move there."""
    x = p.compliance * u
    for j in range(p.thresholds.size):
        x += p.weights[j] * played(memory[j], u, p.thresholds[j])
    return x, Move(u)


@kernel
def commit(state, memory, move, p):
    """Let every play follow the force."""
    for j in range(p.thresholds.size):
        memory[j] = played(memory[j], move.u, p.thresholds[j])
    return state


MODEL = inverse_prandtl_ishlinskii = HysteresisOperator(
    name="inverse_prandtl_ishlinskii",
    description="plays in parallel: the displacement from the force",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    memory_size=lambda p: len(p.thresholds),
    input="force",
    output="length",
    relations=(SAME_LENGTH,),
    reference="doi:10.1049/ip-cta:20010375",
    example={"thresholds": [10.0, 13.0], "weights": [1.5e-7, 6.7e-7], "compliance": 1e-7},
)


def inverse_of(operator: Model) -> Model:
    """Return the inverse of a Prandtl–Ishlinskii operator.

    Parameters
    ----------
    operator : Model
        A `prandtl_ishlinskii` operator with parameters.

    Returns
    -------
    Model
        The operator from force [N or N*m] to displacement [m or rad].

    Raises
    ------
    InputError
        If the virgin curve of the operator does not rise everywhere.

    Examples
    --------
    >>> from bristle import hysteresis, response
    >>> stops = hysteresis.prandtl_ishlinskii(thresholds=[1.0, 2.0], weights=[3.0, 1.0], spring=0.5)
    >>> path = [1.5, -0.5, 1.0]
    >>> response(hysteresis.inverse_of(stops), response(stops, path)).round(12)
    array([ 1.5, -0.5,  1. ])
    """
    p = operator.parameters
    thresholds, index = np.unique(p.thresholds, return_inverse=True)
    slopes = p.spring + np.append(np.cumsum(np.bincount(index, p.weights)[::-1])[::-1], 0.0)
    if not np.all(slopes > 0.0):
        raise InputError(
            "must have an output that rises everywhere",
            path=operator.name,
            value=float(slopes.min()),
            allowed="slope > 0",
            mend="Add a parallel spring with a slope > 0, even a small slope",
        )
    heights = np.cumsum(slopes[:-1] * np.diff(thresholds, prepend=0.0))
    return MODEL(
        kind=operator.kind,
        thresholds=heights,
        weights=np.diff(1.0 / slopes),
        compliance=float(1.0 / slopes[0]),
    )
