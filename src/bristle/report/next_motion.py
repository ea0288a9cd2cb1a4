"""The motion to record next: the motion of `bristle excite` that narrows most of the open intervals."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bristle.core import Axis, InputError, Progress, unit_of
from bristle.identification import Estimate, Fit
from bristle.logs import Log, holds
from bristle.report.judgement import ADVICE
from bristle.report.model_tables import half_text

DRAWS = 20  # simulated logs for the intervals of a rehearsal
DURATION = "30 s"
WIDE = 30.0  # half-width [%] above which the interval of a parameter that matters counts as open


class NextMotion(NamedTuple):
    """A motion by its purposes, with the half-width of each parameter before and after the motion [% of the value].

    `options` are those of `bristle excite`, and `limits` the lines that the axis file lacks under [limits].
    """

    purposes: str
    half_widths: dict[str, tuple[float | None, float]]
    options: tuple[str, ...]
    limits: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The parameters with their half-widths before and after the motion."""
        changes = [
            f"{name} {half_text(now)} → {half_text(then)}"
            for name, (now, then) in self.half_widths.items()
        ]
        return ", ".join(changes)


def next_motion(
    fit: Fit, axis: Axis, log: Log, progress: Progress | None = None
) -> NextMotion | None:
    """Return the motion that narrows most of the open intervals of a fit; None if they are narrow, or no motion helps.

    Each candidate motion is designed and rehearsed on the identified axis, as `bristle excite --model` does. Without
    limits in the axis file it stays within the velocity and the travel of the log.
    """
    variables = fit.plant.component.variables | fit.friction.component.variables
    unknown = {estimate.name: estimate for estimate in fit.estimates if is_open(estimate)}
    kinds = {variables[name].excitation for name in unknown if name in variables}
    candidates = dict.fromkeys(
        ADVICE[kind][1] for kind in kinds if kind in ADVICE and ADVICE[kind][1]
    )
    if not candidates:
        return None
    from bristle.prediction.excitation import NARROWER, excite

    limited, limits = _with_limits(axis, fit)
    travel = (
        None if axis.stroke else f"{np.ptp(log.position.values):.2g} {unit_of('length', axis.kind)}"
    )
    options = ("--duration", DURATION, *(("--travel", travel) if travel else ()))
    best: NextMotion | None = None
    for place, purposes in enumerate(candidates):
        if progress is not None:
            progress(place / len(candidates), f"rehearsing a motion for {purposes}")
        try:
            motion = excite(
                limited,
                model=(fit.plant, fit.friction),
                purposes=purposes,
                duration=DURATION,
                travel=travel,
                draws=DRAWS,
            )
        except InputError:  # the axis file allows no such motion
            continue
        # No rehearsal, beyond the limits of the axis, or already in the log, which then does not keep the promise either.
        if motion.rehearsal is None or motion.exceeded or holds(log, motion.rehearsal.log):
            continue
        rehearsed = {
            estimate.name: estimate for estimate in motion.rehearsal.identification.best.estimates
        }
        present = {
            name: estimate.interval_percent if estimate.status == "identified" else None
            for name, estimate in unknown.items()
        }
        gained = {
            name: (present[name], _then(rehearsed.get(name), estimate))
            for name, estimate in unknown.items()
        }
        narrower = {
            name: (now, then)
            for name, (now, then) in gained.items()
            if then is not None and then < NARROWER * (now or 100.0)
        }
        if narrower and (best is None or len(narrower) > len(best.half_widths)):
            best = NextMotion(purposes, narrower, options, limits)
    return best


def _with_limits(axis: Axis, fit: Fit) -> tuple[Axis, tuple[str, ...]]:
    """Return an axis with the largest velocity and acceleration of the log for missing limits, and lines that state them."""
    lines, changes = [], {}
    for name, quantity, values in (
        ("velocity", "length/time", fit.traces.velocity),
        ("acceleration", "length/time/time", fit.traces.acceleration),
    ):
        if getattr(axis, f"{name}_limit") is None:
            largest = float(f"{np.max(np.abs(values)):.2g}")
            changes[f"{name}_limit"] = largest
            lines.append(f'{name} = "{largest:g} {unit_of(quantity, axis.kind)}"')
    return replace(axis, **changes), tuple(lines)


def is_open(estimate: Estimate) -> bool:
    """Return whether the interval of a parameter that matters to the force is open or wide."""
    if estimate.status == "held" or not (estimate.matters or estimate.is_rough):
        return False
    return estimate.status != "identified" or (estimate.interval_percent or 0.0) > WIDE


def _then(rehearsed: Estimate | None, estimate: Estimate) -> float | None:
    """Return the half-width that the rehearsal gives, in percent of the present value; None if the new interval misses this value."""
    if (
        rehearsed is None
        or rehearsed.status != "identified"
        or rehearsed.ends is None
        or not estimate.value
    ):
        return None
    low, high = rehearsed.ends
    return 50.0 * (high - low) / abs(estimate.value) if low <= estimate.value <= high else None
