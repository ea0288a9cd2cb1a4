"""`Experiment`: variants of a loop to simulate and compare, as data."""

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
from bristle.core.edge import (
    KIND,
    TEXT,
    among,
    amount,
    array,
    guarded,
    instance,
    many,
    model,
    optional,
    quantity_of,
    taken,
    variables_in,
)
from bristle.core.errors import InputError
from bristle.core.variable import Kind, Variable

LOOP_VARIANTS = ("as_recorded", "feedforward", "compensated")
"""Names of the variants for a log: as recorded, with feedforward of inertia, and with friction too."""
SAMPLES_MAX = 10_000_000
LONGEST_DELAY = 64.0  # samples: each adds a state to the loop; the poles are computed for every shorter delay, too
SIDES = ("load", "motor")
ALONG = ("desired", "measured")
SCALED = ("force", "contact")  # what the gain of a friction feedforward scales
# Rules for the force of a memoryless friction model at rest; the first is the default of feedforward.
RESTS = ("held", "middle")

OF_A_SAMPLE = (
    1e-6  # tolerance of equal times, because decimals and means of differences are not exact
)


@guarded()
@dataclass(frozen=True)
class Run:
    """Duration and steps of a simulation.

    Parameters
    ----------
    duration : float
        Simulated time [s].
    sample_time : float
        Sample time of the controller [s].
    substeps : int
        Integration steps per sample. With 0, `substeps_for` or, if set, the `tolerance` determines the number.
    delay : int
        Number of samples from a measurement to the effort computed from it. The feedforward is known in advance, so the
        controller receives it earlier by this number of samples.
    effort_limit : float
        Largest effort of the drive [N or N*m].
    settle : float
        Time at the start that the statistics exclude [s].
    current_lag : float
        Time constant of the current control of the drive [s].
    seeds : int
        Number of runs with different noise: run `i` adds `i` to the seeds of sensor and friction.
    tolerance : float
        Largest error of the position over the whole run [m or rad], for adaptive integration of an open loop. 0 selects
        `substeps` of equal length.
    """

    duration: float = quantity_of(Variable("time", "simulated time", min=1e-9))
    sample_time: float = quantity_of(Variable("time", "sample time of the controller", min=1e-9))
    substeps: int = quantity_of(
        Variable("1", "integration steps per sample", min=1.0, max=10_000.0), 0, count=True
    )
    delay: int = quantity_of(
        Variable("1", "samples from a measurement to its effort", min=0.0, max=LONGEST_DELAY),
        0,
        count=True,
    )
    effort_limit: float = quantity_of(
        Variable("force", "largest effort of the drive", min=0.0), math.inf, endless=True
    )
    settle: float = quantity_of(
        Variable("time", "time at the start that the statistics exclude", min=0.0), 0.0
    )
    current_lag: float = quantity_of(
        Variable("time", "time constant of the current control of the drive", min=0.0), 0.0
    )
    seeds: int = quantity_of(
        Variable("1", "number of runs with different noise", min=1.0, max=1000.0), 1, count=True
    )
    tolerance: float = quantity_of(
        Variable("length", "largest error of the position in an open loop", min=0.0), 0.0
    )

    def __post_init__(self) -> None:
        if self.tolerance and self.substeps:
            raise InputError(
                "conflicts with the tolerance, which determines the steps",
                path="substeps",
                value=self.substeps,
                mend="Remove substeps or tolerance",
            )
        if self.substeps == 0 and not self.tolerance:
            object.__setattr__(self, "substeps", substeps_for(self.sample_time))
        if self.duration < self.sample_time * (1.0 - OF_A_SAMPLE):
            raise InputError(
                "is shorter than a sample",
                path="duration",
                value=self.duration,
                allowed=f">= {self.sample_time:g} s, the sample time",
                mend="Check the units",
            )
        if self.settle and self.settle >= self.duration:
            raise InputError(
                "leaves nothing of the run",
                path="settle",
                value=self.settle,
                allowed=f"< {self.duration:g} s, the duration",
            )
        if self.duration / self.sample_time > SAMPLES_MAX:
            raise InputError(
                f"gives {self.duration / self.sample_time:.3g} samples at this sample time",
                path="duration",
                value=self.duration,
                allowed=f"up to {SAMPLES_MAX} samples",
            )


RUN = variables_in(Run)


@guarded(sample_time=amount(RUN["sample_time"]))
def substeps_for(sample_time: float) -> int:
    """Return the number of integration steps per sample: at least four, each at most 0.25 ms long."""
    return max(4, math.ceil(sample_time / 2.5e-4 - OF_A_SAMPLE))  # of the integration [s]


@guarded()
@dataclass(frozen=True)
class Feedforward:
    """Feedforward of inertia, gravity and cogging along the desired trajectory, and of friction.

    Parameters
    ----------
    mass : float
        Mass or inertia times the desired acceleration [kg or kg*m^2].
    friction : Model or None
        Compensator: a friction model along the desired or measured motion.
    gain : float
        Factor of the friction, or of its contact force.
    scaled : {"force", "contact"}
        What `gain` scales: the force of the friction model, or its contact force. The contact force is the force without
        the constant part and the viscous part of the model, which are then fed forward whole.
    return_distance : float
        Travel constant of the return of the factor to `gain` after a rest [m or rad]: a travel of three times this
        distance covers 95 % of the difference. With 0, the factor is constant.
    fade_time : float
        Time constant with which the factor falls to 0 while the motion rests [s]; infinite for a factor that stays.
    asymmetry : float
        Share by which positive friction increases and negative friction decreases.
    offset : float
        Constant added to the friction [N or N*m].
    limit : float
        Largest friction feedforward [N or N*m].
    rate_limit : float
        Fastest change of the friction feedforward [N/s or N*m/s].
    conditioning : float
        Amplitude of a decaying sweep that conditions the memory of the compensator before the run [m or rad]; 0 for a
        virgin memory.
    along : {"desired", "measured"}
        Input motion of the compensator.
    rest : {"held", "middle"}
        Force at rest of a compensator without memory: that of the last direction (``held``), or the mean of both directions.
    fitted_to : str
        `digest` of the friction that the compensator was identified on, or "" if unknown.
    plant : Model or None
        Plant for feedforward of gravity and cogging along the desired trajectory. A `ball_screw` replaces `mass`: both of its
        masses and the wind-up of its screw are fed forward.
    carries : Model or None
        Plant that computes the transmitted effort along the desired trajectory, if the friction depends on this effort.
        The default is the feedforward effort.
    table : Model or None
        Compensator of the friction of the table of a `ball_screw`, in N and m, along the desired motion.
        `gain` and `asymmetry` apply to both frictions.
    wind_up_time : float
        Time over which the wind-up of the screw reverses [s]. With 0, the largest effort of the motion sets this time.
    """

    mass: float = quantity_of(
        Variable("mass", "mass or inertia times the desired acceleration", min=0.0), 0.0
    )
    friction: Model | None = taken(optional(model("friction")), None)
    gain: float = quantity_of(Variable("1", "factor of the friction"), 1.0)
    scaled: Literal["force", "contact"] = taken(among(*SCALED), "force")
    return_distance: float = quantity_of(
        Variable("length", "travel constant of the return of the factor after a rest", min=0.0), 0.0
    )
    fade_time: float = quantity_of(
        Variable("time", "time constant of the fall of the factor at rest", min=0.0),
        math.inf,
        endless=True,
    )
    offset: float = quantity_of(Variable("force", "constant added to the friction"), 0.0)
    asymmetry: float = quantity_of(
        Variable(
            "1",
            "share by which positive friction increases and negative decreases",
            min=-1.0,
            max=1.0,
        ),
        0.0,
    )
    limit: float = quantity_of(
        Variable("force", "largest friction feedforward", min=0.0), math.inf, endless=True
    )
    rate_limit: float = quantity_of(
        Variable("force/time", "fastest change of the friction feedforward", min=0.0),
        math.inf,
        endless=True,
    )
    conditioning: float = quantity_of(
        Variable("length", "amplitude of the decaying sweep before the first sample", min=0.0), 0.0
    )
    along: Literal["desired", "measured"] = taken(among(*ALONG), "desired")
    rest: Literal["held", "middle"] = taken(among(*RESTS), "held")
    fitted_to: str = ""
    plant: Model | None = taken(optional(model("plant")), None)
    carries: Model | None = taken(optional(model("plant")), None)
    table: Model | None = taken(optional(model("friction")), None)
    wind_up_time: float = quantity_of(
        Variable("time", "time over which the wind-up of a screw reverses", min=0.0), 0.0
    )

    def __post_init__(self) -> None:
        has_screw = self.plant is not None and self.plant.component.screw is not None
        if self.table is not None and not has_screw:
            name = self.plant and self.plant.name
            raise InputError(
                "needs a plant with a table behind a screw",
                path="feedforward.table",
                value=name,
                allowed="ball_screw",
                mend="Feed a ball_screw forward, or omit the friction of the table",
            )
        if self.table is not None and self.table.kind != "translational":
            raise InputError(
                "must be translational",
                path="feedforward.table",
                value=f"{self.table.name}, {self.table.kind}",
                mend="The table travels: its friction is in N and m",
            )
        if has_screw and self.mass:
            raise InputError(
                "conflicts with a plant that has two masses",
                path="feedforward.mass",
                value=self.mass,
                mend="Omit mass: the plant contains the masses of motor and table",
            )


FEEDFORWARD = variables_in(Feedforward)


@guarded()
@dataclass(frozen=True)
class Learning:
    """Iterative learning of a repeated motion.

    Parameters
    ----------
    trials : int
        Number of trials; the last trial is reported.
    k_e : float
        Learning gain for the following error [N/m or N*m/rad].
    k_d : float
        Learning gain for the derivative of the following error [N*s/m or N*m*s/rad].
    cutoff : float
        Cut-off of the zero-phase low-pass filter of the learned effort [Hz].
    """

    trials: int = quantity_of(Variable("1", "number of trials", min=1.0, max=1000.0), count=True)
    k_e: float = quantity_of(
        Variable("force/length", "learning gain for the following error", min=0.0)
    )
    k_d: float = quantity_of(
        Variable(
            "force*time/length", "learning gain for the derivative of the following error", min=0.0
        )
    )
    cutoff: float = quantity_of(
        Variable(
            "frequency", "cut-off of the zero-phase low-pass filter of the learned effort", min=1e-3
        )
    )


LEARNING = variables_in(Learning)


@guarded(values=array(least=1))
@dataclass(frozen=True, eq=False)
class Effort:
    """Effort of an open loop: a value per sample, constant until the next sample.

    Parameters
    ----------
    values : ndarray, shape (sample,)
        The effort [N or N*m].
    description : str
        Description for a report.
    """

    values: np.ndarray
    description: str = "given sample by sample"


@guarded(effort=optional(amount(FEEDFORWARD["offset"])))
@dataclass(frozen=True)
class Start:
    """Start of a loop that takes over a motion.

    Parameters
    ----------
    position, velocity, acceleration : float
        The motion at the first sample [m, m/s, m/s^2 or rad, rad/s, rad/s^2].
    effort : float or None
        Effort of the controller before the first sample [N or N*m], which sets the start of its integral. None
        (unknown) starts with an integral of zero.
    """

    position: float = quantity_of(Variable("length", "position at the first sample"))
    velocity: float = quantity_of(Variable("length/time", "velocity at the first sample"), 0.0)
    acceleration: float = quantity_of(
        Variable("length/time^2", "acceleration at the first sample"), 0.0
    )
    effort: float | None = None


START = variables_in(Start)


@guarded()
@dataclass(frozen=True)
class Coupling:
    """Elastic coupling between the motor and the load of an axis that is simulated as one mass.

    Parameters
    ----------
    antiresonance : float
        Frequency at which the load vibrates on the held motor [Hz].
    inertia_ratio : float
        Inertia of the load over that of the motor.
    """

    antiresonance: float = quantity_of(
        Variable("frequency", "antiresonance of motor and load", min=1e-9)
    )
    inertia_ratio: float = quantity_of(
        Variable("1", "inertia of the load over that of the motor", min=1e-9)
    )


COUPLING = variables_in(Coupling)


@guarded()
@dataclass(frozen=True)
class Variant:
    """A loop: mechanism, controller and reference.

    Parameters
    ----------
    name : str
        Name of the variant.
    plant, friction, controller, sensor, reference : Model
        Models of the loop; in a plant with a screw, `friction` acts on the motor.
    feedforward : Feedforward
        Feedforward of the controller.
    run : Run
        Duration and steps of the simulation.
    disturbance : ndarray or None, shape (sample,)
        Unexplained force against the motion, such as the residual of an identification [N or N*m].
    injected : ndarray or None, shape (sample,)
        Known input added to the output of the controller before the limit of the drive [N or N*m].
    learning : Learning or None
        Iterative learning of a repeated motion.
    table : Model or None
        Friction of the table of a plant with a screw, in N and m.
    sensor_at : {"load", "motor"}
        Side of the sensor.
    axis : Axis or None
        Axis for writing its log.
    effort : Effort or None
        Effort of an open loop, which ignores the reference; None in a loop with a controller.
    start : Start or None
        Start of the loop; None starts on the reference with an integral of zero.
    coupling : Coupling or None
        Elastic coupling of the load, for proposed gains.
    draws : mapping of str to array_like, shape (member,) or (member, element)
        Draws of the parameters of the friction from its identification [SI]; empty if its uncertainty is unknown.
    """

    name: str = taken(TEXT)
    plant: Model = taken(model("plant"))
    friction: Model = taken(model("friction"))
    controller: Model = taken(model("controller"))
    sensor: Model = taken(model("sensor"))
    reference: Model = taken(model("reference"))
    feedforward: Feedforward = taken(instance(Feedforward, "an object of class Feedforward"))
    run: Run = taken(instance(Run, "an object of class Run"))
    disturbance: np.ndarray | None = taken(optional(array()), None)
    injected: np.ndarray | None = taken(optional(array()), None)
    learning: Learning | None = taken(
        optional(instance(Learning, "an object of class Learning")), None
    )
    table: Model | None = taken(optional(model("friction")), None)
    sensor_at: str = taken(among(*SIDES), "load")
    axis: Axis | None = taken(optional(instance(Axis, "an Axis")), None)
    effort: Effort | None = taken(optional(instance(Effort, "an Effort")), None)
    start: Start | None = taken(optional(instance(Start, "an object of class Start")), None)
    coupling: Coupling | None = taken(
        optional(instance(Coupling, "an object of class Coupling")), None
    )
    draws: Mapping[str, np.ndarray] = taken(
        instance(Mapping, "a mapping"), default_factory=dict, compare=False
    )

    def first(self, count: int) -> Variant:
        """Return the loop for its first `count` samples."""
        settle = min(self.run.settle, (count - 1) * self.run.sample_time)
        run = replace(self.run, duration=count * self.run.sample_time, settle=settle)
        disturbance, injected = (
            None if signal is None else signal[:count]
            for signal in (self.disturbance, self.injected)
        )
        return replace(self, run=run, disturbance=disturbance, injected=injected)

    def is_like(self, second: Variant) -> bool:
        """Return whether a second loop runs alike: it is equal, including the samples of efforts and disturbances."""
        for field in (field for field in fields(Variant) if field.compare):
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
        screw = f"needs a plant with one mass, but {self.plant.name} has a table behind a screw"
        drive = (
            "conflicts with the tolerance, because adaptive integration cannot include the drive"
        )
        for name, refused, message in (
            (
                "tolerance",
                self.effort is None,
                "is only for open loops with [effort], because a controller needs equal steps",
            ),
            ("tolerance", self.plant.component.screw is not None, screw),
            ("delay", run.delay, drive),
            ("current_lag", run.current_lag, drive),
        ):
            if run.tolerance and refused:
                raise InputError(message, path=f"run.{name}", value=getattr(run, name), mend=mend)


@guarded()
@dataclass(frozen=True)
class Experiment:
    """Variants of a loop to compare.

    Parameters
    ----------
    name : str
        Name of the experiment.
    kind : {"translational", "rotational"}
        Kind of axis.
    variants : tuple of Variant
        The loops, with unique names.
    source : Path or None
        Its file.
    origins : mapping of str to tuple of Origin
        Its input files, by role.
    """

    name: str = taken(TEXT)
    kind: Kind = taken(KIND)
    variants: tuple[Variant, ...] = taken(
        many(instance(Variant, "an object of class Variant"), single=True)
    )
    source: Path | None = taken(optional(instance(Path, "a path", read=Path)), None)
    origins: Mapping[str, tuple[Origin, ...]] = taken(
        instance(Mapping, "a mapping"), default_factory=dict
    )

    def __post_init__(self) -> None:
        names = [variant.name for variant in self.variants]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise InputError(
                "has two variants with the same name",
                path="variants",
                value=twice,
                mend="Give each variant a unique name",
            )
        odd = next((variant for variant in self.variants if variant.plant.kind != self.kind), None)
        if odd is not None:
            raise InputError(
                f"is not the kind of the variant {odd.name}",
                path="kind",
                value=self.kind,
                allowed=odd.plant.kind,
            )
