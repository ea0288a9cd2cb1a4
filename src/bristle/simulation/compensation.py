"""What feedforward and friction compensation gain on the loop of an axis."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from bristle.controllers import open_loop
from bristle.core.contracts import Model
from bristle.core.diagnostic import Diagnostic
from bristle.core.edge import Amount, amount, array, guarded, instance, model
from bristle.core.experiment import LOOP_VARIANTS, RUN, Effort, Experiment, Feedforward, Run, Start, Variant
from bristle.core.fingerprint import digest
from bristle.engine.checks import FRICTION
from bristle.files.variant import at_rest
from bristle.friction import without_presliding
from bristle.plants.terms import terms_of
from bristle.references import recorded
from bristle.sensors import encoder

AS_RECORDED, FEEDFORWARD, COMPENSATED = LOOP_VARIANTS


def settling(duration: float) -> float:
    """Return how long after its start a loop is not judged [s]: a twentieth of its duration, half a second at most."""
    return min(0.05 * duration, 0.5)


@guarded(
    plant=model("plant"),
    compensator=FRICTION,
    reference=array(least=3),
    sample_time=amount(RUN["sample_time"]),
    lag=amount(RUN["current_lag"]),
)
def compensation_experiment(
    plant: Model,
    friction: Model,
    compensator: Model,
    controller: Model,
    reference: Any,
    sample_time: Amount,
    *,
    resolution: Amount = 0.0,
    effort_limit: Amount = math.inf,
    lag: Amount = 0.0,
    disturbance: Any = None,
    injected: Any = None,
    start: Start | None = None,
    name: str = "axis",
) -> Experiment:
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
    lag : float
        Time constant with which the drive follows its controller [s].
    disturbance : ndarray, shape (sample,), optional
        Force that the friction model does not explain [N or N*m].
    injected : ndarray, shape (sample,), optional
        Known input that joins the output of the controller before the limit of the drive [N or N*m].
    start : Start, optional
        Where the loops begin; where the reference does, if not given.
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
        run=Run(duration=duration, sample_time=sample_time, effort_limit=effort_limit, settle=settling(duration), current_lag=lag),
        disturbance=disturbance,
        injected=injected,
        start=start,
    )
    # A law with an inertia of its own feeds it forward by itself.
    mass = 0.0 if "J" in controller.component.variables else plant.values["M"]
    bent = plant if terms_of(plant) else None
    follows = controller.with_values(k_ff=1.0) if "k_ff" in controller.component.variables else controller
    fed = replace(base, name=FEEDFORWARD, controller=follows, feedforward=Feedforward(mass=mass, plant=bent))
    compensated = replace(fed, name=COMPENSATED, feedforward=Feedforward(mass=mass, plant=bent, friction=compensator))
    return Experiment(name=name, kind=kind, variants=(base, fed, compensated))


@guarded(experiment=instance(Experiment, "an Experiment"))
def on_another_rig(experiment: Experiment) -> dict[str, Diagnostic]:
    """Return what is to be said of compensators that were identified on another friction, by the name of the variant."""
    return {
        variant.name: Diagnostic("another_rig", severity="note", kind=variant.plant.kind)
        for variant in experiment.variants
        if variant.feedforward.fitted_to and variant.feedforward.fitted_to != digest(without_presliding(variant.friction))
    }


@guarded(plant=model("plant"), effort=array(least=3), sample_time=amount(RUN["sample_time"]))
def open_loop_experiment(
    plant: Model, friction: Model, effort: Any, sample_time: Amount, *, sensor: Model | None = None, name: str = "open loop", **run: Any
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
    sensor : Model, optional
        What reads the position; an encoder without steps and noise where not given.
    name : str
        Name of the experiment.
    **run : float or str
        Further arguments of `bristle.core.Run`: `tolerance`, the largest error of the position over the whole run [m or
        rad], for which the steps are chosen, or `substeps` of one length in a sample; `effort_limit` [N or N*m]; `settle`,
        the time at the start that the statistics leave out [s].

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
    variant = Variant(
        name="base",
        plant=plant,
        friction=friction,
        controller=open_loop(kind=plant.kind),
        sensor=sensor or encoder(kind=plant.kind, resolution=0.0),
        reference=at_rest(plant.kind),
        feedforward=Feedforward(),
        run=Run(duration=sample_time * effort.size, sample_time=sample_time, **run),
        effort=Effort(effort),
    )
    return Experiment(name=name, kind=plant.kind, variants=(variant,))
