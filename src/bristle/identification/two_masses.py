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
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bristle.core.axis import COUPLING_EFFORT, LOAD_ENCODER, OF_COUPLING, Axis
from bristle.core.dimensions import exponents_of
from bristle.core.edge import Progress, between
from bristle.core.errors import InputError
from bristle.core.normal import NORMAL_95
from bristle.core.typography import with_unit
from bristle.core.variable import Kind
from bristle.identification.elasticity import Elastic, Masses
from bristle.identification.lost_motion import LostMotion, lost_motion
from bristle.identification.one_encoder import response_of
from bristle.identification.preprocessing import step_of
from bristle.identification.quantities import (
    JUDGED,
    MASS,
    Quantity,
    quantities_of,
    quantities_of_response,
    unsure_of,
)
from bristle.identification.result import TWO_MASSES, Fit, Identification, TwoMasses
from bristle.identification.side_logs import (
    advice,
    alone,
    behind_sensor,
    effort_delay,
    records_of,
    rms,
    side_logs,
    without_sensor,
)
from bristle.identification.two_encoders import (
    EXCITE,
    SPARE,
    TINY,
    UNKNOWN,
    Prior,
    Record,
    masses_of,
)
from bristle.logs.log import Log

if TYPE_CHECKING:
    from bristle.identification.estimate import Estimate

    Pairs = Sequence[tuple[Log, Axis | None]]

SPARE_LEVEL = 0.01  # smallest relative half-width of forces of friction
RIGID_LEVEL = 0.15  # smallest relative half-width of friction of a load without an encoder
LEAST_ERROR = 4e-3  # smallest relative error of the stiffness of the lost motion
# Of the force on a side, of both forces: largest rms that friction leaves unexplained.
MOST_LEFT, OF_BOTH = (0.7, 0.2)
CHECK_SENSOR = "Check unit and sign of the sensor, and the constant of the effort"
NO_SCALE = (
    "Without a second encoder, the load is rigid behind the sensor: its inertia and friction hold below the antiresonance, and contain "
    "friction of the nut"
)


def apart(pairs: Pairs) -> tuple[list[tuple[Log, Axis | None]], Pairs]:
    """Return logs without second encoder and sensor in the coupling, and the pairs if each log has the same of them."""
    if not any(name in log.further for log, _ in pairs for name in OF_COUPLING):
        return list(pairs), ()
    rest = [
        (
            replace(
                log,
                further={
                    name: channel
                    for name, channel in log.further.items()
                    if name not in OF_COUPLING
                },
            ),
            axis,
        )
        for log, axis in pairs
    ]
    return rest, pairs if any(_all_have(name, pairs) for name in OF_COUPLING) else ()


def _all_have(name: str, pairs: Pairs) -> bool:
    return all(name in log.further for log, _ in pairs)


def two_masses(
    pairs: Pairs,
    fitted: Callable[..., Identification],
    progress: Progress | None = None,
    coupling: Elastic | None = None,
) -> TwoMasses | str:
    """Return both masses and the friction of both sides, or the reason why the logs do not show them.

    Without a second encoder, a sensor shows both sides; `coupling` is that of the encoder of the motor.
    """
    step, kind, measured = (
        max(step_of(log, axis) for log, axis in pairs),
        pairs[0][0].kind,
        _all_have(COUPLING_EFFORT, pairs),
    )
    logs = [behind_sensor(log) if measured else log for log, _ in pairs]
    parted = (
        _elastic(logs, step, kind, measured=measured)
        if _all_have(LOAD_ENCODER, pairs)
        else NO_SCALE
    )
    if isinstance(parted, str):
        if not measured:
            return parted
        parted = _by_sensor(pairs, logs, coupling, parted)
    delay, sides = parted.delay, parted.sides
    if measured:
        delay = effort_delay([log for log, _ in pairs], parted.delay)
        sides = [
            (without_sensor(log, parted.delay, delay), load)
            for (log, _), (_, load) in zip(pairs, sides, strict=True)
        ]
    axes = [
        replace(
            Axis(kind=kind),
            resolution=step,
            seeks_delay=False,
            method="inverse_dynamics",
            settings=axis.settings if axis else {},
        )
        for _, axis in pairs
    ]
    reports = (
        (None, None)
        if progress is None
        else (between(progress, 0.4, 0.7), between(progress, 0.7, 1.0))
    )
    # A rigid load: below its antiresonance.
    cutoffs = (
        None,
        coupling.one_mass if parted.rigid is NO_SCALE and coupling is not None else None,
    )
    results = [
        fitted(
            [side[place] for side in sides],
            axis=[replace(axis, cutoff=cutoff) for axis in axes],
            progress=report,
        )
        for place, (report, cutoff) in enumerate(zip(reports, cutoffs, strict=True))
    ]
    forces = [rms(result.best.traces.friction) for result in results]
    left = [rms(result.best.traces.residual) for result in results]
    for name, force, rest in zip(("motor", "load"), forces, left, strict=True):
        if rest > max(MOST_LEFT * force, OF_BOTH * math.hypot(*forces)):
            explained = 100.0 * (1.0 - (rest / force) ** 2)
            cure = (
                advice([record for log in logs for record in records_of(log)])
                if not parted.rigid
                else CHECK_SENSOR
            )
            return f"friction explains only {explained:.0f} % of the squared force on the {name}. {cure}"
    quantity = {quantity.name: quantity for quantity in parted.quantities}
    doubts = _doubts(quantity, forces[1], nut=parted.nut_is_clear, measured=measured)
    if measured:
        of_fits = [
            _mass_of(result, name, kind)
            for result, name in zip(results, ("motor", "load"), strict=True)
        ]
        if parted.rigid is NO_SCALE:  # errors by the motion of the load are unknown
            doubts, of_fits[1] = (
                (0.0, RIGID_LEVEL * forces[1]),
                of_fits[1]._replace(half_width=math.inf),
            )
        quantity = {item.name: item for item in of_fits} | quantity
    widened = [
        replace(
            result,
            fits=(
                _widened(result.best, math.hypot(SPARE_LEVEL, doubt / max(force, TINY))),
                *result.fits[1:],
            ),
        )
        for result, force, doubt in zip(results, forces, doubts, strict=True)
    ]
    return TwoMasses(
        tuple(quantity.values()),
        widened[0],
        widened[1],
        delay,
        _arm(pairs),
        parted.nut_is_masked,
        measured,
        parted.rigid,
    )


class _Parted(NamedTuple):
    """Logs of motor and load, quantities of the coupling, delay of the effort, whether friction of a nut shows, and `rigid`."""

    sides: list[tuple[Log, Log]]
    quantities: tuple[Quantity, ...]
    delay: float = 0.0
    nut_is_clear: bool = False
    nut_is_masked: bool = False
    rigid: str = ""


def _by_sensor(pairs: Pairs, logs: Sequence[Log], coupling: Elastic | None, reason: str) -> _Parted:
    """Return both sides of a sensor whose log does not show the deflection of the coupling for some `reason`."""
    kind, efforts = pairs[0][0].kind, [log.effort.values for log in logs if log.effort is not None]
    if reason is NO_SCALE:  # a rigid load; the coupling corrects its position
        softness = (
            (2.0 * math.pi * coupling.antiresonance) ** -2 / coupling.load
            if coupling is not None
            else 0.0
        )
        loads = [
            alone(log, effort, load=True, softness=softness)
            for log, effort in zip(logs, efforts, strict=True)
        ]
        delay, quantities = 0.0, quantities_of_response(coupling, kind)
    else:
        loads = [alone(log, effort, load=True) for log, effort in zip(logs, efforts, strict=True)]
        delay, quantities, reason = (
            effort_delay(loads, 0.0),
            (),
            f"The log does not show the coupling: {reason}",
        )
        loads = [without_sensor(log, 0.0, delay) for log in loads]
    quantities = tuple(quantity for quantity in quantities if quantity.name not in JUDGED[:2])
    return _Parted(list(zip(logs, loads, strict=True)), quantities, delay, rigid=reason)


def _elastic(logs: Sequence[Log], step: float, kind: Kind, *, measured: bool) -> _Parted | str:
    """Return both sides of the coupling between two encoders, or the reason why the logs do not show it."""
    records = [record for log in logs for record in records_of(log)]
    try:
        masses = masses_of(records, step)
    except InputError as error:
        return f"{error}. {advice(records)}"
    if masses is None:
        return "the log shows no twist in strokes in one direction. Record strokes at several speeds with a higher acceleration"
    lost = lost_motion(records, step, masses, kind)
    if lost.clear or lost.nut_is_clear:
        masses = _refined(masses, records, step, lost, UNKNOWN._replace(nut=lost.nut_as_known[0]))
        lost = lost_motion(records, step, masses, kind)
    values, errors = (
        [lost.stiffness],
        [math.hypot(lost.stiffness_error, LEAST_ERROR * lost.stiffness)],
    )
    prior = Prior(np.array(values), np.array(errors), *lost.nut_as_known)
    masses = _refined(masses, records, step, lost, prior)
    quantities = quantities_of(masses, lost, kind, step, measured=measured)
    if masses.damping <= 0.0:
        return f"the fit of both masses gives a negative damping. {advice(records)}"
    if unsure := unsure_of(quantities):
        return f"{unsure}. {advice(records)}"
    sides = [side_logs(log, masses, lost, measured=measured) for log in logs]
    return _Parted(sides, quantities, masses.delay, lost.nut_is_clear, lost.nut_is_masked)


def _mass_of(result: Identification, name: str, kind: Kind) -> Quantity:
    """Return the mass of the fit of a side as a quantity."""
    mass = result.best.inertia
    assert mass is not None
    half = (
        math.inf
        if mass.ends is None
        else math.hypot(0.5 * (mass.ends[1] - mass.ends[0]), SPARE * mass.value)
    )
    return Quantity(name, mass.value, half, mass.unit, f"{MASS[kind]} of the {name}")


def with_two_masses(
    result: Identification,
    pairs: Pairs,
    fitted: Callable[..., Identification],
    progress: Progress | None,
    coupling: Elastic | None,
) -> Identification:
    """Return a result with both masses, or with the reason why the logs do not show them."""
    masses = two_masses(pairs, fitted, progress, coupling)
    # The plant with two masses explains what that of one mass does not.
    if isinstance(masses, TwoMasses) and masses.load is not None:
        explained = tuple(item for item in result.best.diagnostics if item.code != "unexplained")
        result = replace(
            result, fits=(replace(result.best, diagnostics=explained), *result.fits[1:])
        )
    return _with(result, masses)


def with_masses_of(
    result: Identification, pairs: Pairs, coupling: Elastic | None
) -> Identification:
    """Return a result with both masses of a coupling that one encoder shows, or with the reason why the logs do not show them."""
    if coupling is None:
        return result
    result = replace(result, response=response_of(coupling, pairs))
    if isinstance(coupling.masses, str):
        return _with(result, coupling.masses)
    quantities = quantities_of_response(coupling, pairs[0][0].kind)
    if unsure := unsure_of(quantities):
        return _with(result, f"{unsure}. {EXCITE}")
    total, mass = coupling.mass, result.best.inertia
    ends = None if mass is None else mass.ends
    if (
        mass
        and ends
        and not ends[0] - coupling.mass_half_width < total < ends[1] + coupling.mass_half_width
    ):
        sums = f"the fit of both masses has the sum {with_unit(total, mass.unit)}, but the axis has {with_unit(mass.value, mass.unit)}"
        return _with(result, f"{sums}: the recorded effort may have passed a filter")
    return _with(result, TwoMasses(quantities, result, None, coupling.masses.delay, _arm(pairs)))


def _with(result: Identification, found: TwoMasses | str) -> Identification:
    if isinstance(found, str):
        return replace(result, left_out={**result.left_out, TWO_MASSES: found})
    return replace(result, two_masses=found)


def _arm(pairs: Pairs) -> float:
    """Return the movement of the axis per radian of the motor; 1 if unknown, and on a rotational axis."""
    log, axis = pairs[0]
    return (
        axis.arm
        if axis is not None and axis.arm is not None and log.kind == "translational"
        else 1.0
    )


def _doubts(
    quantity: Mapping[str, Quantity], force: float, *, nut: bool, measured: bool
) -> tuple[float, float]:
    """Return the half-widths of the forces on motor and load, by the errors of stiffness, play, hysteresis and nut."""
    of_nut, loop = quantity["nut"].half_width * force if nut else 0.0, quantity.get("hysteresis")
    if measured:
        return 0.0, of_nut
    doubt = _doubt(
        quantity["large_stiffness" if loop else "stiffness"],
        quantity["play"],
        force,
        loop.half_width if loop else 0.0,
    )
    return math.hypot(doubt, of_nut) if nut else doubt, doubt


def _doubt(stiffness: Quantity, play: Quantity, force: float, width: float = 0.0) -> float:
    """Return the half-width of a force of the coupling, by the errors of its stiffness, its play and the width of its hysteresis."""
    return math.hypot(
        force * stiffness.half_width / stiffness.value,
        0.5 * stiffness.value * play.half_width,
        0.5 * width,
    )


def _refined(
    masses: Masses, records: Sequence[Record], step: float, lost: LostMotion, prior: Prior
) -> Masses:
    """Return the masses with a known play and stiffness, or the previous masses if the records do not show them."""
    try:
        return masses_of(records, step, lost.dead, prior) or masses
    except InputError:
        return masses


def _widened(fit: Fit, share: float) -> Fit:
    """Return a fit whose forces are uncertain by a further share, as a half-width."""
    variables = fit.friction.component.variables

    def wider(estimate: Estimate) -> Estimate:
        if (
            estimate.ends is None
            or estimate.name not in variables
            or not exponents_of(variables[estimate.name].quantity).get("force")
        ):
            return estimate
        low, high = estimate.ends
        middle, half = 0.5 * (low + high), math.hypot(0.5 * (high - low), share * estimate.value)
        return replace(
            estimate,
            interval=(middle - half, middle + half),
            robust_std=max(estimate.larger_std or 0.0, half / NORMAL_95),
        )

    return replace(fit, estimates=tuple(map(wider, fit.estimates)))
