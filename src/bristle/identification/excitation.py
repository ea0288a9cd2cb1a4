"""The parameters that the motion of a log does not determine, or confounds, for any model."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bristle.core.axis import Axis
from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.lazy import cached_property
from bristle.core.variable import Variable
from bristle.identification.dataset import Dataset
from bristle.identification.half_cycles import most_apart
from bristle.identification.parameters import (
    PriorKnowledge,
    Role,
    Scales,
    acts_in_sliding,
    constant_of,
    name_of,
    names_of,
)
from bristle.identification.result import Fit
from bristle.identification.settings import Settings
from bristle.logs.check import checked_together
from bristle.logs.log import Log
from bristle.logs.passages import passages_along
from bristle.logs.turns import period_of

ENOUGH_REVERSALS = (
    10  # for friction in both directions: with more of them, a lack of motion is not the cause
)


@dataclass(frozen=True)
class Excitation:
    """Information of a log about the parameters of a fit [SI]; the `excitation` of a variable names the motion it needs."""

    dataset: Dataset
    scales: Scales
    values: Mapping[str, float]
    variables: Mapping[str, Variable]
    settings: Settings

    def cause(self, name: str) -> Diagnostic:
        """Return the reason why the log does not identify a parameter."""
        dataset, scales = self.dataset, self.scales
        code, numbers = "small_effect", dict[str, Number]()
        match self.variables[name].excitation:
            case "acceleration":
                code, numbers = (
                    "low_acceleration",
                    {"acceleration": float(np.max(np.abs(dataset.acceleration)))},
                )
            case "speed":
                low, high = np.quantile(np.abs(dataset.velocity), [0.1, 0.9])
                code, numbers = (
                    "few_speeds" if high < self.settings.one_speed * low else "low_speed",
                    {"speed": scales.speed},
                )
            case "stribeck":
                code, numbers = self._without_fall()
            case "presliding":
                code, numbers = self._without_presliding()
            case "displacement":
                code, numbers = "few_strokes", {"stroke": scales.stroke}
            case "sliding" if self._reversals < ENOUGH_REVERSALS:
                code, numbers = (
                    "few_strokes",
                    {"reversals": self._reversals, "stroke": scales.stroke},
                )
        return Diagnostic(code, name, "warning", numbers, dataset.kind)

    def is_hidden(self, name: str, *, filtered: bool = True) -> bool:
        """Return whether the effect of a parameter is shorter than a period of the filter, or smaller than the noise."""
        # If the pre-sliding zone is crossed within one period of the cut-off, the filtered effort keeps its area but not its
        # shape. The fit still has a clear minimum, but it reflects the filter, not friction. Position noise makes the
        # friction of the model alternate as pre-sliding would.
        if self.variables[name].excitation != "presliding":
            return False
        if not self._reversals or self._zone is None:
            return not self._reversals
        period = self._filter_period if filtered else 2.0
        return (
            self._samples_within(self._zone) < period
            or self._below_the_noise(self._zone) is not None
        )

    def _without_fall(self) -> tuple[str, dict[str, Number]]:
        speeds, fall = self.dataset.all_velocities, name_of(Role.FALL, self.variables)
        slow = self.scales.slowest if fall is None else self.values[fall]
        numbers: dict[str, Number] = {
            "slow_samples": int(np.sum(np.abs(speeds) < slow)),
            "samples": speeds.size,
            "speed": slow,
        }
        grain = shortest_zone(self.dataset, self.settings)
        steady = [
            speed
            for segment in self.dataset.segments
            for passage in passages_along(segment.time, segment.position, segment.effort, grain)
            if passage.kind == "constant_velocity"
            for speed in passage.speeds
        ]
        return "no_fall", numbers | (
            {"slowest": min(steady), "fastest": max(steady)} if steady else {}
        )

    def _without_presliding(self) -> tuple[str, dict[str, Number]]:
        count, zone = self._reversals, self._zone
        if not count or zone is None:
            return "few_reversals", {"reversals": count} if count else {}
        return self._below_the_noise(zone) or (
            "few_reversals",
            {
                "reversals": count,
                "zone": zone,
                "samples": self._samples_within(zone),
                "filter_samples": self._filter_period,
            },
        )

    def _below_the_noise(self, zone: float) -> tuple[str, dict[str, Number]] | None:
        """Return why a displacement [m or rad] is too short for the recorded position, or None."""
        dataset, least = self.dataset, self.settings
        if zone < least.zone_counts * dataset.resolution:
            return "coarse_position", {
                "zone": zone,
                "counts": least.zone_counts,
                "resolution": dataset.resolution,
            }
        if zone < least.zone_noise * dataset.noise:
            return "coarse_position", {
                "zone": zone,
                "deviations": least.zone_noise,
                "noise": dataset.noise,
            }
        return None

    @property
    def _reversals(self) -> int:
        return sum(len(turns) for turns in self.dataset.reversals)

    @property
    def _filter_period(self) -> float:
        """Samples of one period of the cut-off."""
        return 1.0 / (self.dataset.cutoff * self.dataset.sample_time)

    @cached_property
    def _zone(self) -> float | None:
        """Displacement [m or rad] over which friction builds up, if the model has a stiffness."""
        stiffness = [
            value
            for name, value in self.values.items()
            if self.variables[name].quantity == "force/length"
        ]
        return self.scales.force / max(stiffness) if max(stiffness, default=0.0) > 0.0 else None

    def _samples_within(self, zone: float) -> float:
        """Return the median number of samples from a reversal until the body has moved by `zone`."""
        counts = []
        for segment, turns in zip(self.dataset.segments, self.dataset.reversals, strict=True):
            for first in turns:
                left = np.abs(segment.position[first:] - segment.position[first]) > zone
                counts.append(int(np.argmax(left)) if left.any() else left.size)
        return float(np.median(counts))


def shortest_zone(dataset: Dataset, settings: Settings) -> float:
    """Return the shortest displacement [m or rad] that encoder and noise resolve."""
    return max(settings.zone_counts * dataset.resolution, settings.zone_noise * dataset.noise)


def spread_between_repeats(dataset: Dataset) -> float:
    """Return the difference of the effort between repetitions [%]; 0 if the motion of a log is not periodic."""
    efforts, changes = list[np.ndarray](), list[np.ndarray]()
    for log in range(dataset.segments[-1].log + 1):
        longest = max(
            (segment for segment in dataset.segments if segment.log == log),
            key=lambda segment: segment.time.size,
        )
        period = period_of(longest.position, dataset.sample_time)
        if period is None:
            return 0.0
        later = round(period / dataset.sample_time)
        efforts.append(longest.effort)
        changes.append(longest.effort[later:] - longest.effort[:-later])
    size, change = (
        float(np.sqrt(np.mean(np.concatenate(parts) ** 2))) for parts in (efforts, changes)
    )
    return 100.0 * change / size if size > 0.0 else 0.0


def about_logs(
    fit: Fit, dataset: Dataset, names: Sequence[str], settings: Settings
) -> tuple[Diagnostic, ...]:
    """Return a note on the log whose friction differs most from that of the others, if the difference is clear."""
    if len(names) == 1:
        return ()
    level = (
        fit.traces.predicted
        - fit.traces.mechanical
        - constant_of(fit.friction.component.variables, fit.friction.values)
    )
    number, share, error = most_apart(dataset, level, fit.traces.residual)
    if abs(share) <= max(settings.level_drift, settings.sure * error):
        return ()
    numbers: dict[str, Number] = {
        "log": names[number] or f"log {number + 1}",
        "percent": 100.0 * share,
    }
    return (Diagnostic("log_differs", "", "note", numbers, dataset.kind),)


TRADED = {
    "one_speed": ("sliding", "speed", "stribeck"),
    "one_direction": ("sliding", "stribeck"),
    "level_drifts": ("sliding", "speed", "stribeck"),
    "clipped": ("acceleration", "sliding", "speed", "stribeck"),
    "scale_steps": ("acceleration", "sliding", "speed", "stribeck"),
    "high_passed": ("acceleration", "sliding", "speed", "stribeck"),
    "saturates": ("acceleration", "sliding", "speed", "stribeck"),
    "never_slides": ("acceleration", "sliding", "speed", "stribeck"),
}
"""By code, the excitation of parameters that such a log confounds."""
# Reasons to hold a parameter constant that the log does not determine.
BY_THE_LOG = ("held_one_direction", "held_one_speed")


def checks_of(
    pairs: Sequence[tuple[Log, Axis | None]], prior: PriorKnowledge, settings: Settings
) -> tuple[Diagnostic, ...]:
    """Return the checks of the logs before an identification, the first of each code."""
    mass = sum(
        prior.values[name]
        for name in names_of(Role.INERTIA, prior.plant.variables)
        if name in prior.values
    )
    described = [
        (log, replace(axis or Axis(kind=log.kind), mass=mass or None)) for log, axis in pairs
    ]
    by_code: dict[str, Diagnostic] = {}
    for diagnostic in checked_together(described, settings):
        by_code.setdefault(diagnostic.code, diagnostic)
    return tuple(by_code.values())


def with_checks(fit: Fit, diagnostics: Sequence[Diagnostic]) -> Fit:
    """Return a fit with the checks of its logs, and the parameters that they concern."""
    added = list[Diagnostic]()
    variables = {**fit.plant.component.variables, **fit.friction.component.variables}
    unseen = {
        estimate.name: variables[estimate.name]
        for estimate in fit.estimates
        # A fit with elements has more parameters than its models.
        if estimate.name in variables
        and (
            estimate.status != "held"
            or (estimate.reason is not None and estimate.reason.code in BY_THE_LOG)
        )
    }
    for diagnostic in diagnostics:
        code = diagnostic.code
        # The model has the slot that it proposes.
        if code == "level_over_position" and "+position" in fit.friction.name:
            continue
        # Parameters that are confounded in this case.
        names = tuple(
            name
            for name, variable in unseen.items()
            if variable.excitation in TRADED.get(code, ())
            or (code == "never_slides" and acts_in_sliding(variable))
        )
        added.append(
            replace(diagnostic, numbers={**diagnostic.numbers, "names": names})
            if names
            else diagnostic
        )
    return replace(fit, diagnostics=(*fit.diagnostics, *added))
