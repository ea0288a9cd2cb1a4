"""Records that lie: each function takes a truth and its record, and returns what somebody might hand in instead.

`seed` decides what the lie leaves open. Where a lie changes the axis or its motion, the run is made again, and the
truth that comes back is that of the new run; where it only changes channels, the truth stays, and the record is wrong
of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.strangers.recording import low_pass, make_record
from benchmarks.strangers.truth import Floats, Record, Truth

__all__ = ["LIES", "Lie", "Lied", "listed"]


@dataclass(frozen=True)
class Lied:
    """A record with a lie, and the truth of the run behind it.

    `told` says in plain words what is wrong; `value` is the number that goes with it (a factor, seconds, rows, or the
    known mass that is claimed), and `claimed_mass` the mass that is handed in as known, None where none is.
    """

    name: str
    truth: Truth
    record: Record
    told: str
    value: float
    claimed_mass: float | None = None


Lie = Callable[[Truth, Record, int], Lied]
LIES: dict[str, Lie] = {}


def listed(
    make: Callable[[Truth, Record, np.random.Generator], tuple[Truth, Record, str, float]],
) -> Lie:
    """Name the lie after its function, list it, and give it its generator."""
    name = make.__name__

    def lie(truth: Truth, record: Record, seed: int = 0) -> Lied:
        generator = np.random.default_rng((seed, *name.encode()))
        return Lied(name, *make(truth, record, generator))

    lie.__name__, lie.__doc__ = name, make.__doc__
    LIES[name] = lie
    return lie


def known_mass_wrong(truth: Truth, record: Record, seed: int = 0) -> Lied:
    """Claim a known mass that is 0.5 to 0.8 or 1.25 to 2 of the true one; the record stays."""
    rng = np.random.default_rng((seed, 1))
    factor = float(np.exp(rng.choice([-1.0, 1.0]) * rng.uniform(np.log(1.25), np.log(2.0))))
    told = f"the mass claimed as known is {factor:.3g} of the true one"
    return Lied("known_mass_wrong", truth, record, told, factor, factor * truth.mass)


LIES["known_mass_wrong"] = known_mass_wrong


def _scaled(record: Record, factor: float) -> Record:
    """Positions and velocities are multiplied by a factor."""
    return replace(
        record,
        position=factor * record.position,
        reference=None if record.reference is None else factor * record.reference,
        velocity=None if record.velocity is None else factor * record.velocity,
    )


def _picked(record: Record, rows: np.ndarray, t: Floats) -> Record:
    return replace(
        record,
        t=t,
        position=record.position[rows],
        effort=record.effort[rows],
        reference=None if record.reference is None else record.reference[rows],
        velocity=None if record.velocity is None else record.velocity[rows],
    )


def _delayed(x: Floats, rows: int) -> Floats:
    return np.concatenate([np.full(rows, x[0]), x[:-rows]])


@listed
def sign_reversed(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The effort has the wrong sign."""
    return truth, replace(record, effort=-record.effort), "effort has the wrong sign", -1.0


@listed
def gear_doubled(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """A gear of two between encoder and axis was ignored, or its ratio was inverted."""
    return truth, _scaled(record, 2.0), "positions and velocities are twice the true ones", 2.0


@listed
def gear_forgotten(
    truth: Truth, record: Record, rng: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """Positions of the motor, in radians, declared as positions of the axis, without lead or gear."""
    factor = (
        2.0 * np.pi / truth.axis.turn
        if truth.axis.linear
        else float(rng.choice([5.0, 10.0, 50.0, 100.0]))
    )
    return (
        truth,
        _scaled(record, factor),
        f"positions are those of the motor, {factor:.4g} times the axis's",
        factor,
    )


@listed
def effort_late(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The effort is three rows late, without a note."""
    return (
        truth,
        replace(record, effort=_delayed(record.effort, 3)),
        "effort is three rows late",
        3.0,
    )


@listed
def position_late(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The position is three rows late, without a note."""
    return (
        truth,
        replace(record, position=_delayed(record.position, 3)),
        "position is three rows late",
        3.0,
    )


@listed
def effort_filtered(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """A first-order filter of 5 ms on the effort."""
    effort = low_pass(record.effort, 5e-3, truth.period)
    return truth, replace(record, effort=effort), "effort passed a filter of 5 ms", 5e-3


@listed
def position_filtered(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """A first-order filter of 5 ms on the position."""
    position = low_pass(record.position, 5e-3, truth.period)
    return truth, replace(record, position=position), "position passed a filter of 5 ms", 5e-3


@listed
def rows_lost(
    truth: Truth, record: Record, rng: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """200 rows within the motion are missing, and the remaining rows have new time stamps."""
    n = record.t.size
    starts = rng.integers(n // 5, n - n // 5, 50)
    moved = np.abs(record.position[starts + 200] - record.position[starts])
    start = int(starts[np.argmax(moved)])
    rows = np.concatenate([np.arange(start), np.arange(start + 200, n)])
    return (
        truth,
        _picked(record, rows, record.t[: rows.size]),
        f"200 rows lost at row {start}, stamped again",
        200.0,
    )


@listed
def effort_saturates_softly(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The sensor saturates gradually (tanh) at 70 % of the largest effort."""
    top = 0.7 * float(np.abs(record.effort).max())
    return (
        truth,
        replace(record, effort=top * np.tanh(record.effort / top)),
        "effort bends over as tanh",
        top,
    )


@listed
def effort_clipped(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The channel is clipped at 60 % of the largest effort."""
    top = 0.6 * float(np.abs(record.effort).max())
    return (
        truth,
        replace(record, effort=np.clip(record.effort, -top, top)),
        "effort is clipped",
        top,
    )


def _again(truth: Truth) -> tuple[Truth, Record]:
    return truth, make_record(truth)


@listed
def backlash(truth: Truth, _: Record, rng: np.random.Generator) -> tuple[Truth, Record, str, float]:
    """Play of 5 to 20 micrometres to either side behind the encoder (rotary: as an angle of a 10 mm screw)."""
    half = float(rng.uniform(5e-6, 20e-6)) * (1.0 if truth.axis.linear else 2.0 * np.pi / 0.01)
    share, wave = float(rng.uniform(0.3, 0.6)), 2.0 * np.pi * 250.0
    reduced = truth.mass * share * (1.0 - share)
    axis = replace(
        truth.axis,
        half_play=half,
        load_share=share,
        contact_stiffness=reduced * wave**2,
        contact_damping=0.3 * reduced * wave,
    )
    friction = truth.friction
    if friction.law != "lugre":
        # Two masses rub over bristles; a jump of friction becomes one of 5 micrometres.
        distance = half / 4.0
        stiffness = max(friction.F_S) / distance
        damping = min(0.6 * np.sqrt(stiffness * truth.mass), 4e-3 * stiffness)
        friction = replace(
            friction, law="lugre", sigma_0=stiffness, sigma_1=damping, break_away=distance
        )
        friction = replace(friction, cell_stiffness=(), cell_share=())
    return (
        *_again(replace(truth, axis=axis, friction=friction)),
        "the axis has play behind its encoder",
        half,
    )


@listed
def heat(truth: Truth, _: Record, __: np.random.Generator) -> tuple[Truth, Record, str, float]:
    """Friction falls from 1.2 to 0.8 of its level over the record."""
    friction = replace(truth.friction, heat=(1.2, 0.8), heat_time=0.5 * truth.motion.duration)
    return (
        *_again(replace(truth, friction=friction)),
        "friction falls from 1.2 to 0.8 over the record",
        0.4,
    )


def _strokes(truth: Truth, kind: str, rng: np.random.Generator) -> Truth:
    """The truth with strokes of a kind at the speeds, or at those which its other motion reached."""
    motion = truth.motion
    if motion.kind == kind:
        return truth
    speeds, stroke = motion.speeds, motion.stroke
    if not speeds:
        f, a = np.asarray(motion.frequencies), np.asarray(motion.amplitudes)
        top = max(float((2.0 * np.pi * f * a).max()), 5.0 * truth.friction.v_S)
        speeds, stroke = tuple((top * np.array([0.1, 0.3, 1.0])).tolist()), 1.5 * top
        motion = replace(
            motion,
            acceleration=min(10.0 * top, 0.3 * truth.motor.limit / truth.mass),
            frequencies=(),
            amplitudes=(),
            phases=(),
        )
    if kind == "one_speed":
        speeds = (float(rng.choice(speeds)),)
    return replace(truth, motion=replace(motion, kind=kind, speeds=speeds, stroke=stroke))


@listed
def one_speed(
    truth: Truth, _: Record, rng: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The axis moved at one speed only."""
    new = _strokes(truth, "one_speed", rng)
    return *_again(new), "one speed only", new.motion.speeds[0]


@listed
def one_direction(
    truth: Truth, _: Record, rng: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The axis moved in one direction only."""
    return *_again(_strokes(truth, "one_direction", rng)), "one direction only", 1.0


def _tiny(truth: Truth, um: float) -> Truth:
    """The truth with slow triangles of so many micrometres, an encoder that sees them and a loop that follows them.

    Stuck, the axis is a spring, which the loop follows by its integral: that is raised until it does.
    """
    size = um * 1e-6 * (1.0 if truth.axis.linear else 2.0 * np.pi / 0.01)
    motion = replace(
        truth.motion,
        kind="presliding",
        speeds=(),
        smoothing=0.01,
        frequencies=(0.1,),
        amplitudes=(size,),
        phases=(),
    )
    encoder = replace(truth.encoder, resolution=min(truth.encoder.resolution, size / 20.0))
    loop, friction = truth.loop, truth.friction
    if friction.break_away > 0.0:
        stiffness = max(friction.F_S) / friction.break_away
        pace = loop.ki * (1.0 if loop.kind == "pid" else loop.kp) / stiffness
        # Past break-away a high integral hunts.
        most = 1000.0 if size < 0.7 * friction.break_away else 6.0
        loop = replace(loop, ki=loop.ki * float(np.clip(4.0 / pace, 1.0, most)))
    return replace(truth, motion=motion, encoder=encoder, loop=loop)


@listed
def presliding_1um(
    truth: Truth, _: Record, __: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The motion has triangles of 1 micrometre only."""
    return *_again(_tiny(truth, 1.0)), "triangles of 1 micrometre alone", 1e-6


@listed
def presliding_3um(
    truth: Truth, _: Record, __: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The motion has triangles of 3 micrometres only."""
    return *_again(_tiny(truth, 3.0)), "triangles of 3 micrometres alone", 3e-6


@listed
def degrees_as_radians(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """Positions in degrees are declared as radians (linear axis: millimetres as metres)."""
    factor, told = (
        (1e3, "millimetres declared as metres")
        if truth.axis.linear
        else (180.0 / np.pi, "degrees as radians")
    )
    return truth, _scaled(record, factor), told, factor


@listed
def seconds_as_milliseconds(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """Time stamps in seconds are declared as milliseconds, so that all times are a thousandth."""
    return (
        truth,
        replace(record, t=1e-3 * record.t),
        "stamps are a thousandth of the true ones",
        1e-3,
    )


@listed
def counter_overflows(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The counter overflows within the record, and the record is not unwrapped."""
    counts = np.round(record.position / truth.encoder.resolution)
    bits = int(np.floor(np.log2(max(float(np.ptp(counts)), 4.0))))
    half = 2.0 ** (bits - 1)
    wrapped = np.mod(counts + half, 2.0 * half) - half
    return (
        truth,
        replace(record, position=wrapped * truth.encoder.resolution),
        f"a counter of {bits} bits",
        float(bits),
    )


@listed
def velocity_scale(
    truth: Truth, record: Record, rng: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The velocity channel is in other units: rpm declared as rad/s, mm/s as m/s, or a factor of two."""
    factor = float(rng.choice([2.0, 1e3 if truth.axis.linear else 30.0 / np.pi]))
    velocity = (
        record.velocity
        if record.velocity is not None
        else np.gradient(record.position, truth.period)
    )
    return (
        truth,
        replace(record, velocity=factor * velocity),
        f"velocity is {factor:.4g} times the true one",
        factor,
    )
