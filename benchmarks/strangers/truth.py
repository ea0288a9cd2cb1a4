"""What is true of a made axis, and what its drive recorded of it. SI throughout: m or rad, N or N*m, kg or kg*m^2."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "FAMILIES",
    "MOTIONS",
    "Axis",
    "Encoder",
    "Friction",
    "Loop",
    "Motion",
    "Motor",
    "Record",
    "Recording",
    "Truth",
]

Floats = NDArray[np.float64]

FAMILIES = (
    "coulomb",
    "lugre",
    "maxwell",
    "lag",
    "ripple",
    "root_viscous",
    "stribeck_half",
    "stribeck_cubic",
    "backlash",
    "heat",
)
MOTIONS = ("strokes", "multisine", "sine", "presliding", "cycle", "one_speed", "one_direction")


@dataclass(frozen=True)
class Axis:
    """The moved body. Positions are those of the load side; `turn` is the travel per motor turn [m or rad].

    `mass` is all that moves. With play (`half_play` > 0) the share `load_share` of mass and friction sits behind the
    play, the encoder on the motor before it, and gravity pulls at the load.
    """

    linear: bool
    mass: float  # [kg or kg*m^2]
    turn: float  # [m or rad]
    gravity: float = 0.0  # [N or N*m], pulls towards negative positions
    cogging: float = 0.0  # [N or N*m]
    cogging_per_turn: int = 6
    cogging_phase: float = 0.0  # [rad]
    half_play: float = 0.0  # [m or rad]: the load may stand this far to either side of the middle
    load_share: float = 0.0
    contact_stiffness: float = 0.0  # [N/m or N*m/rad]
    contact_damping: float = 0.0  # [N*s/m or N*m*s/rad]


@dataclass(frozen=True)
class Friction:
    """The friction law: `law` is "static" (a jump at zero), "lugre" or "cells" (Maxwell slip under a Stribeck level).

    Pairs are (positive, negative) velocity. The level is F_C + (F_S - F_C) exp(-(w/v_S)^shape), where w = |velocity|,
    or |velocity| through a first-order lag of `lag` seconds. The level is multiplied by `heat` at the time, by a new
    1 + scatter * normal after each reversal, and by 1 + ripple * sin(2 pi q / ripple_period + ripple_phase). Viscous
    friction is F_v velocity + F_root velocity/sqrt(|velocity| + root_floor), multiplied by `heat` only.
    """

    law: str
    F_C: tuple[float, float]
    F_S: tuple[float, float]
    v_S: float
    shape: float
    F_v: tuple[float, float]
    F_root: float = 0.0  # [N/(m/s)^0.5]
    root_floor: float = 1.0  # [m/s]
    sigma_0: float = 0.0  # [N/m]
    sigma_1: float = 0.0  # [N*s/m]
    cell_stiffness: tuple[float, ...] = ()  # [N/m]
    cell_share: tuple[float, ...] = ()  # of the level, together 1
    cell_damping: float = (
        0.0  # [s]: force of a cell = stiffness * (deflection + cell_damping * its rate)
    )
    lag: float = 0.0  # [s]
    ripple: float = 0.0
    ripple_period: float = 1.0  # [m or rad]
    ripple_phase: float = 0.0  # [rad]
    heat: tuple[float, float] = (1.0, 1.0)  # level at the first and the last recorded instant
    heat_time: float = 1.0  # [s]: of the exponential between them
    scatter: float = 0.0
    reversal_travel: float = 0.0  # [m or rad]: a reversal counts after this much travel back
    break_away: float = 0.0  # [m or rad]: distance over which the pre-sliding force builds up


@dataclass(frozen=True)
class Motor:
    """The torque loop: first-order lag, noise of its command, ripple in proportion to the force, and the limit."""

    lag: float  # [s]
    noise: float  # [N or N*m] rms, new at each tick of the loop
    ripple: float
    ripple_per_turn: int
    ripple_phase: float
    rated: float  # [N or N*m]
    limit: float  # [N or N*m]


@dataclass(frozen=True)
class Loop:
    """The controller at a fixed tick. Cascade: u = kv (kp e + v_ref - v) + ki integral + mass a_ref; PID likewise.

    `kind` "cascade": kp [1/s], kv [N*s/m], ki [N/m]. "pid": kp [N/m], kv [N*s/m], ki [N/(m*s)]. A command acts
    `delay` ticks after the tick that sampled the encoder, and is held for a tick.
    """

    kind: str
    period: float  # [s]
    delay: int
    kp: float
    kv: float
    ki: float
    velocity_filter: float  # [s], first-order, on the difference quotient of the encoder
    feed_velocity: float  # 0 or 1
    feed_mass: float  # [kg or kg*m^2]


@dataclass(frozen=True)
class Encoder:
    """A counter of `resolution`, whose error repeats 1, 2 and 16 times per `period` of travel."""

    resolution: float  # [m or rad] per count
    period: float  # [m or rad]
    amplitudes: tuple[float, float, float]  # [counts]
    phases: tuple[float, float, float]  # [rad]


@dataclass(frozen=True)
class Motion:
    """The reference: see `benchmarks.strangers.motion`."""

    kind: str
    duration: float  # [s], recorded
    lead: float  # [s] of standstill before the record, to let the loop settle
    speeds: tuple[float, ...] = ()  # [m/s or rad/s]
    acceleration: float = 1.0
    smoothing: float = 0.02  # [s]: jerk phase
    stroke: float = 0.0  # [m or rad]
    dwell: float = 0.1  # [s]
    frequencies: tuple[float, ...] = ()  # [Hz]
    amplitudes: tuple[float, ...] = ()  # [m or rad]
    phases: tuple[float, ...] = ()  # [rad]


@dataclass(frozen=True)
class Recording:
    """What the drive's trace does to the signals.

    `source` "command": the effort of a row is the command computed at its instant, which acts from `Loop.delay` ticks
    later. "acted": the mean of the force (without torque ripple) over the last loop tick before the row's instant (or
    the last half of one where the trace runs at twice the loop's rate). `effort_late` is in rows of the trace before
    decimation, that is in `trace_period`; `effort_filter` and `position_filter` are first-order and run at it too.
    """

    trace_period: float  # [s]
    per_tick: int  # rows of the trace per loop tick: 1 or 2
    every: int  # one row in so many is kept
    source: str
    effort_late: int
    effort_filter: float  # [s]
    position_filter: float  # [s]
    effort_noise: float  # [N or N*m] rms, of the sensor: not in the axis
    force_per_effort: float  # [N or N*m per recorded unit]
    effort_unit: str
    reference: bool
    velocity: bool
    jitter: float = 0.0  # [s] rms of the stamps
    lost: tuple[
        tuple[int, int], ...
    ] = ()  # (first row, count) dropped before the rest was stamped again


@dataclass(frozen=True)
class Truth:
    """Everything true of one record."""

    seed: int
    family: str
    axis: Axis
    friction: Friction
    motor: Motor
    loop: Loop
    encoder: Encoder
    motion: Motion
    recording: Recording

    @property
    def mass(self) -> float:
        """All that moves [kg or kg*m^2]."""
        return self.axis.mass

    @property
    def period(self) -> float:
        """The time between recorded rows [s]."""
        return self.recording.trace_period * self.recording.every

    @property
    def effort_lead(self) -> float:
        """By how much the recorded effort runs ahead of the force on the axis at the stamp [s]; negative: behind.

        Hold, lags and filters are counted with their mean delay, as a slow signal sees them.
        """
        late = self.recording.effort_late * self.recording.trace_period + self._filter_delay(
            self.recording.effort_filter
        )
        if self.recording.source == "command":
            tick = self.loop.period
            # Seen at the ticks, a held command is half a tick late; rows between ticks repeat the last one.
            repeated = 0.5 * tick * (1.0 - 1.0 / self.recording.per_tick)
            return (self.loop.delay + 0.5) * tick - repeated + self.motor.lag - late
        return -0.5 * self.recording.trace_period - late

    @property
    def position_lag(self) -> float:
        """By how much the recorded position is behind the true one at the stamp [s], as a slow signal sees it."""
        return self._filter_delay(self.recording.position_filter)

    def _filter_delay(self, tau: float) -> float:
        """A first-order filter as drives compute it takes the newest row in at once: half a row less than tau."""
        if tau <= 0.0:
            return 0.0
        keep = float(np.exp(-self.recording.trace_period / tau))
        return keep / (1.0 - keep) * self.recording.trace_period

    def steady(self, velocity: Floats) -> Floats:
        """Return the friction force of steady sliding at velocities [m/s or rad/s], at the nominal level."""
        f, v = self.friction, np.asarray(velocity, dtype=float)
        side = (v < 0).astype(int)
        F_C, F_S, F_v = (np.asarray(pair)[side] for pair in (f.F_C, f.F_S, f.F_v))
        dry = F_C + (F_S - F_C) * np.exp(-((np.abs(v) / f.v_S) ** f.shape))
        return np.sign(v) * dry + F_v * v + f.F_root * v / np.sqrt(np.abs(v) + f.root_floor)

    def told(self) -> dict[str, object]:
        """Return all of it as plain lists and numbers, for JSON."""
        return dataclasses.asdict(self)


@dataclass(frozen=True)
class Record:
    """What the drive recorded: arrays of one length, with the units that it names."""

    t: Floats  # [s]
    position: Floats  # [m or rad]
    effort: Floats  # in `effort_unit`
    position_unit: str
    effort_unit: str
    reference: Floats | None = None  # [m or rad]
    velocity: Floats | None = None  # [m/s or rad/s]
    notes: dict[str, float] = field(default_factory=dict)
