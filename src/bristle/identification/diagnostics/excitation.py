"""Why a log does not determine a parameter, from what the log contains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.lazy import cached_property
from bristle.core.variable import Variable
from bristle.identification.dataset import Dataset
from bristle.identification.roles import Role, name_of
from bristle.identification.scales import Scales
from bristle.identification.settings import Settings
from bristle.logs.passages import passages_along

__all__ = ["Excitation"]


@dataclass(frozen=True)
class Excitation:
    """What a log shows of the parameters of a fit [SI]; the `excitation` of a variable names what it takes."""

    dataset: Dataset
    scales: Scales
    values: Mapping[str, float]
    variables: Mapping[str, Variable]
    settings: Settings

    def cause(self, name: str) -> Diagnostic:
        """Return what the log lacks to identify a parameter."""
        code, numbers = self._lacking(self.variables[name].excitation)
        return Diagnostic(code, name, "warning", numbers, self.dataset.kind)

    def is_hidden(self, name: str, *, filtered: bool = True) -> bool:
        """Return whether a parameter shapes only what lasts less than a period of the filter, or less than the noise.

        Where nothing is `filtered`, as in a simulation, two samples take the place of that period.

        A pre-sliding zone that is crossed within one period of the cut-off leaves in the filtered effort its area but
        not its shape: the fit still has a clear minimum there, and it is one of the filter, not of friction. Noise
        of the position turns the friction of the model to and fro as pre-sliding would.
        """
        if self.variables[name].excitation != "presliding":
            return False
        if not self._reversals or self._zone is None:
            return not self._reversals
        period = self._filter_period if filtered else 2.0
        return self._samples_within(self._zone) < period or self._below_the_noise(self._zone) is not None

    def _lacking(self, excitation: str) -> tuple[str, dict[str, Number]]:
        """Return which kind of excitation a log lacks, as a code with its numbers."""
        dataset, scales = self.dataset, self.scales
        match excitation:
            case "acceleration":
                return "low_acceleration", {"acceleration": float(np.max(np.abs(dataset.acceleration)))}
            case "speed":
                low, high = np.quantile(np.abs(dataset.velocity), [0.1, 0.9])
                return "few_speeds" if high < self.settings.one_speed * low else "low_speed", {"speed": scales.speed}
            case "stribeck":
                return self._without_fall()
            case "presliding":
                return self._without_presliding()
            case "displacement":
                return "no_bend", {"stroke": scales.stroke}
            case "sliding":
                return "few_strokes", {"reversals": self._reversals, "stroke": scales.stroke}
        return "small_effect", {}

    def _without_fall(self) -> tuple[str, dict[str, Number]]:
        speeds, fall = self.dataset.all_velocities, name_of(Role.FALL, self.variables)
        slow = self.scales.slowest if fall is None else self.values[fall]
        numbers: dict[str, Number] = {
            "slow_samples": int(np.sum(np.abs(speeds) < slow)),
            "samples": speeds.size,
            "speed": slow,
        }
        grain = max(self.settings.zone_counts * self.dataset.resolution, self.settings.zone_noise * self.dataset.noise)
        steady = [
            speed
            for segment in self.dataset.segments
            for passage in passages_along(segment.time, segment.position, segment.effort, grain)
            if passage.kind == "constant_velocity"
            for speed in passage.speeds
        ]
        if not steady:
            return "no_steady_slide", numbers
        return "no_fall", numbers | {"slowest": min(steady), "fastest": max(steady)}

    def _without_presliding(self) -> tuple[str, dict[str, Number]]:
        count, zone = self._reversals, self._zone
        if not count:
            return "no_reversal", {}
        if zone is None:
            return "few_reversals", {"reversals": count}
        return self._below_the_noise(zone) or ("fast_reversals", {
            "reversals": count, "zone": zone, "samples": self._samples_within(zone),
            "filter_samples": self._filter_period,
        })  # fmt: skip

    def _below_the_noise(self, zone: float) -> tuple[str, dict[str, Number]] | None:
        """Return why a displacement [m or rad] is too short for the position that was recorded, if it is."""
        dataset, least = self.dataset, self.settings
        if zone < least.zone_counts * dataset.resolution:
            return "coarse_position", {"zone": zone, "counts": least.zone_counts, "resolution": dataset.resolution}
        if zone < least.zone_noise * dataset.noise:
            return "noisy_position", {"zone": zone, "deviations": least.zone_noise, "noise": dataset.noise}
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
        """Displacement [m or rad] over which friction builds up, where the model has a stiffness."""
        stiffness = [value for name, value in self.values.items() if self.variables[name].quantity == "force/length"]
        return self.scales.force / max(stiffness) if max(stiffness, default=0.0) > 0.0 else None

    def _samples_within(self, zone: float) -> float:
        """Return the median number of samples from a reversal until the body has moved by `zone`."""
        counts = []
        for segment, turns in zip(self.dataset.segments, self.dataset.reversals, strict=True):
            for first in turns:
                left = np.abs(segment.position[first:] - segment.position[first]) > zone
                counts.append(int(np.argmax(left)) if left.any() else left.size)
        return float(np.median(counts))
