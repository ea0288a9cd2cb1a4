"""`Experiment`: one or more variants of a loop to be simulated side by side, as data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Literal

import numpy as np

from bristle.core.axis import Axis
from bristle.core.content import Origin
from bristle.core.contracts import Model
from bristle.core.edge import KIND, TEXT, among, amount, array, guarded, instance, many, model, optional, quantity_of, taken, variables_in
from bristle.core.errors import InputError
from bristle.core.variable import Kind, Variable

LOOP_VARIANTS = ("as_recorded", "feedforward", "compensated")
"""Names of the loop of a log: as it was recorded, with inertia fed forward, and with friction as well."""
SAMPLES_MAX = 10_000_000
LONGEST_DELAY = 64.0  # samples: each is a state of the loop, whose poles are looked for with every shorter delay, too
SIDES = ("load", "motor")
ALONG = ("desired", "measured")
RESTS = ("held", "middle")  # Rules for the force of a memoryless friction model at rest; the first one is that of feedforward

OF_A_SAMPLE = 1e-6  # within which times are the same: those told in decimals, or as a mean of differences, are not exact


@guarded()
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
        Integration steps in a sample; 0 stands for as many as `substeps_for` returns, or for those that the
        `tolerance` asks for.
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
    tolerance : float
        Largest error of the position over the whole run [m or rad]: the integration chooses its steps, as an open loop
        may; 0 for `substeps` of equal length.
    """

    duration: float = quantity_of(Variable("time", "simulated time", min=1e-9))
    sample_time: float = quantity_of(Variable("time", "sample time of the controller", min=1e-9))
    substeps: int = quantity_of(Variable("1", "integration steps in a sample", min=1.0, max=10_000.0), 0, count=True)
    delay: int = quantity_of(
        Variable("1", "samples from a measurement to the effort computed from it", min=0.0, max=LONGEST_DELAY), 0, count=True
    )
    effort_limit: float = quantity_of(Variable("force", "largest effort of the drive", min=0.0), math.inf, endless=True)
    settle: float = quantity_of(Variable("time", "time at the start that the statistics leave out", min=0.0), 0.0)
    current_lag: float = quantity_of(Variable("time", "time constant of the current control of the drive", min=0.0), 0.0)
    seeds: int = quantity_of(Variable("1", "runs, each with other noise", min=1.0, max=1000.0), 1, count=True)
    tolerance: float = quantity_of(Variable("length", "largest error of the position, of an open loop", min=0.0), 0.0)

    def __post_init__(self) -> None:
        if self.tolerance and self.substeps:
            message = "stands beside a tolerance, which chooses the steps itself"
            raise InputError(message, path="substeps", value=self.substeps, mend="Leave one of both out")
        if self.substeps == 0 and not self.tolerance:
            object.__setattr__(self, "substeps", substeps_for(self.sample_time))
        if self.duration / self.sample_time > SAMPLES_MAX:
            message, allowed = f"asks for {self.duration / self.sample_time:.3g} samples", f"up to {SAMPLES_MAX} samples"
            raise InputError(message, path="duration", value=self.duration, allowed=allowed)


RUN = variables_in(Run)


@guarded(sample_time=amount(RUN["sample_time"]))
def substeps_for(sample_time: float) -> int:
    """Return how many steps of the integration make up a sample: at least four, none longer than 0.25 ms."""
    return max(4, math.ceil(sample_time / 2.5e-4 - OF_A_SAMPLE))  # of the integration [s]


@guarded()
@dataclass(frozen=True)
class Feedforward:
    """What is fed forward: inertia along the desired trajectory, gravity and cogging, and friction.

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
    rest : {"held", "middle"}
        Force of a memoryless compensator where that motion rests: that of the side it came from, or the mean of both.
    fitted_to : str
        `digest` of the friction that the compensator was identified on, where that is known; "" otherwise.
    plant : Model or None
        A plant whose gravity and cogging are fed forward along the desired trajectory.
    carries : Model or None
        A plant whose effort along the desired trajectory passes through the friction, where that rises with it, fed
        forward or not; where not given, what is fed forward does.
    """

    mass: float = quantity_of(Variable("mass", "mass or inertia times the desired acceleration", min=0.0), 0.0)
    friction: Model | None = taken(optional(model("friction")), None)
    gain: float = quantity_of(Variable("1", "factor on the friction"), 1.0)
    offset: float = quantity_of(Variable("force", "constant that is added to it"), 0.0)
    asymmetry: float = quantity_of(Variable("1", "share by which positive friction is raised and negative lowered", min=-1.0, max=1.0), 0.0)
    limit: float = quantity_of(Variable("force", "largest friction fed forward", min=0.0), math.inf, endless=True)
    rate_limit: float = quantity_of(Variable("force/time", "fastest change of it", min=0.0), math.inf, endless=True)
    conditioning: float = quantity_of(Variable("length", "amplitude of the decaying sweep before the first sample", min=0.0), 0.0)
    along: Literal["desired", "measured"] = taken(among(*ALONG), "desired")
    rest: Literal["held", "middle"] = taken(among(*RESTS), "held")
    fitted_to: str = ""
    plant: Model | None = taken(optional(model("plant")), None)
    carries: Model | None = taken(optional(model("plant")), None)


FEEDFORWARD = variables_in(Feedforward)


@guarded()
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

    trials: int = quantity_of(Variable("1", "trials, of which the last is reported", min=1.0, max=1000.0), count=True)
    k_e: float = quantity_of(Variable("force/length", "effort learned from the following error", min=0.0))
    k_d: float = quantity_of(Variable("force*time/length", "effort learned from its derivative", min=0.0))
    cutoff: float = quantity_of(Variable("frequency", "cut-off of the zero-phase low-pass on what is learned", min=1e-3))


LEARNING = variables_in(Learning)


@guarded(values=array(least=1), description=TEXT)
@dataclass(frozen=True, eq=False)
class Effort:
    """What drives an open loop: the effort of each sample, held until the next one.

    Parameters
    ----------
    values : ndarray, shape (sample,)
        The effort [N or N*m].
    description : str
        What it is, in words for a report.
    """

    values: np.ndarray
    description: str = "given sample by sample"


@guarded(effort=optional(amount(FEEDFORWARD["offset"])))
@dataclass(frozen=True)
class Start:
    """Where a loop begins that takes over a motion.

    Parameters
    ----------
    position, velocity, acceleration : float
        The motion at the first sample [m, m/s, m/s^2 or rad, rad/s, rad/s^2].
    effort : float or None
        Effort that the controller has given until then [N or N*m]: its integral begins with what that takes. None where
        it is not known: the integral is empty.
    """

    position: float = quantity_of(Variable("length", "position at the first sample"))
    velocity: float = quantity_of(Variable("length/time", "velocity at the first sample"), 0.0)
    acceleration: float = quantity_of(Variable("length/time^2", "acceleration at the first sample"), 0.0)
    effort: float | None = None


START = variables_in(Start)


@guarded()
@dataclass(frozen=True)
class Variant:
    """One loop: the mechanism, what controls it, what it is asked to follow.

    Parameters
    ----------
    name : str
        Name of the variant.
    plant, friction, controller, sensor, reference : Model
        The loop; of a plant with a screw, `friction` acts on the motor.
    feedforward : Feedforward
        What is fed forward.
    run : Run
        How long and how finely it is simulated.
    disturbance : ndarray or None, shape (sample,)
        Force against the motion that no model explains, such as the residual of an identification [N or N*m].
    injected : ndarray or None, shape (sample,)
        Known input that joins the output of the controller before the limit of the drive [N or N*m].
    learning : Learning or None
        How the motion is learned, where it is repeated.
    table : Model or None
        Friction of the table of a plant with a screw, in N and m.
    sensor_at : {"load", "motor"}
        Which of both the sensor reads.
    axis : Axis or None
        How a log of it is written.
    effort : Effort or None
        What drives an open loop, in which nothing follows the reference; None in a loop with a controller.
    start : Start or None
        Where the loop begins; None for where its reference does, with an empty integral.
    """

    name: str = taken(TEXT)
    plant: Model = taken(model("plant"))
    friction: Model = taken(model("friction"))
    controller: Model = taken(model("controller"))
    sensor: Model = taken(model("sensor"))
    reference: Model = taken(model("reference"))
    feedforward: Feedforward = taken(instance(Feedforward, "a Feedforward"))
    run: Run = taken(instance(Run, "a Run"))
    disturbance: np.ndarray | None = taken(optional(array()), None)
    injected: np.ndarray | None = taken(optional(array()), None)
    learning: Learning | None = taken(optional(instance(Learning, "a Learning")), None)
    table: Model | None = taken(optional(model("friction")), None)
    sensor_at: str = taken(among(*SIDES), "load")
    axis: Axis | None = taken(optional(instance(Axis, "an Axis")), None)
    effort: Effort | None = taken(optional(instance(Effort, "an Effort")), None)
    start: Start | None = taken(optional(instance(Start, "a Start")), None)

    def first(self, count: int) -> Variant:
        """Return the loop over its first samples."""
        run = replace(self.run, duration=count * self.run.sample_time)
        disturbance, injected = (None if signal is None else signal[:count] for signal in (self.disturbance, self.injected))
        return replace(self, run=run, disturbance=disturbance, injected=injected)

    def is_like(self, second: Variant) -> bool:
        """Return whether a second loop is the same, of efforts and disturbances sample by sample."""
        for field in fields(Variant):
            pair = getattr(self, field.name), getattr(second, field.name)
            if isinstance(pair[0], Effort) and isinstance(pair[1], Effort):
                pair = pair[0].values, pair[1].values
            if isinstance(pair[0], np.ndarray) and isinstance(pair[1], np.ndarray):
                if not np.array_equal(*pair):
                    return False
            elif pair[0] is not pair[1] and pair[0] != pair[1]:
                return False
        return True

    def __post_init__(self) -> None:
        run, mend = self.run, "Write substeps instead of the tolerance"
        screw = f"needs a plant of one mass, and {self.plant.name} has a table behind a screw"
        drive = "stands beside a tolerance, and no drive is part of what that integrates"
        for name, refused, message in (
            ("tolerance", self.effort is None, "is for open loops, which [effort] drives: a controller acts at equal steps"),
            ("tolerance", self.plant.component.screw is not None, screw),
            ("delay", run.delay, drive),
            ("current_lag", run.current_lag, drive),
        ):
            if run.tolerance and refused:
                raise InputError(message, path=f"run.{name}", value=getattr(run, name), mend=mend)


@guarded()
@dataclass(frozen=True)
class Experiment:
    """One or more variants side by side.

    Parameters
    ----------
    name : str
        Name of the experiment.
    kind : {"translational", "rotational"}
        Kind of axis.
    variants : tuple of Variant
        The loops, each with a name of its own.
    source : Path or None
        The file that describes it.
    origins : mapping of str to tuple of Origin
        The files that it was made from, by what they are.
    """

    name: str = taken(TEXT)
    kind: Kind = taken(KIND)
    variants: tuple[Variant, ...] = taken(many(instance(Variant, "a Variant"), single=True))
    source: Path | None = taken(optional(instance(Path, "a path", read=Path)), None)
    origins: Mapping[str, tuple[Origin, ...]] = taken(instance(Mapping, "a mapping"), default_factory=dict)

    def __post_init__(self) -> None:
        names = [variant.name for variant in self.variants]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise InputError("has two of one name", path="variants", value=twice, mend="Give each a name of its own")
