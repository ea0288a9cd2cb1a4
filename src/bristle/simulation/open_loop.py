"""The experiment without a loop: a plant with friction that a given effort drives."""

from __future__ import annotations

import math
from typing import Any

from bristle.controllers import open_loop
from bristle.core.contracts import Model
from bristle.core.edge import TEXT, Amount, amount, array, guarded, model, optional, whole
from bristle.core.experiment import RUN, Effort, Experiment, Feedforward, Run, Variant
from bristle.engine.checks import FRICTION
from bristle.files.run import at_rest
from bristle.sensors import encoder

__all__ = ["open_loop_experiment"]


@guarded(
    plant=model("plant"),
    friction=FRICTION,
    effort=array(least=3),
    sample_time=amount(RUN["sample_time"]),
    tolerance=amount(RUN["tolerance"]),
    substeps=whole(0, 10_000),
    sensor=optional(model("sensor")),
    effort_limit=amount(RUN["effort_limit"], endless=True),
    settle=amount(RUN["settle"]),
    name=TEXT,
)
def open_loop_experiment(
    plant: Model,
    friction: Model,
    effort: Any,
    sample_time: Amount,
    *,
    tolerance: Amount = 0.0,
    substeps: int = 0,
    sensor: Model | None = None,
    effort_limit: Amount = math.inf,
    settle: Amount = 0.0,
    name: str = "open loop",
) -> Experiment:
    """Return the experiment in which a given effort drives a plant with friction, and no controller.

    Parameters
    ----------
    plant, friction : Model
        The axis.
    effort : array_like, shape (sample,)
        Effort of the drive from each sample until the next one [N or N*m].
    sample_time : float or str
        Time between samples [s].
    tolerance : float or str
        Largest error of the position over the whole run [m or rad]; the steps are chosen for it. Without one they have
        one length.
    substeps : int
        Steps of one length in a sample; as many as `substeps_for` returns where neither is given.
    sensor : Model, optional
        What reads the position; an encoder without steps and noise where not given.
    effort_limit : float or str
        Largest effort of the drive [N or N*m].
    settle : float or str
        Time at the start that the statistics leave out [s].
    name : str
        Name of the experiment.

    Raises
    ------
    InputError
        If both a tolerance and a number of steps are given, or the plant has a screw and is to take a tolerance.

    Examples
    --------
    >>> import bristle as br
    >>> pulled = br.plants.pulled_inertia(M=1.0, k=2.0, v_e=0.1)
    >>> lugre = br.friction.lugre(F_C=1.0, F_S=1.5, v_S=1e-3, sigma_0=1e5, sigma_1=316.2, sigma_2=0.4)
    >>> experiment = open_loop_experiment(pulled, lugre, [0.0] * 2000, "10 ms", tolerance="1 um")
    >>> br.simulate(experiment).variants["base"].motion.max.__round__(4)
    1.2726
    """
    run = Run(
        duration=sample_time * effort.size,
        sample_time=sample_time,
        substeps=substeps,
        tolerance=tolerance,
        effort_limit=effort_limit,
        settle=settle,
    )
    variant = Variant(
        name="base",
        plant=plant,
        friction=friction,
        controller=open_loop(kind=plant.kind),
        sensor=sensor or encoder(kind=plant.kind, resolution=0.0),
        reference=at_rest(plant.kind),
        feedforward=Feedforward(),
        run=run,
        effort=Effort(effort),
    )
    return Experiment(name=name, kind=plant.kind, variants=(variant,))
