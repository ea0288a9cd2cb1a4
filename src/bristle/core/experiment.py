"""`Experiment`: one or more variants of a loop to be simulated side by side, as data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from bristle.core.axis import Axis
from bristle.core.content import Origin
from bristle.core.contracts import Model
from bristle.core.variable import Kind

__all__ = ["Experiment", "Feedforward", "Run", "Variant", "substeps_for"]

LONGEST_STEP = 2.5e-4  # of the integration [s]
FEWEST_STEPS = 4  # in a sample


def substeps_for(sample_time: float) -> int:
    """Return how many steps of the integration make up a sample: at least four, none longer than 0.25 ms.

    Parameters
    ----------
    sample_time : float
        Sample time [s].

    Examples
    --------
    >>> substeps_for(1e-4), substeps_for(1e-3), substeps_for(4e-3)
    (4, 4, 16)
    """
    # The sample time of a log is a mean of differences, and a bit above the round number.
    return max(FEWEST_STEPS, math.ceil(sample_time / LONGEST_STEP - 1e-6))


@dataclass(frozen=True)
class Run:
    """How long and how finely to simulate.

    Parameters
    ----------
    duration : float
        Simulated time [s].
    sample_time : float
        Sample time of the controller [s].
    substeps : int
        Integration steps in a sample; 0 stands for as many as `substeps_for` returns.
    delay : int
        Samples from a measurement to the effort computed from it. What is fed forward is known before, and is handed
        to the controller as many samples ahead.
    effort_limit : float
        Largest effort of the drive [N or N*m].
    settle : float
        Time at the start that the statistics leave out [s].
    current_lag : float
        Time constant of the current control of the drive [s]: the effort follows its command with it.
    seeds : int
        Runs, each with other noise: run `i` adds `i` to the seeds of sensor and friction.
    """

    duration: float
    sample_time: float
    substeps: int = 0
    delay: int = 0
    effort_limit: float = float("inf")
    settle: float = 0.0
    current_lag: float = 0.0
    seeds: int = 1

    def __post_init__(self) -> None:
        if self.substeps == 0:
            object.__setattr__(self, "substeps", substeps_for(self.sample_time))


@dataclass(frozen=True)
class Feedforward:
    """What is fed forward: inertia along the desired trajectory, and friction.

    Parameters
    ----------
    mass : float
        Mass or inertia times the desired acceleration [kg or kg*m^2].
    friction : Model or None
        Compensator: a friction model run along the desired or the measured motion.
    gain, asymmetry : float
        Factor on the friction, and the share by which it is raised where positive and lowered where negative.
    offset : float
        Constant added to it [N or N*m].
    limit, rate_limit : float
        Largest friction fed forward [N or N*m], and its fastest change [N/s or N*m/s].
    conditioning : float
        Amplitude of a decaying sweep that the memory of the compensator is brought through first [m or rad]; 0 for
        a virgin one.
    along : {"desired", "measured"}
        The motion that the compensator follows.
    """

    mass: float = 0.0
    friction: Model | None = None
    gain: float = 1.0
    offset: float = 0.0
    asymmetry: float = 0.0
    limit: float = math.inf
    rate_limit: float = math.inf
    conditioning: float = 0.0
    along: Literal["desired", "measured"] = "desired"


@dataclass(frozen=True)
class Learning:
    """How a motion that is repeated is learned.

    Parameters
    ----------
    trials : int
        Trials, of which the last one is reported.
    k_e : float
        Effort learned from the following error [N/m or N*m/rad].
    k_d : float
        Effort learned from its derivative [N*s/m or N*m*s/rad].
    cutoff : float
        Cut-off of the zero-phase low-pass on what is learned [Hz].
    """

    trials: int
    k_e: float
    k_d: float
    cutoff: float


@dataclass(frozen=True)
class Variant:
    """One loop: the mechanism, what controls it, what it is asked to follow.

    `disturbance` is a force against the motion that no model explains, such as the residual of an identification,
    shape (sample,) [N or N*m]. With `learning` the motion is repeated. Of a plant with a screw, `friction` acts on the
    motor and `table` on its table, in N and m; `sensor_at` tells which of both the sensor reads. `axis` says how a log
    of it is written.
    """

    name: str
    plant: Model
    friction: Model
    controller: Model
    sensor: Model
    reference: Model
    feedforward: Feedforward
    run: Run
    disturbance: np.ndarray | None = None
    learning: Learning | None = None
    table: Model | None = None
    sensor_at: str = "load"
    axis: Axis | None = None


@dataclass(frozen=True)
class Experiment:
    """One or more variants side by side; `origins` are the files that it was made from, by what they are."""

    name: str
    kind: Kind
    variants: tuple[Variant, ...]
    source: Path | None = None
    origins: Mapping[str, tuple[Origin, ...]] = field(default_factory=dict)
