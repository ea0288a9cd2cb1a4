r"""Bands around a simulated prediction: how far the motion and the effort of a loop may be from what was predicted.

The simulation is run again with each of several sets of parameters that the log of the identification allows. On the
plant acts, besides,

.. math:: d = (c_k - 1)\, F(t) + \varepsilon\, g_j

with a level of friction :math:`c_k` drawn anew for each half-cycle `k` of the recorded motion, the friction force `F`
along it, what the model leaves over beyond that, :math:`\varepsilon`, and a standard normal number :math:`g_j` that
lasts as long as what is left over keeps its side. A band is

.. math:: \hat y \pm 1.96\, \kappa \sqrt{\overline{(y_b - \hat y)^2} + \sigma^2}

where :math:`\sigma` is the noise of what is measured and :math:`\kappa` the factor that held-out blocks asked for. The
spread is that about the prediction itself: where an error of the force adds up, as in open loop, it grows with it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from bristle.core.contracts import Model
from bristle.core.cores import Abreast
from bristle.core.normal import NORMAL_95
from bristle.engine.motion import along
from bristle.identification.half_cycles import least_way
from bristle.identification.prediction_interval import MEMBERS, SEED, Bands, with_parameters
from bristle.identification.preprocessing import CUTOFF_SHARE, segment_of
from bristle.logs.log import Log
from bristle.logs.segmentation import numbered, reversals, turns_apart

__all__ = ["Course", "Widths", "simulated_widths"]

ROUNDING = 12.0**-0.5  # standard deviation of rounding, of a step


class Course(Protocol):
    """What became of a simulation, shape (sample,); shorter where it diverged."""

    @property
    def position(self) -> np.ndarray:
        """Position [m or rad]."""
        ...

    @property
    def command(self) -> np.ndarray:
        """Effort [N or N*m]."""
        ...


class Widths(NamedTuple):
    """Half-widths of the 95 % bands around position [m or rad] and effort [N or N*m], shape (sample,)."""

    position: np.ndarray
    effort: np.ndarray


def simulated_widths(
    bands: Bands, plant: Model, friction: Model, predicted: Course, log: Log, part: slice, resolution: float,
    simulate: Callable[[Model, Model, np.ndarray], Course],
) -> Widths:  # fmt: skip
    """Return the half-widths of the 95 % bands around a simulation; infinite where no other one came that far.

    Parameters
    ----------
    bands : Bands
        What the widths are made of.
    plant, friction : Model
        The model; parameters that were not fitted are those of it.
    predicted : Course
        What was predicted with it.
    log, part : Log, slice
        What was recorded meanwhile: where the motion turned, friction found another level.
    resolution : float
        Step of the encoder [m or rad].
    simulate : callable
        Returns the course with another plant, another friction, and a force against the effort [N or N*m].
    """
    count, dt, rng = predicted.position.size, log.sample_time, np.random.default_rng(SEED)
    cycle, force = _along(friction, log, part, resolution)
    block = (np.arange(cycle.size) * dt / max(bands.lasting, dt)).astype(int)

    def member(index: int, level: np.ndarray, left: np.ndarray) -> np.ndarray:
        mine = with_parameters(bands, index, plant), with_parameters(bands, index, friction)
        trial = simulate(*mine, bands.scatter * level[cycle] * force + bands.unexplained * left[block])
        off = np.full((2, count), np.nan)
        reached = min(trial.position.size, count)
        off[0, :reached] = (trial.position - predicted.position)[:reached]
        off[1, :reached] = (trial.command - predicted.command)[:reached]
        return off * off

    members = range(min(bands.count, MEMBERS))
    levels, left = (rng.standard_normal((len(members), int(numbers[-1]) + 1)) for numbers in (cycle, block))
    with Abreast() as pool:
        square = _mean(np.array(list(pool.map(member, members, levels, left))))
    noise = np.array([[ROUNDING * resolution], [bands.noise]])
    return Widths(*(NORMAL_95 * bands.inflation * np.sqrt(square + noise**2)))


def _mean(squares: np.ndarray) -> np.ndarray:
    """Return the mean over those simulations that came so far."""
    finite = np.isfinite(squares)
    total, count = np.sum(squares, axis=0, where=finite), finite.sum(axis=0)
    return np.divide(total, count, out=np.full(total.shape, np.inf), where=count > 0)


def _along(friction: Model, log: Log, part: slice, resolution: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the number of the half-cycle of each sample of a log, and the friction force there [N or N*m]."""
    segment, noise, _ = segment_of(log, part, CUTOFF_SHARE / log.sample_time, resolution)
    changes = reversals(segment.velocity, sided=True).tolist()
    turns = turns_apart(segment.position, changes, least_way(resolution, noise))
    cycle = numbered(turns, segment.position.size)
    return cycle, along(friction, dt=log.sample_time, **segment.signals(log.sample_time))
