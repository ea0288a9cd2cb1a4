"""What feedforward and friction compensation gain on the loop of an axis."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from bristle.core.contracts import Model
from bristle.core.experiment import Experiment, Feedforward, Run, Variant
from bristle.references import recorded
from bristle.sensors import encoder

__all__ = ["AS_RECORDED", "COMPENSATED", "FEEDFORWARD", "compensation_experiment"]

AS_RECORDED, FEEDFORWARD, COMPENSATED = "as_recorded", "feedforward", "compensated"
SETTLE_SHARE, SETTLE_MAX = 0.05, 0.5  # of the duration, and in seconds


def compensation_experiment(
    plant: Model, friction: Model, compensator: Model, controller: Model, reference: np.ndarray, sample_time: float, *,
    resolution: float = 0.0, effort_limit: float = math.inf, disturbance: np.ndarray | None = None, name: str = "axis",
) -> Experiment:  # fmt: skip
    """Return the experiment that shows what feedforward and friction compensation gain.

    Three variants follow the same reference: the loop as it was recorded; with velocity and inertia fed forward; and
    with the friction fed forward as well, along the desired trajectory.

    Parameters
    ----------
    plant, friction : Model
        The axis: what is simulated.
    compensator : Model
        The friction model that is fed forward.
    controller : Model
        The control law that was running.
    reference : ndarray, shape (sample,)
        Desired position [m or rad].
    sample_time : float
        Sample time [s].
    resolution : float
        One count of the encoder [m or rad].
    effort_limit : float
        Largest effort of the drive [N or N*m].
    disturbance : ndarray, shape (sample,), optional
        Force that the friction model does not explain [N or N*m].
    name : str
        Name of the experiment.

    Returns
    -------
    Experiment
        Variants ``as_recorded``, ``feedforward`` and ``compensated``.
    """
    kind = plant.kind
    duration = sample_time * reference.size
    base = Variant(
        name=AS_RECORDED,
        plant=plant,
        friction=friction,
        controller=controller,
        sensor=encoder(kind=kind, resolution=resolution),
        reference=recorded(kind=kind, position=np.asarray(reference), sample_time=sample_time),
        feedforward=Feedforward(),
        run=Run(
            duration=duration,
            sample_time=sample_time,
            effort_limit=effort_limit,
            settle=min(SETTLE_SHARE * duration, SETTLE_MAX),
        ),
        disturbance=disturbance,
    )
    mass = plant.values["M"]
    follows = controller.with_values(k_ff=1.0) if "k_ff" in controller.component.variables else controller
    fed = replace(base, name=FEEDFORWARD, controller=follows, feedforward=Feedforward(mass=mass))
    compensated = replace(fed, name=COMPENSATED, feedforward=Feedforward(mass=mass, friction=compensator))
    return Experiment(name=name, kind=kind, variants=(base, fed, compensated))
