r"""Bands around a prediction: where 95 % of the measured effort is expected.

The model runs along the motion with each of several sets of parameters that the log of the identification allows, and
with a level of friction drawn anew for each half-cycle. Their variance, that of the noise and that of what the model
leaves over beyond noise, encoder and scatter make up the width,

.. math:: \hat u \pm 1.96\, \kappa \sqrt{\operatorname{var}(u_b) + \sigma^2 + \varepsilon^2}

and :math:`\kappa \ge 1` is set on blocks that were held out: there 95 % of what was measured lay inside (split
conformal prediction [1]_, with the width as the score).

References
----------
.. [1] J. Lei, M. G'Sell, A. Rinaldo, R. J. Tibshirani, L. Wasserman, "Distribution-free predictive inference for
   regression", Journal of the American Statistical Association 113(523), 2018. doi:10.1080/01621459.2017.1307116
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bristle.core.contracts import Model
from bristle.core.normal import NORMAL_95
from bristle.core.values import numbers_of
from bristle.identification.dataset import Dataset, mechanical
from bristle.identification.disturbance import force_with_scatter
from bristle.identification.half_cycles import half_cycle_starts

__all__ = ["Bands", "half_width", "with_parameters"]

MEMBERS = 40
SEED = 95


@dataclass(frozen=True)
class Bands:
    """What it takes to draw a band around a prediction.

    Parameters
    ----------
    draws : mapping of str to array_like, shape (member,) or (member, element)
        Sets of free parameters that the log of the identification allows [SI], as the model takes them.
    scatter : float
        Standard deviation of the level of friction from reversal to reversal, as a share of it.
    noise : float
        Standard deviation of the noise of the effort, sample by sample [N or N*m].
    unexplained : float
        Root mean square of what the model leaves over beyond noise, encoder and scatter [N or N*m].
    lasting : float
        How long that keeps its side [s].
    inflation : float
        Factor set on held-out blocks.
    left_in_closed_loop, left_in_open_loop : float
        What the simulated loop leaves over of the measured position beyond all that and the rounding of the encoder,
        as a standard deviation [m or rad].
    """

    draws: Mapping[str, np.ndarray]
    scatter: float
    noise: float
    unexplained: float
    lasting: float = 0.0
    inflation: float = 1.0
    left_in_closed_loop: float = 0.0
    left_in_open_loop: float = 0.0

    @property
    def count(self) -> int:
        """Number of sets of parameters."""
        return min((len(draws) for draws in self.draws.values()), default=0)


def half_width(bands: Bands, plant: Model, friction: Model, dataset: Dataset) -> np.ndarray:
    """Return the half-width of the 95 % band around the effort of each row [N or N*m], shape (row,).

    Parameters that were not fitted are those of the models.
    """
    starts, rng = half_cycle_starts(dataset), np.random.default_rng(SEED)
    members = []
    for index in range(min(bands.count, MEMBERS)):
        body, contact = (with_parameters(bands, index, model) for model in (plant, friction))
        efforts = [
            mechanical(body, segment)
            + dataset.filtered(force_with_scatter(contact, segment, turns, dataset.sample_time, bands.scatter, rng))
            for segment, turns in zip(dataset.segments, starts, strict=True)
        ]
        members.append(dataset.rows_of(efforts))
    spread = np.var(members, axis=0, ddof=1) if len(members) > 1 else np.zeros(dataset.time.size)
    in_rows = bands.noise**2 * min(2.0 * dataset.bandwidth * dataset.sample_time, 1.0)
    return NORMAL_95 * bands.inflation * np.sqrt(spread + in_rows + bands.unexplained**2)


def with_parameters(bands: Bands, index: int, model: Model) -> Model:
    """Return a model with one of the sets of parameters, as far as they are its own."""
    own = {name: np.asarray(draws[index])[()] for name, draws in bands.draws.items() if name in model.values}
    component = model.component
    return Model(component, component.assemble(numbers_of(component, model.parameters) | own), model.kind)
