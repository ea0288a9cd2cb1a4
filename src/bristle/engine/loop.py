"""A plant with friction, driven by a recorded effort or by a sampled controller."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core import InputError, Status
from bristle.core.contracts import NOT_KNOWN, Model, Reference
from bristle.core.edge import Amount, among, amount, array, guarded, model, optional, whole
from bristle.core.packing import pack
from bristle.core.tabular import Tabular
from bristle.core.variable import Kind, Variable
from bristle.engine import drivers, entry_points
from bristle.engine.checks import FRICTION, PLACE, SPEED, STATE, STEPS, check_run
from bristle.engine.compilation import compiled, driver
from bristle.engine.drivers import Compensation, Controller, Driven, Sampling, Sensor, Signals
from bristle.engine.entry_points import Compensate, Control, MechanismVectors, Sense, Substeps
from bristle.engine.instance import Instance, entry_of, memory_of
from bristle.engine.screwed import TABLE, through_screw
from bristle.models.controllers.feedforward import Shape

HOLDS = ("zero", "linear")
SIDES = ("load", "motor")
# A sample time of a day indicates a wrong unit, and the required number of steps would take for ever.
SAMPLE_TIME = amount(Variable("time", "sample time", min=0.0, max=1e5), exclusive=True)
MECHANISM = {
    "plant": model("plant"),
    "friction": FRICTION,
    "dt": SAMPLE_TIME,
    "x": PLACE,
    "v": SPEED,
    "state": STATE,
    "memory": optional(array()),
}
DRIVEN = {"effort": array(least=1), "hold": among(*HOLDS)}
FORCE = Variable("force", "effort")


@dataclass(frozen=True, kw_only=True)
class Trace(Tabular):
    """Result of a run; arrays of shape (sample,), in SI units of the axis.

    Parameters
    ----------
    time : ndarray
        Time of the samples [s].
    position, velocity : ndarray
        Position and velocity of the load at the instant of a sample [m, m/s or rad, rad/s]; for a `ball_screw` those of
        the table, converted to the motor.
    effort : ndarray
        Effort of the drive from this sample to the next [N or N*m].
    friction : ndarray
        Mean friction force until the next sample [N or N*m]; for a `ball_screw` the total load of the motor.
    measured : ndarray
        Position as the sensor reads it [m or rad].
    command : ndarray
        Commanded effort [N or N*m].
    motor_position, motor_velocity : ndarray
        Position and velocity of the motor of a `ball_screw`; for other plants equal to those of the load.
    status : Status
        Status at the end of the run.
    state, memory
        State and memory of the friction model at the end of a run with fixed steps, to continue in another run.
    kind : {"translational", "rotational"}
        Kind of axis.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    effort: np.ndarray
    friction: np.ndarray
    measured: np.ndarray
    command: np.ndarray
    motor_position: np.ndarray
    motor_velocity: np.ndarray
    status: Status
    state: Any = None
    memory: np.ndarray | None = None
    kind: Kind = "translational"


@dataclass(frozen=True, kw_only=True)
class LoopTrace(Trace):
    """Result of a closed loop: a `Trace`, and the feedforward.

    Parameters
    ----------
    compensation : ndarray, shape (sample,)
        Effort fed forward along the measured motion [N or N*m].
    controller : Model
        The control law with its learned parameters, for the next run; unchanged after divergence.
    """

    compensation: np.ndarray
    controller: Model


class Compensator(NamedTuple):
    """A friction model that is fed forward along the measured motion, and its state before the first sample.

    `transmitted` is the effort that the desired motion transmits to the load at each sample; zero by default.
    """

    friction: Model
    shape: Shape
    state: Any = None
    memory: np.ndarray | None = None
    transmitted: np.ndarray | None = None


class _Mechanism:
    """Plant and friction as an entry with its vectors."""

    def __init__(
        self,
        plant: Model,
        friction: Model,
        table: Model | None,
        x: float,
        v: float,
        state: Any,
        memory: Any,
    ) -> None:
        has_screw = table is not None or plant.component.screw is not None
        friction = through_screw(plant, friction, table) if has_screw else friction
        self.plant, self.friction = Instance(plant), Instance(friction)
        if plant.component.State._fields[:2] != ("x", "v"):
            raise TypeError(f"the state of plant {plant.name} must begin with x and v")
        self.plant.state[0], self.plant.state[1] = x, v
        self.friction.begin(state)
        if state is None and has_screw:
            self.friction.state[TABLE] = x, v
        self.load = self.friction.state[TABLE] if has_screw else self.plant.state
        self.memory = memory_of(friction, memory)
        self.out = np.zeros(entry_points.OUT_SIZE)
        self.entry = substeps_entry(self.plant, self.friction)

    @property
    def driven(self) -> Driven:
        return Driven(
            self.entry, vectors_of(self.plant, self.friction, self.memory, self.out), self.load
        )

    def signals(self, rows: np.ndarray, reached: int, dt: float) -> dict[str, Any]:
        """Return the signals of a `Trace` from the history of a run that reached `reached` samples."""
        return {
            "time": dt * np.arange(reached),
            **dict(zip(SIGNALS, rows[:, :reached], strict=False)),
            "status": self.status(reached, rows.shape[1]),
            "state": self.friction.state_now,
            "memory": self.memory,
            "kind": self.friction.model.kind,
        }

    def status(self, reached: int, count: int) -> Status:
        if reached < count or not np.all(np.isfinite(self.plant.state)):
            return Status.NOT_FINITE
        if self.friction.lost:
            return Status.MEMORY_OVERFLOW
        return Status.SOLVE_INACCURATE if self.out[entry_points.FAILED_SO_FAR] > 0.0 else Status.OK


SIGNALS = (
    "position",
    "velocity",
    "measured",
    "command",
    "effort",
    "friction",
    "motor_position",
    "motor_velocity",
)


def substeps_entry(plant: Instance, friction: Instance) -> Substeps:
    """Return the entry that advances this mechanism."""
    return compiled(
        f"substeps-efim-{plant.key}-{friction.key}",
        lambda: entry_points.make_substeps(*plant.structures, *friction.structures),
        Substeps,
        plant.functions + friction.functions,
    )


def vectors_of(
    plant: Instance, friction: Instance, memory: np.ndarray, out: np.ndarray
) -> MechanismVectors:
    """Return the vectors of a plant with friction, which a run changes."""
    return MechanismVectors(
        plant.parameters, plant.state, friction.parameters, friction.state, memory, out
    )


def held(effort: np.ndarray, hold: str) -> np.ndarray:
    """Return the effort [N or N*m] at the end of each sample, with samples along the first dimension."""
    return (
        effort
        if hold == "zero"
        else np.ascontiguousarray(np.concatenate((effort[1:], effort[-1:])))
    )


@guarded(**MECHANISM, **DRIVEN, steps=STEPS, table=optional(FRICTION))
def run_open_loop(
    plant: Model,
    friction: Model,
    effort: Any,
    dt: Amount,
    *,
    steps: int = 1,
    hold: str = "zero",
    table: Model | None = None,
    x: Amount = 0.0,
    v: Amount = 0.0,
    state: Any = None,
    memory: Any = None,
) -> Trace:
    """Drive a plant with friction by a recorded effort.

    Parameters
    ----------
    plant, friction : Model
        The mechanism.
    table : Model, optional
        Friction of the table of a `ball_screw`, in N and m; `friction` then belongs to the motor.
    effort : array_like, shape (sample,)
        Effort [N or N*m] at each sample.
    dt : float or str
        Time between samples [s].
    steps : int
        Integration steps between two samples.
    hold : {"zero", "linear"}
        Effort between samples: constant (a drive), or linear to the next sample (a smooth record).
    x, v : float or str
        Position [m or rad] and velocity [m/s or rad/s] at the first sample.
    state, memory
        State and memory of the friction model at the first sample; virgin by default.

    Returns
    -------
    Trace
        Position, velocity, effort and friction at each sample.
    """
    u, u_end = effort, held(effort, hold)
    mechanism = _Mechanism(plant, friction, table, x, v, state, memory)
    history = np.zeros(drivers.ROWS * u.size)
    reached = int(
        driver(drivers.open_loop)(mechanism.driven, u, u_end, float(dt), int(steps), history)
    )
    rows = history.reshape(drivers.ROWS, u.size)
    rows[drivers.MEASURED], rows[drivers.COMMAND] = rows[drivers.POSITION], u
    return Trace(**mechanism.signals(rows, reached, dt))


@guarded(
    **MECHANISM,
    controller=model("controller"),
    sensor=model("sensor"),
    reference=array(ndim=2, least=1),
    table=optional(FRICTION),
    sensor_at=among(*SIDES),
    steps=STEPS,
    injected=optional(array()),
    disturbance=optional(array()),
    limit=amount(Variable("force", "largest effort", min=0.0), endless=True),
    delay=whole(0, 10**6),
    lag=amount(Variable("time", "lag of the drive", min=0.0)),
    effort_before=amount(FORCE),
    resumed_effort=optional(amount(FORCE)),
    acceleration=amount(Variable("length/time^2", "acceleration")),
)
def run_closed_loop(
    plant: Model,
    friction: Model,
    controller: Model,
    sensor: Model,
    reference: Any,
    dt: Amount,
    *,
    table: Model | None = None,
    sensor_at: str = "load",
    steps: int = 1,
    compensator: Compensator | None = None,
    injected: Any = None,
    disturbance: Any = None,
    limit: Amount = np.inf,
    delay: int = 0,
    lag: Amount = 0.0,
    effort_before: Amount = 0.0,
    resumed_effort: Amount | None = None,
    x: Amount = 0.0,
    v: Amount = 0.0,
    acceleration: Amount = 0.0,
    state: Any = None,
    memory: Any = None,
) -> LoopTrace:
    """Run a sampled control loop on a plant with friction.

    Parameters
    ----------
    plant, friction, controller, sensor : Model
        The loop.
    reference : array_like, shape (4, sample)
        Position, velocity, acceleration and feedforward effort at each sample.
    dt : float or str
        Sample time [s].
    table : Model, optional
        Friction of the table of a `ball_screw`, in N and m; `friction` then belongs to the motor.
    sensor_at : {"load", "motor"}
        Whether the sensor reads the table of a `ball_screw` or its motor.
    steps : int
        Integration steps in a sample.
    compensator : Compensator, optional
        Friction that is fed forward along the measured motion, in addition to the effort in `reference`.
    injected : array_like, shape (sample,), optional
        Known effort added to the output of the controller [N or N*m].
    disturbance : array_like, shape (sample,), optional
        Unmeasured force on the plant against its effort [N or N*m].
    limit : float or str
        Largest effort of the drive [N or N*m].
    delay : int
        Samples from a measurement to the effort computed from it.
    lag : float or str
        Time constant with which the effort of the drive follows its command [s].
    effort_before : float or str
        Effort that acts until the first computed effort arrives [N or N*m].
    resumed_effort : float or str, optional
        Last effort of the controller before the run [N or N*m], to initialize its integral; by default the integral is
        empty.
    x, v : float or str
        Position [m or rad] and velocity [m/s or rad/s] at the first sample.
    acceleration : float or str
        Acceleration at the first sample, for the memory of the controller [m/s^2 or rad/s^2].
    state, memory
        State and memory of the friction model at the first sample; virgin by default.

    Returns
    -------
    LoopTrace
        Signals at each sample; if the loop diverged, they end there, with a status.
    """
    if reference.shape[0] != 4:
        raise InputError(
            "needs four rows: position, velocity, acceleration, effort",
            path="reference",
            value=reference.shape,
            allowed="(4, sample)",
        )
    count = reference.shape[1]
    mechanism = _Mechanism(plant, friction, table, x, v, state, memory)
    control, sense = Instance(controller), Instance(sensor)
    started = sensor.component.step(
        sensor.component.initial_state(sensor.parameters), x, dt, sensor.parameters
    )[0]
    control.state = pack(
        begun(controller, Reference(*reference[:, 0]), started, v, acceleration, resumed_effort, dt)
    )
    extra, unseen = (
        np.zeros(count) if signal is None else signal for signal in (injected, disturbance)
    )
    check_run(count, injected=extra, disturbance=unseen)
    mechanism.out[entry_points.DRIVE_LAG], mechanism.out[entry_points.DRIVE_EFFORT] = (
        lag,
        effort_before,
    )
    history = np.zeros(drivers.ROWS * count)
    reading = mechanism.load if sensor_at == "load" else mechanism.plant.state
    reached = int(
        driver(drivers.closed_loop)(
            Controller(
                entry_of("control", control, Control, entry_points.make_control),
                control.parameters,
                control.state,
            ),
            _compensation(compensator, started, count),
            Sensor(
                entry_of("sense", sense, Sense, entry_points.make_sense),
                sense.parameters,
                sense.state,
                reading,
            ),
            mechanism.driven,
            Signals(reference.ravel(), extra, unseen),
            Sampling(float(dt), int(steps), int(delay), float(limit), float(effort_before)),
            history,
        )
    )
    rows, law, learned = (
        history.reshape(drivers.ROWS, count),
        controller,
        controller.component.learned,
    )
    if learned is not None and reached == count:
        law = replace(controller, parameters=learned(control.state_now, controller.parameters))
    return LoopTrace(
        **mechanism.signals(rows, reached, dt),
        compensation=rows[drivers.FED, :reached],
        controller=law,
    )


def begun(
    controller: Model,
    reference: Reference,
    measured: float,
    v: float,
    acceleration: float,
    resumed_effort: float | None,
    dt: float,
) -> Any:
    """Return the state of a control law that takes over a motion and, if known, the `resumed_effort`."""
    component, p = controller.component, controller.parameters
    state = component.start(measured, v, acceleration, dt, p)
    if component.resume is None:
        return state
    effort = NOT_KNOWN if resumed_effort is None else resumed_effort
    return component.resume(state, reference, measured, effort, dt, p)


def _compensation(compensator: Compensator | None, measured: float, count: int) -> Compensation:
    """Return the compensator of a loop; `measured` is the position at the first sample."""
    if compensator is None:
        empty = np.zeros(0)
        entry = compiled("compensate_nothing", lambda: entry_points.compensate_nothing, Compensate)
        return Compensation(entry, empty, empty, empty, empty, np.zeros(count))
    part = Instance(compensator.friction)
    part.begin(compensator.state)
    entry = entry_of("compensate", part, Compensate, entry_points.make_compensate)
    memory = memory_of(compensator.friction, compensator.memory)
    shape = np.array((*compensator.shape, measured, 0.0, 0.0))
    transmitted = np.zeros(count) if compensator.transmitted is None else compensator.transmitted
    check_run(count, transmitted=transmitted)
    return Compensation(entry, part.parameters, part.state, memory, shape, transmitted)


def sensed(sensor: Model, x: np.ndarray, dt: float) -> np.ndarray:
    """Return the reading of a sensor for the position at each sample [m or rad]."""
    part, readings = Instance(sensor), np.empty(x.size)
    entry = Sensor(
        entry_of("sense", part, Sense, entry_points.make_sense), part.parameters, part.state, x
    )
    driver(drivers.readings)(entry, float(dt), readings)
    return readings
