"""Feedforward along the desired and the measured motion, and its gain in the loop of an axis."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from bristle.core import Diagnostic, InputError, Model, digest
from bristle.core.edge import Amount, among, amount, array, guarded, instance, model
from bristle.core.experiment import (
    FEEDFORWARD,
    LOOP_VARIANTS,
    RESTS,
    RUN,
    Effort,
    Experiment,
    Feedforward,
    Run,
    Start,
    Variant,
)
from bristle.engine import Compensator, conditioned
from bristle.engine.checks import FRICTION, PERIOD, check_run
from bristle.engine.motion import compensation_along
from bristle.engine.path import Lead, effort_along
from bristle.files.variant import at_rest
from bristle.models.controllers import open_loop
from bristle.models.controllers.feedforward import WHOLE, Rule, Shape, feedforward_of
from bristle.models.friction import without_presliding
from bristle.models.friction.resting import with_rest
from bristle.models.friction.slots import whole_parts
from bristle.models.plants.terms import Termed, place_of, terms_of
from bristle.models.references import recorded
from bristle.models.sensors import encoder
from bristle.simulation.two_masses import following, screw_of, wound_up


@guarded(
    model=FRICTION,
    velocity=array(least=1),
    dt=PERIOD,
    conditioning=amount(FEEDFORWARD["conditioning"]),
    rest=among(*RESTS),
)
def friction_along(
    model: Model, velocity: Any, dt: Amount, *, conditioning: Amount = 0.0, rest: str = RESTS[0]
) -> np.ndarray:
    """Return the friction force that a compensator predicts along a desired motion.

    Parameters
    ----------
    model : Model
        The compensator.
    velocity : ndarray, shape (step,)
        Mean desired velocity of each step [m/s or rad/s].
    dt : float
        Length of a step [s].
    conditioning : float
        Amplitude of the decaying sweep before the motion, which sets its memory [m or rad]; 0 for a virgin memory.
    rest : {"held", "middle"}
        Force of a memoryless model at zero velocity (`bristle.models.friction.resting`).

    Returns
    -------
    ndarray, shape (step,)
        Force [N or N*m].
    """
    model = with_rest(model, rest)
    state, memory = conditioned(model, conditioning)
    return compensation_along(
        model, Shape(), velocity, dt, dt * np.cumsum(velocity), state=state, memory=memory
    )


@guarded(position=array(least=2), acceleration=array(least=2), dt=PERIOD)
def feedforward_effort(
    feedforward: Feedforward, position: Any, acceleration: Any, dt: Amount
) -> np.ndarray:
    """Return the effort fed forward along a desired trajectory, for the step after each sample.

    Parameters
    ----------
    feedforward : Feedforward
        Mass, gravity, cogging and compensator; the loop applies a compensator along the measured motion (`compensator_of`).
        With a `ball_screw` and its `table`, the effort also winds the screw up (`motor_reference`).
    position, acceleration : ndarray, shape (sample,)
        Desired motion; for a `ball_screw` that of the table, converted to the motor.
    dt : float
        Sample time [s].

    Returns
    -------
    ndarray, shape (sample,)
        Effort [N or N*m].
    """
    check_run(position.size, acceleration=acceleration)
    return motor_feedforward(feedforward, position, acceleration, dt).effort


@guarded(position=array(least=2), acceleration=array(least=2), dt=PERIOD)
def motor_reference(
    feedforward: Feedforward, position: Any, acceleration: Any, dt: Amount
) -> np.ndarray:
    r"""Return the position of the motor that moves a table behind an elastic screw along a desired trajectory.

    .. math::
        \theta_r = \frac{1}{r}\left(x_r + w - \frac{d}{k}\,\dot w\right), \qquad
        w = S\left[\frac{M \ddot x_r + F_t(x_r)}{k} \pm g\right]

    with the friction of the table :math:`F_t`, the half gap `g` on the flank that the force selects, stiffness `k` and
    damping `d` of the screw, the travel per radian `r`, and a mean `S` over the wind-up time.

    Parameters
    ----------
    feedforward : Feedforward
        A `ball_screw` as `plant`, and the friction of its `table`.
    position, acceleration : ndarray, shape (sample,)
        Desired motion of the table, converted to the motor [rad, rad/s^2].
    dt : float
        Sample time [s].

    Returns
    -------
    ndarray, shape (sample,)
        Angle of the motor [rad]; without a screw, the desired position.

    Raises
    ------
    InputError
        If the two signals have different lengths.
    """
    check_run(position.size, acceleration=acceleration)
    return motor_feedforward(feedforward, position, acceleration, dt).position


def motor_feedforward(
    feedforward: Feedforward, position: np.ndarray, acceleration: np.ndarray, dt: float
) -> Lead:
    """Return position and effort of the motor for a desired motion of the load, and the rate and acceleration of its lead."""
    screw = screw_of(feedforward)
    still = np.zeros(position.size)
    if screw is None:
        lead = Lead(position, still, still, _planned(feedforward, position, acceleration))
    else:
        lead = wound_up(feedforward, screw, position, acceleration, dt)
        lead = lead._replace(position=position + lead.position)
    motor = lead.position

    if feedforward.friction is None or feedforward.along == "measured":
        return lead
    carried = (
        lead.effort
        if screw is not None
        else carried_effort(feedforward, position, acceleration, dt)
    )
    steps = np.diff(motor) / dt
    friction = with_rest(feedforward.friction, feedforward.rest)
    state, memory = conditioned(friction, feedforward.conditioning)
    fed = compensation_along(
        friction,
        shape_of(feedforward),
        np.append(steps, steps[-1:]),
        dt,
        np.append(motor[1:], motor[-1] + dt * steps[-1]),
        transmitted=carried,
        state=state,
        memory=memory,
    )
    return lead._replace(effort=lead.effort + fed)


def carried_effort(
    feedforward: Feedforward, position: np.ndarray, acceleration: np.ndarray, dt: float
) -> np.ndarray:
    """Return the effort [N or N*m] that a desired trajectory transmits to the load, for the step after each sample."""
    plant = feedforward.carries
    screw = screw_of(feedforward)
    if screw is not None:
        return wound_up(feedforward, screw, position, acceleration, dt).effort
    if plant is None:
        return _planned(feedforward, position, acceleration)
    middle = 0.5 * (position + following(position))
    steps = np.diff(position) / dt
    inner = plant.component
    p = plant.parameters
    if isinstance(p, Termed):
        inner = inner.inner
        p = p.inner
    if inner.inverse is None:
        raise InputError(
            "is a plant without inverse dynamics",
            path="feedforward.carries",
            value=plant.name,
            allowed="inertia, oscillator",
            mend="Remove carries, so that the transmitted effort is the effort of the feedforward",
        )
    effort = inner.inverse(
        middle, np.append(steps, steps[-1:]), 0.5 * (acceleration + following(acceleration)), p
    )
    if terms_of(plant) is None:
        return effort
    return effort + effort_along(middle, place_of(plant))


def compensator_of(
    feedforward: Feedforward, carried: np.ndarray | None = None
) -> Compensator | None:
    """Return the compensator that a loop runs along the measured motion, with the `carried` effort at each sample; None without one."""
    if feedforward.friction is None or feedforward.along == "desired":
        return None
    friction = with_rest(feedforward.friction, feedforward.rest)
    state, memory = conditioned(friction, feedforward.conditioning)
    return Compensator(friction, shape_of(feedforward), state, memory, carried)


def _planned(
    feedforward: Feedforward, position: np.ndarray, acceleration: np.ndarray
) -> np.ndarray:
    """Return fed-forward inertia, gravity and cogging, half way between samples."""
    effort = feedforward.mass * 0.5 * (acceleration + following(acceleration))
    if feedforward.plant is None or terms_of(feedforward.plant) is None:
        return effort
    return effort + effort_along(
        0.5 * (position + following(position)), place_of(feedforward.plant)
    )


def shape_of(feedforward: Feedforward) -> Shape:
    """Return the shape of the friction that is fed forward."""
    shape = Shape(
        **{name: getattr(feedforward, name) for name in Shape._fields if name in FEEDFORWARD}
    )
    if feedforward.scaled == "contact" and feedforward.friction is not None:
        shape = shape._replace(**whole_parts(feedforward.friction))
    return shape


AS_RECORDED, WITH_FEEDFORWARD, COMPENSATED = LOOP_VARIANTS
"""Names of the loops: as recorded, with feedforward, with friction compensation."""


def settling(duration: float) -> float:
    """Return the settling time [s] that statistics leave out: a twentieth of the duration, half a second at most."""
    return min(0.05 * duration, 0.5)


@guarded(
    plant=model("plant"),
    compensator=FRICTION,
    reference=array(least=3),
    sample_time=amount(RUN["sample_time"]),
    lag=amount(RUN["current_lag"]),
    rule=instance(Rule, "a Rule"),
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
    delay: int = 0,
    rule: Rule = WHOLE,
    disturbance: Any = None,
    injected: Any = None,
    start: Start | None = None,
    name: str = "axis",
) -> Experiment:
    """Return the experiment that shows the gain of feedforward and friction compensation.

    Three variants follow the same reference: the loop as recorded; with velocity and inertia feedforward; and with friction
    feedforward along the desired trajectory in addition.

    Parameters
    ----------
    plant, friction : Model
        The simulated axis.
    compensator : Model
        Friction model of the feedforward.
    controller : Model
        Control law of the recorded loop.
    reference : ndarray, shape (sample,)
        Desired position [m or rad].
    sample_time : float
        Sample time [s].
    resolution : float
        One count of the encoder [m or rad].
    effort_limit : float
        Largest effort of the drive [N or N*m].
    lag : float
        Time constant of the drive behind its controller [s].
    delay : int
        Samples from a measurement to its effort.
    rule : Rule
        Share of the friction that is fed forward.
    disturbance : ndarray, shape (sample,), optional
        Force that the friction model does not contain [N or N*m].
    injected : ndarray, shape (sample,), optional
        Known input, added to the output of the controller before the limit of the drive [N or N*m].
    start : Start, optional
        Initial state of the loops; by default the motion of the reference at its start.
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
            settle=settling(duration),
            delay=delay,
            current_lag=lag,
        ),
        disturbance=disturbance,
        injected=injected,
        start=start,
    )
    # A law with an inertia parameter already contains inertia feedforward.
    if "J" in controller.component.variables:
        mass = 0.0
    else:
        mass = plant.values["M"]
    bent = plant if terms_of(plant) else None
    follows = controller
    if "k_ff" in controller.component.variables:
        follows = controller.with_values(k_ff=1.0)
    fed = replace(
        base,
        name=WITH_FEEDFORWARD,
        controller=follows,
        feedforward=Feedforward(mass=mass, plant=bent),
    )
    share = feedforward_of(rule)
    compensated = replace(
        fed,
        name=COMPENSATED,
        feedforward=Feedforward(mass=mass, plant=bent, friction=compensator, **share),
    )
    return Experiment(name=name, kind=kind, variants=(base, fed, compensated))


@guarded(experiment=instance(Experiment, "an Experiment"))
def on_another_rig(experiment: Experiment) -> dict[str, Diagnostic]:
    """Return warnings about compensators identified on a different friction, by the name of the variant."""
    return {
        variant.name: Diagnostic("another_rig", severity="note", kind=variant.plant.kind)
        for variant in experiment.variants
        if variant.feedforward.fitted_to
        and variant.feedforward.fitted_to != digest(without_presliding(variant.friction))
    }


@guarded(plant=model("plant"), effort=array(least=3), sample_time=amount(RUN["sample_time"]))
def open_loop_experiment(
    plant: Model,
    friction: Model,
    effort: Any,
    sample_time: Amount,
    *,
    sensor: Model | None = None,
    name: str = "open loop",
    **run: Any,
) -> Experiment:
    """Return the experiment in which a given effort drives a plant with friction, without a controller.

    Parameters
    ----------
    plant, friction : Model
        The axis.
    effort : array_like, shape (sample,)
        Effort of the drive from each sample until the next one [N or N*m].
    sample_time : float or str
        Time between samples [s].
    sensor : Model, optional
        Sensor of the position; by default an encoder without steps and noise.
    name : str
        Name of the experiment.
    **run : float or str
        Further arguments of `bristle.core.Run`: `tolerance`, the largest error of the position over the whole run [m or
        rad], which sets the steps, or `substeps` of equal length in a sample; `effort_limit` [N or N*m]; `settle`, the
        initial time without statistics [s].

    Raises
    ------
    InputError
        If both a tolerance and a number of steps are given, or if a plant with a screw is given a tolerance.

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
