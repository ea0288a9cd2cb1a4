r"""Two masses as a plant of identification: coupling, play, and friction on either side, from a log with a second encoder.

The coupling is identified first (`two_encoders`, `lost_motion`). Its force :math:`f_s = k D_g + d \dot D_g` then separates
the log into two logs of one mass each, in which every friction model can be identified:

.. math:: u - f_s - c_T |f_s|\, z = m_1 \ddot x_1 + F_1, \qquad f_s = m_2 \ddot x_2 + F_2 .

A relative error of the stiffness changes all forces of the load by the same share. An error of the play changes the
level of friction of the load by the stiffness times half of it. Both change the friction of the motor by the opposite force.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core.axis import LOAD_ENCODER, Axis
from bristle.core.contracts import Model
from bristle.core.dimensions import exponents_of
from bristle.core.edge import Progress, between
from bristle.core.errors import InputError
from bristle.core.normal import NORMAL_95
from bristle.core.typography import with_unit
from bristle.friction import find
from bristle.friction.next_model import goes_by_name, model_with
from bristle.identification.elasticity import Elastic, step_of
from bristle.identification.lost_motion import LostMotion, lost_motion
from bristle.identification.parameters import Role, names_of
from bristle.identification.quantities import Quantity, quantities_of
from bristle.identification.result import TWO_MASSES
from bristle.identification.two_encoders import EXCITE, UNKNOWN, Masses, Prior, Record, masses_of
from bristle.logs.filters import ahead, derivative, low_passed
from bristle.logs.log import Channel, Log
from bristle.plants import ball_screw

if TYPE_CHECKING:
    from bristle.identification.estimate import Estimate
    from bristle.identification.result import Fit, Identification

    Pairs = Sequence[tuple[Log, Axis | None]]

SPARE_LEVEL, TINY = 0.01, float(np.finfo(float).tiny)  # smallest relative half-width of forces of friction
LEAST_ERROR = 4e-3  # smallest relative error of the stiffness of the lost motion
JUDGED = ("motor", "load", "stiffness")
MOST_ERROR = 0.25  # relative half-width of a mass or of the stiffness above which a log does not show two masses
ALIKE = 0.05  # allowed difference of the strokes of motor and load, as a share
CUTOFF, HIGHEST = 0.2, 200.0  # of the sampling frequency; Hz: for the rate of the coupling
MOST_LEFT, OF_BOTH = 0.7, 0.2  # of the force on a side, of both forces: largest rms that friction leaves unexplained
MOSTLY = 0.8  # of the squared twist: share by which one signal is its likely cause


@dataclass(frozen=True)
class TwoMasses:
    """A motor and a load behind an elastic coupling, identified from a log with an encoder on either side, or at the motor.

    Parameters
    ----------
    quantities : tuple of Quantity
        Masses, stiffness and damping in SI units of the axis, with 95 % intervals; with two encoders also play and friction of
        the nut, and the hysteresis of the coupling, if the log shows it.
    motor : Identification
        Friction models of the bearings of the motor, best first, from motor position and effort minus forces of coupling and
        nut. With one encoder, the friction of both sides.
    load : Identification or None
        Friction models of the load side, best first, from load position and force of the coupling; None with one encoder,
        which does not separate the friction of both sides.
    delay : float
        Delay of the effort [s].
    arm : float
        Movement of the axis per radian of the motor [m/rad]; 1 if unknown, and on a rotational axis.
    nut_is_masked : bool
        Whether other forces mask the friction of a nut, and the force of the coupling is not too small to show it.
    """

    quantities: tuple[Quantity, ...]
    motor: Identification
    load: Identification | None
    delay: float
    arm: float = 1.0
    nut_is_masked: bool = False

    @property
    def nut_is_separable(self) -> bool:
        """Whether the log separates friction of the nut from bearings, load and stiffness."""
        if self.load is None:
            return False
        nut, stiffness = self.by_name["nut"], self.by_name["stiffness"]
        return nut.value > 0.0 or nut.half_width < stiffness.half_width / stiffness.value

    @property
    def nut(self) -> float:
        """Friction of the nut per force of the coupling; 0 if the log does not show it."""
        return self.by_name["nut"].value if "nut" in self.by_name else 0.0

    @property
    def by_name(self) -> dict[str, Quantity]:
        """The quantities by name."""
        return {quantity.name: quantity for quantity in self.quantities}

    @property
    def sides(self) -> dict[str, Identification]:
        """Friction of motor and load by the name of the side; with one encoder, all friction is that of the motor."""
        return {"motor": self.motor} | ({} if self.load is None else {"load": self.load})

    @property
    def play_is_clear(self) -> bool:
        """Whether the log shows play."""
        return "play" in self.by_name and self.by_name["play"].value > 0.0

    @property
    def plant(self) -> Model:
        """The plant for simulations, a `ball_screw`; without a lead the motor turns by 1 rad per unit of travel."""
        value = {name: quantity.value for name, quantity in self.by_name.items()}
        J, lead = value["motor"] * self.arm**2, 2.0 * math.pi * self.arm
        return ball_screw(
            kind="rotational", J=J, M=value["load"], lead=lead, k=value["stiffness"], d=value["damping"], backlash=value.get("play", 0.0)
        )

    @property
    def motor_friction(self) -> Model:
        """Friction of bearings and nut in N*m and rad; without that of the nut if the model has no slot ``+transmitted``."""
        friction, nut = _determined(self.motor.best), self.nut
        name = model_with("transmitted", friction) if nut > 0.0 and goes_by_name(friction.component) else ""
        return self.at_the_motor(find(name)(kind=friction.kind, **friction.values, c_T=nut) if name else friction)

    def at_the_motor(self, friction: Model) -> Model:
        """Return a friction of the axis in N*m and rad of the motor."""
        return _turned(friction, self.arm)

    @property
    def table_friction(self) -> Model | None:
        """Friction of the table in N and m; of a rotational load in the same numbers. None with one encoder."""
        if self.load is None:
            return None
        friction = _determined(self.load.best)
        return friction.component(kind="translational", **friction.values)

    def as_data(self) -> dict[str, Any]:
        """Return quantities and friction as plain data."""
        sides = {f"{name}_friction": _friction_data(side.best) for name, side in self.sides.items()}
        numbers = {quantity.name: quantity._asdict() for quantity in self.quantities}
        return {"quantities": numbers, "delay": self.delay, "play_is_clear": self.play_is_clear, **sides}


def apart(pairs: Pairs) -> tuple[list[tuple[Log, Axis | None]], Pairs]:
    """Return logs without the second encoder, and the pairs if each log has one."""
    has_encoder = [LOAD_ENCODER in log.further for log, _ in pairs]
    if not any(has_encoder):
        return list(pairs), ()
    alone = [
        (replace(log, further={name: channel for name, channel in log.further.items() if name != LOAD_ENCODER}), axis)
        for log, axis in pairs
    ]
    return alone, pairs if all(has_encoder) else ()


def two_masses(pairs: Pairs, fitted: Callable[..., Identification], progress: Progress | None = None) -> TwoMasses | str:
    """Return both masses and the friction of both sides, or the reason why the logs do not show them."""
    step = max(step_of(log, axis) for log, axis in pairs)
    records = [record for log, _ in pairs for record in _records(log)]
    try:
        masses = masses_of(records, step)
    except InputError as error:
        return f"{error}. {_advice(records)}"
    if masses is None:
        return "the log shows no twist in strokes in one direction. Record strokes at several speeds with a higher acceleration"
    kind = pairs[0][0].kind
    lost = lost_motion(records, step, masses, kind)
    if lost.clear or lost.nut_is_clear:
        masses = _refined(masses, records, step, lost, UNKNOWN._replace(nut=lost.nut_as_known[0]))
        lost = lost_motion(records, step, masses, kind)
    values, errors = [lost.stiffness], [math.hypot(lost.stiffness_error, LEAST_ERROR * lost.stiffness)]
    prior = Prior(np.array(values), np.array(errors), *lost.nut_as_known)
    masses = _refined(masses, records, step, lost, prior)
    quantities = quantities_of(masses, lost, kind, step)
    if masses.damping <= 0.0:
        return f"the fit of both masses gives a negative damping. {_advice(records)}"
    if unsure := _unsure(quantities):
        return f"{unsure}. {_advice(records)}"
    sides = [_side_logs(log, masses, lost) for log, _ in pairs]
    axes = [
        replace(Axis(kind=kind), resolution=step, seeks_delay=False, method="inverse_dynamics", settings=axis.settings if axis else {})
        for _, axis in pairs
    ]
    reports = (None, None) if progress is None else (between(progress, 0.4, 0.7), between(progress, 0.7, 1.0))
    results = [fitted([side[place] for side in sides], axis=axes, progress=report) for place, report in enumerate(reports)]
    forces = [_rms(result.best.traces.friction) for result in results]
    left = [_rms(result.best.traces.residual) for result in results]
    for name, force, rest in zip(("motor", "load"), forces, left, strict=True):
        if rest > max(MOST_LEFT * force, OF_BOTH * math.hypot(*forces)):
            return (
                f"friction explains only {100.0 * (1.0 - (rest / force) ** 2):.0f} % of the squared force on the {name}. {_advice(records)}"
            )
    quantity = {quantity.name: quantity for quantity in quantities}
    doubt = _doubt(quantity["stiffness"], quantity["play"], forces[1])
    doubts = math.hypot(doubt, quantity["nut"].half_width * forces[1]) if lost.nut_is_clear else doubt, doubt
    widened = [
        replace(result, fits=(_widened(result.best, math.hypot(SPARE_LEVEL, doubt / max(force, TINY))), *result.fits[1:]))
        for result, force, doubt in zip(results, forces, doubts, strict=True)
    ]
    return TwoMasses(quantities, widened[0], widened[1], masses.delay, _arm(pairs), lost.nut_is_masked)


def with_two_masses(
    result: Identification, pairs: Pairs, fitted: Callable[..., Identification], progress: Progress | None
) -> Identification:
    """Return a result with both masses, or with the reason why the logs do not show them."""
    return _with(result, two_masses(pairs, fitted, progress))


def with_masses_of(result: Identification, pairs: Pairs, coupling: Elastic | None) -> Identification:
    """Return a result with both masses of a coupling seen by one encoder, or with the reason why the logs do not show them."""
    if coupling is None:
        return result
    if isinstance(coupling.masses, str):
        return _with(result, coupling.masses)
    hertz = {"value": coupling.antiresonance, "half_width": coupling.antiresonance_half_width}
    quantities = tuple(
        quantity._replace(**hertz) if quantity.name == "antiresonance" else quantity
        for quantity in quantities_of(coupling.masses, None, pairs[0][0].kind, 0.0)
    )
    if unsure := _unsure(quantities):
        return _with(result, f"{unsure}. {EXCITE}")
    total, mass = coupling.mass, result.best.inertia
    ends = None if mass is None else mass.ends
    if mass and ends and not ends[0] - coupling.mass_half_width < total < ends[1] + coupling.mass_half_width:
        sums = f"the fit of both masses has the sum {with_unit(total, mass.unit)}, but the axis has {with_unit(mass.value, mass.unit)}"
        return _with(result, f"{sums}: the recorded effort may have passed a filter")
    return _with(result, TwoMasses(quantities, result, None, coupling.masses.delay, _arm(pairs)))


def _with(result: Identification, found: TwoMasses | str) -> Identification:
    if isinstance(found, str):
        return replace(result, left_out={**result.left_out, TWO_MASSES: found})
    return replace(result, two_masses=found)


def _unsure(quantities: Sequence[Quantity]) -> str:
    """Return the reason why masses and stiffness are not well known; empty if they are."""
    judged = [quantity for quantity in quantities if quantity.name in JUDGED]
    widest = max(judged, key=lambda quantity: quantity.half_width / quantity.value)
    percent = 100.0 * widest.half_width / widest.value
    return "" if percent < 100.0 * MOST_ERROR else f"the log determines the {widest.meaning} only within {percent:.0f} %"


def _arm(pairs: Pairs) -> float:
    """Return the movement of the axis per radian of the motor; 1 if unknown, and on a rotational axis."""
    log, axis = pairs[0]
    return axis.arm if axis is not None and axis.arm is not None and log.kind == "translational" else 1.0


def _records(log: Log) -> list[Record]:
    """Return the stretches of a log without a gap; both encoders begin at the same place."""
    assert log.effort is not None
    records = []
    for part in log.segments:
        motor, load = log.position.values[part], log.further[LOAD_ENCODER].values[part]
        strokes = motor - motor.mean(), load - load.mean()
        ratio = float(strokes[0] @ strokes[1]) / max(float(strokes[0] @ strokes[0]), TINY)
        if abs(ratio - 1.0) > ALIKE:
            mend = "Check unit and sign of both columns, side, gear_ratio and lead"
            raise InputError(
                "moves otherwise than the motor", path=f"columns.{LOAD_ENCODER}", value=f"{ratio:.3g} times as far", allowed="1", mend=mend
            )
        twist = motor - load
        low, high = np.quantile(twist, [0.005, 0.995]).tolist()
        records.append(Record(motor, load + 0.5 * (low + high), log.effort.values[part], log.sample_time))
    return records


def _doubt(stiffness: Quantity, play: Quantity, force: float) -> float:
    """Return the half-width of a force of the coupling, by the errors of its stiffness and its play."""
    return math.hypot(force * stiffness.half_width / stiffness.value, 0.5 * stiffness.value * play.half_width)


def _refined(masses: Masses, records: Sequence[Record], step: float, lost: LostMotion, prior: Prior) -> Masses:
    """Return the masses with a known play and stiffness, or the previous masses if the records do not show them."""
    try:
        return masses_of(records, step, lost.dead, prior) or masses
    except InputError:
        return masses


def _rms(signal: np.ndarray) -> float:
    return float(np.sqrt(np.mean(signal**2)))


def _advice(records: Sequence[Record]) -> str:
    """Return the likely cause why a log does not show two masses, from the signal that explains most of the twist, and its cure."""
    longest = max(records, key=lambda record: record.motor.size)
    size, dt = longest.motor.size, longest.dt
    twist, place = longest.motor - longest.load, longest.motor - longest.motor.mean()
    time = dt * np.arange(size)
    signals = np.stack([place, time - time.mean(), np.gradient(low_passed(place, min(CUTOFF / dt, HIGHEST), dt), dt)])
    centred = twist - twist.mean()
    slopes = signals @ centred / np.maximum(np.sum(signals**2, axis=1), TINY)
    shares = np.array(
        [1.0 - _rms(centred - slope * signal) ** 2 / max(_rms(centred) ** 2, TINY) for slope, signal in zip(slopes, signals, strict=True)]
    )
    best = int(np.argmax(shares))
    if shares[best] < MOSTLY:
        return (
            "Excite the axis around its antiresonance and sample both encoders at the same time. Check that `position` is the encoder "
            "of the motor, and the sign of the effort"
        )
    return (
        f"The scale moves {1.0 - slopes[0]:.5g} times as far as the motor. Correct lead or gear_ratio",
        f"The encoders drift apart by {abs(slopes[1]) * time[-1]:.2g} in the unit of the axis. Warm the axis up, or use a shorter log",
        f"The twist is mostly proportional to the velocity, like a delay of {1e3 * abs(slopes[2]):.2g} ms between the encoders. "
        "Sample both at the same time",
    )[best]


def _side_logs(log: Log, masses: Masses, lost: LostMotion) -> tuple[Log, Log]:
    """Return the logs of the motor and of the load as axes with one mass."""
    assert log.effort is not None
    pushed, pulled = np.zeros(len(log)), np.zeros(len(log))
    for part, record in zip(log.segments, _records(log), strict=True):
        stretch = lost.dead(record.motor - record.load)
        smooth = low_passed(stretch, min(CUTOFF / record.dt, HIGHEST), record.dt)
        pulled[part] = masses.stiffness * stretch + masses.damping * derivative(smooth, record.dt)
        nut = lost.nut_share(record) * np.abs(pulled[part])
        pushed[part] = ahead(record.effort, masses.delay / record.dt) - pulled[part] - nut
    alone = replace(log, velocity=None, reference=None, injected=(), further={}, regressors=())
    unit, encoder = log.effort.unit, log.further[LOAD_ENCODER]
    force = [Channel(values, unit, log.effort.column) for values in (pushed, pulled)]
    return replace(alone, effort=force[0]), replace(
        alone, position=Channel(encoder.values, log.position.unit, encoder.column), effort=force[1]
    )


def _widened(fit: Fit, share: float) -> Fit:
    """Return a fit whose forces are uncertain by a further share, as a half-width."""
    variables = fit.friction.component.variables

    def wider(estimate: Estimate) -> Estimate:
        if estimate.ends is None or estimate.name not in variables or not exponents_of(variables[estimate.name].quantity).get("force"):
            return estimate
        low, high = estimate.ends
        middle, half = 0.5 * (low + high), math.hypot(0.5 * (high - low), share * estimate.value)
        return replace(estimate, interval=(middle - half, middle + half), robust_std=max(estimate.larger_std or 0.0, half / NORMAL_95))

    return replace(fit, estimates=tuple(map(wider, fit.estimates)))


def _determined(fit: Fit) -> Model:
    """Return the friction of a fit; a break-away level that the log does not determine is that of sliding."""
    values, variables = fit.friction.values, fit.friction.component.variables
    pairs = zip(names_of(Role.BREAK_AWAY, variables), names_of(Role.LEVEL, variables), strict=False)
    return fit.friction.with_values(
        **{peak: values[level] for peak, level in pairs if fit.parameters[peak].status not in ("identified", "held")}
    )


def _turned(friction: Model, arm: float) -> Model:
    """Return a friction model of the axis for the angle of its motor."""
    values: dict[str, Any] = {}
    for name, value in friction.values.items():
        powers: Mapping[str, float] = exponents_of(friction.component.variables[name].quantity)
        factor = arm ** (powers.get("force", 0.0) - powers.get("length", 0.0))
        scaled = np.asarray(value, dtype=float) * factor if powers else value
        values[name] = scaled if np.ndim(scaled) else scaled.item() if powers else value
    return friction.component(kind="rotational", **values)


def _friction_data(fit: Fit) -> dict[str, Any]:
    """Return model, parameters and intervals of a side."""
    values = {
        item.name: {"value": item.value, "unit": item.unit, "interval": item.ends, "status": item.status}
        for item in fit.estimates
        if item.name in fit.friction.values
    }
    return {"model": fit.name, "error_percent": fit.force_error_percent, "parameters": values}
