"""Why a log does not determine a parameter, in words, from what the log contains."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bristle.core.typography import with_unit
from bristle.core.variable import Variable, unit_of
from bristle.identification.dataset import Dataset
from bristle.identification.parameters import Scales
from bristle.logs.passages import passages_along

__all__ = ["out_of_sight", "why_unidentifiable"]

NARROW = 1.3  # ratio of speeds below which a log has one speed only
NOISE_IN_ZONE = 10.0  # standard deviations: a noise that looks like pre-sliding has a zone of 5 to 8 of them
COUNTS_IN_ZONE = 2.0  # of the encoder


def why_unidentifiable(
    variable: Variable, dataset: Dataset, scales: Scales, values: Mapping[str, float],
    variables: Mapping[str, Variable],
) -> str:  # fmt: skip
    """Return what the log lacks to identify a parameter.

    Parameters
    ----------
    variable : Variable
        The parameter; its `excitation` names what it takes.
    regression, scales : Regression, Scales
        The log.
    values, variables : mapping
        All parameters of the fit [SI] and what they are.
    """
    kind = dataset.kind
    match variable.excitation:
        case "acceleration":
            top = with_unit(float(np.max(np.abs(dataset.acceleration))), unit_of("length/time^2", kind))
            return f"the acceleration never exceeds {top}; give the mass or inertia in the axis file"
        case "speed":
            return _about_speed(dataset, scales)
        case "stribeck":
            slow = values.get("v_S", scales.slowest)
            count = int(np.sum(np.abs(dataset.all_velocities) < slow))
            return (
                f"the log does not show the force fall with speed ({count} of {dataset.all_velocities.size} samples "
                f"are slower than {with_unit(slow, unit_of('length/time', kind))}, {_steady_slides(dataset)})"
            )
        case "presliding":
            return _about_presliding(dataset, scales, values, variables)
        case "displacement":
            return (
                f"over a stroke of {with_unit(scales.stroke, unit_of('length', kind))} the log does not show the force "
                "bend"
            )
        case "sliding":
            return (
                f"the log holds {len(dataset.reversals)} reversals over a stroke of "
                f"{with_unit(scales.stroke, unit_of('length', kind))}"
            )
    return "its effect on the effort is smaller than what the model misses"


def out_of_sight(
    variable: Variable, dataset: Dataset, scales: Scales, values: Mapping[str, float],
    variables: Mapping[str, Variable], *, filtered: bool = True,
) -> bool:  # fmt: skip
    """Return whether a parameter shapes only what lasts less than a period of the filter, or less than the noise.

    Where nothing is `filtered`, as in a simulation, two samples take the place of that period.

    A pre-sliding zone that is crossed within one period of the cut-off leaves in the filtered effort its area but not
    its shape: the fit still has a clear minimum there, and it is one of the filter, not of friction. Noise
    of the position turns the friction of the model to and fro as pre-sliding would.
    """
    if variable.excitation != "presliding":
        return False
    if not dataset.reversals:
        return True
    zone = _presliding_zone(scales, values, variables)
    if zone is None:
        return False
    period = 1.0 / (dataset.sample_time * dataset.cutoff) if filtered else 2.0
    fast = _samples_within(dataset, zone) < period
    return fast or bool(_below_the_noise(dataset, zone))


def _below_the_noise(dataset: Dataset, zone: float) -> str:
    """Return in words why a displacement [m or rad] is too short for the position that was recorded, if it is."""
    unit = unit_of("length", dataset.kind)
    if zone < COUNTS_IN_ZONE * dataset.resolution:
        return (
            f"the pre-sliding zone of {with_unit(zone, unit)} is less than {COUNTS_IN_ZONE:.0f} steps of the recorded "
            f"position ({with_unit(dataset.resolution, unit)} each)"
        )
    if zone < NOISE_IN_ZONE * dataset.noise:
        return (
            f"the pre-sliding zone of {with_unit(zone, unit)} is less than {NOISE_IN_ZONE:.0f} times the noise of the "
            f"position ({with_unit(dataset.noise, unit)} standard deviation), which turns friction alike"
        )
    return ""


def _presliding_zone(scales: Scales, values: Mapping[str, float], variables: Mapping[str, Variable]) -> float | None:
    """Return the displacement [m or rad] over which friction builds up, where the model has a stiffness."""
    stiffness = [value for name, value in values.items() if variables[name].quantity == "force/length" and value > 0.0]
    return scales.force / max(stiffness) if stiffness else None


def _steady_slides(dataset: Dataset) -> str:
    """Return in words at which speeds the log slides steadily."""
    grain = max(COUNTS_IN_ZONE * dataset.resolution, NOISE_IN_ZONE * dataset.noise)
    speeds = [
        end
        for one in dataset.segments
        for found in passages_along(one.time, one.position, one.effort, grain)
        if found.kind == "constant_velocity"
        for end in found.speeds
    ]
    if not speeds:
        return "and none of its motion is a slide at constant velocity"
    low, high = (with_unit(end(speeds), unit_of("length/time", dataset.kind)) for end in (min, max))
    return f"and it slides steadily at {low}" + (f" to {high}" if high != low else "")


def _about_speed(dataset: Dataset, scales: Scales) -> str:
    speeds = np.abs(dataset.velocity)
    low, high = np.quantile(speeds, [0.1, 0.9])
    top = with_unit(scales.speed, unit_of("length/time", dataset.kind))
    if high < NARROW * low:
        return f"the log moves at one speed only, {top}"
    return f"the log never exceeds {top}"


def _about_presliding(
    dataset: Dataset, scales: Scales, values: Mapping[str, float], variables: Mapping[str, Variable]
) -> str:
    count = len(dataset.reversals)
    if not count:
        return "the log has no reversal"
    times = "reversal" if count == 1 else "reversals"
    zone = _presliding_zone(scales, values, variables)
    if zone is None:
        return f"the log has only {count} {times}"
    blurred = _below_the_noise(dataset, zone)
    if blurred:
        return blurred
    samples = _samples_within(dataset, zone)
    return (
        f"the log has only {count} {times}, each crosses the pre-sliding zone of "
        f"{with_unit(zone, unit_of('length', dataset.kind))} in {samples:.0f} samples, where a period of the "
        f"filter takes {1.0 / (dataset.cutoff * dataset.sample_time):.0f}"
    )


def _samples_within(dataset: Dataset, zone: float) -> float:
    """Return the median number of samples from a reversal until the body has moved by `zone`."""
    counts = []
    for number, first in dataset.reversals:
        position = dataset.segments[number].position[first:]
        left = np.abs(position - position[0]) > zone
        counts.append(int(np.argmax(left)) if left.any() else left.size)
    return float(np.median(counts))
