"""What a motion will identify, and how well: its log is simulated with a prior model, and identified."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.packing import pack
from bristle.core.variable import unit_of
from bristle.engine import force_in_turns
from bristle.excitation.motion import Motion
from bristle.excitation.plan import Frame
from bristle.friction import find
from bristle.identification import Fit, identify
from bristle.identification.resampling.levels import scaled
from bristle.logs.log import Channel, Log
from bristle.plants.inertia import MODEL as inertia

__all__ = ["Foresight", "Prior", "foreseen", "prior_of", "simulated_log"]

SCATTER = 0.05  # of the level of friction from reversal to reversal, where nobody knows it
NOISE = 0.005  # of the largest friction force
SEED = 60


class Prior(NamedTuple):
    """What is thought of an axis before anything was recorded."""

    plant: Model
    friction: Model
    scatter: float = SCATTER
    noise: float = NOISE


@dataclass(frozen=True)
class Foresight:
    """The identification of a simulated log.

    Parameters
    ----------
    prior : Prior
        What the log was simulated with.
    fit : Fit
        What came of it.
    """

    prior: Prior
    fit: Fit


def prior_of(axis: Axis, frame: Frame) -> Prior:
    """Return a guess at the friction of an axis: LuGre of the size that its limits suggest.

    What is foreseen are relative errors, which do not depend on the level of the force.
    """
    level = 0.1 * axis.effort_limit if axis.effort_limit and math.isfinite(axis.effort_limit) else 1.0
    mass = axis.mass or level / (0.5 * frame.acceleration)
    static = 1.3 * level
    stiffness = 3.0 * static / frame.breakaway
    values: dict[str, Any] = {
        "F_C": level, "F_S": static, "v_S": 0.03 * frame.top, "sigma_0": stiffness,
        "sigma_1": math.sqrt(stiffness * mass), "sigma_2": 0.3 * level / frame.top,
    }  # fmt: skip
    return Prior(inertia(kind=axis.kind, M=mass), find("lugre")(kind=axis.kind, **values))


def foreseen(
    motion: Motion, axis: Axis, prior: Prior, *, model: str | None = None, draws: int = 100,
    progress: Callable[[float, str], None] | None = None,
) -> Foresight:  # fmt: skip
    """Return what the log of a motion would identify.

    Parameters
    ----------
    motion : Motion
        The motion.
    axis : Axis
        Encoder, filter, and what is known of the axis.
    prior : Prior
        The axis as it is thought to be.
    model : str, optional
        What is to be identified; that of the prior where not given.
    draws : int
        Logs that are simulated for the intervals.
    progress : callable, optional
        Called with the share of the work done and what is being done.
    """
    log = simulated_log(motion, axis, prior, SEED)
    # The log is in SI, and without delay.
    plain = replace(axis, columns={}, injected=(), delay=0.0, held=False)
    found = identify(log, model or prior.friction.name, axis=plain, blocks=0, draws=draws, progress=progress)
    return Foresight(prior, found.best)


def simulated_log(motion: Motion, axis: Axis, prior: Prior, seed: int) -> Log:
    """Return the log of a motion, as an axis with this friction would record it.

    The level of friction is drawn anew at each reversal; the position is read through the encoder, the effort with
    noise.
    """
    rng, dt = np.random.default_rng(seed), motion.sample_time
    velocity = np.diff(motion.position) / dt
    starts = [0, *(np.flatnonzero(np.diff(np.sign(velocity) >= 0.0)) + 1).tolist()]
    component, values = prior.friction.component, prior.friction.values
    once, doubled = (pack(component.assemble(scaled(component, values, level))) for level in (1.0, 2.0))
    more = np.subtract(doubled, once, out=np.zeros_like(once), where=doubled != once)
    levels = np.maximum(prior.scatter * rng.standard_normal(len(starts)), -0.9)
    force = force_in_turns(prior.friction, once + levels[:, None] * more, velocity, dt, motion.position[1:], starts)
    force = np.concatenate([force[:1], 0.5 * (force[:-1] + force[1:]), force[-1:]])
    effort = prior.plant.values["M"] * motion.acceleration + force
    effort += prior.noise * float(np.max(np.abs(force))) * rng.standard_normal(effort.size)
    step = axis.resolution or 0.0
    position = step * np.round(motion.position / step) if step else motion.position
    length, unit = unit_of("length", axis.kind), unit_of("force", axis.kind)
    return Log(
        time=Channel(motion.time, "s", "time"), position=Channel(position, length, "position"),
        effort=Channel(effort, unit, "effort"), sample_time=dt, segments=(slice(0, effort.size),), kind=axis.kind,
    )  # fmt: skip
