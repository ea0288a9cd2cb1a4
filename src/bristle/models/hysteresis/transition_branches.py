r"""A Preisach operator from 100 transition branches of the reformed Dahl model that leave one loop.

The source paper makes its operator from 100 branches of (16) and (17), and does not specify the branches. This is one
interpretation.

The ascending branch of the loop of amplitude :math:`x_r`, equation (17), is left at 100 inputs :math:`\alpha` along
descending branches, equation (16) from a general reversal:

.. math::
    f_{\alpha\beta} = f_\alpha - \frac{p\,s\,d}{p + s\,d}, \qquad p = f_p + f_\alpha, \quad d = \alpha - \beta

The Everett function :math:`E = \tfrac12(f_\alpha - f_{\alpha\beta})` of these branches is not that of friction that
is the same in both directions, because the reformed Dahl model is not a Preisach operator:

========================================================== ======= ======= ======= ======= =======
:math:`k = s x_r/f_p`                                          0.5       1       2       5      10
========================================================== ======= ======= ======= ======= =======
corner: :math:`f_{\alpha,-x_r} + f_r` over :math:`f_r`       6.4 %  11.7 %  17.8 %  25.1 %  28.9 %
symmetry: :math:`E(\alpha,\beta) - E(-\beta,-\alpha)` over E   3.2 %   5.8 %   8.9 %  12.5 %  14.5 %
========================================================== ======= ======= ======= ======= =======

A descending branch should end in the corner :math:`(-x_r, -f_r)` of its loop, and does not.

The other interpretation is literal: (16) at each reversal :math:`\alpha` with :math:`x_r = \alpha` and the tip
:math:`f_r(x_r)` of its loop, :math:`E = \tfrac12[f_r(\alpha) - f_{16}(\beta)]` down to :math:`\beta = -\alpha`, and
(17) beyond. Then corner and symmetry are correct to rounding, and :math:`E` is the kernel ``reformed_dahl_exact``
of `preisach`, in closed form.
"""

from dataclasses import dataclass

import numpy as np

from bristle.core import InputError, Model
from bristle.core.edge import KIND, Amount, amount, guarded, whole
from bristle.core.variable import Kind, Variable
from bristle.models.hysteresis.everett import loop_tip
from bristle.models.hysteresis.tabulate import from_reversal_curves


@dataclass(frozen=True, eq=False)
class TransitionBranches:
    """Descending branches that leave the ascending branch of one symmetric loop.

    Parameters
    ----------
    inputs : ndarray, shape (count + 1,)
        Evenly from -x_r to x_r [m or rad]; a branch begins at each but the first.
    f : ndarray, shape (count + 1, count + 1)
        Force [N or N*m] at input j on the branch that turned at input i, for j <= i; the diagonal is the ascending
        branch.
    f_r : float
        Force at the tip of the loop [N or N*m].
    kind : {"translational", "rotational"}
        The kind of axis.
    """

    inputs: np.ndarray
    f: np.ndarray
    f_r: float
    kind: Kind = "translational"

    def operator(self) -> Model:
        """Return the operator that these branches describe, an `everett_table`."""
        return from_reversal_curves(
            [(self.inputs[i::-1], self.f[i, i::-1]) for i in range(1, self.inputs.size)],
            kind=self.kind,
        )

    @property
    def E(self) -> np.ndarray:
        """Everett function [N or N*m] at (alpha, beta) = (input i, input j), j <= i, shape of `f`."""
        return np.tril(0.5 * (np.diag(self.f)[:, None] - self.f))

    @property
    def corner_error(self) -> float:
        """Largest distance of a branch from the corner (-x_r, -f_r) at its end, over f_r."""
        return float(np.max(np.abs(self.f[:, 0] + self.f_r))) / self.f_r

    @property
    def symmetry_error(self) -> float:
        """Largest difference between E(alpha, beta) and E(-beta, -alpha), over the largest E."""
        return float(np.max(np.abs(self.E - self.E[::-1, ::-1].T)) / np.max(self.E))


@guarded(
    s=amount(Variable("force/length", "stiffness", min=0.0), exclusive=True),
    f_p=amount(Variable("force", "force at saturation", min=0.0), exclusive=True),
    x_r=amount(Variable("length", "amplitude of the loop", min=0.0), exclusive=True),
    count=whole(2, 10_000),
    kind=KIND,
)
def transition_branches(
    s: Amount, f_p: Amount, x_r: Amount, *, count: int = 100, kind: Kind = "translational"
) -> TransitionBranches:
    """Return the transition branches of the reformed Dahl model in its loop of amplitude `x_r`.

    Parameters
    ----------
    s : float
        Stiffness after a reversal [N/m or N*m/rad].
    f_p : float
        Force at saturation [N or N*m].
    x_r : float
        Amplitude of the loop [m or rad].
    count : int
        Number of branches.
    kind : {"translational", "rotational"}
        The kind of axis.

    Returns
    -------
    TransitionBranches
        The branches, and their deviation from those of an operator.

    Raises
    ------
    InputError
        If a parameter is not positive, or there are fewer than two branches.

    Examples
    --------
    >>> branches = transition_branches(s=1.0, f_p=1.0, x_r=2.0)
    >>> round(branches.corner_error, 3), round(branches.symmetry_error, 3)
    (0.178, 0.089)
    """
    inputs = np.linspace(-x_r, x_r, count + 1)
    f_r = f_p * loop_tip(s * x_r / f_p)
    drop = np.maximum(inputs[:, None] - inputs, 0.0)
    with np.errstate(all="ignore"):  # an overflow or zero raises InputError below
        ascending = _branch(-f_r, inputs + x_r, s, f_p + f_r)
        descending = _branch(ascending[:, None], -drop, s, f_p + ascending[:, None])
    if not np.all(np.isfinite(descending)):
        raise InputError(
            "is too large for these values of s and f_p",
            path="x_r",
            value=x_r,
            mend="Check the units of x_r, s and f_p",
        )
    return TransitionBranches(inputs, descending, f_r, kind)


def _branch(
    start: np.ndarray | float, travel: np.ndarray, s: float, reach: np.ndarray | float
) -> np.ndarray:
    """Return the force on a branch after a travel of either sign; `reach` is the force left to saturation."""
    return start + reach * s * travel / (reach + s * np.abs(travel))
