"""Why a log does not determine a parameter, from what the log contains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.variable import Variable
from bristle.identification.dataset import Dataset
from bristle.identification.roles import Role, name_of
from bristle.identification.scales import Scales
from bristle.identification.settings import Settings
from bristle.logs.passages import passages_along

__all__ = ["Excitation"]


@dataclass(frozen=True)
class Excitation:
    """What a log shows of the parameters of a fit.

    Parameters
    ----------
    regression, scales : Regression, Scales
        The log.
    values, variables : mapping
        All parameters of the fit [SI] and what they are; the `excitation` of a variable names what it takes.
    settings : Settings
        The thresholds.
    """

    dataset: Dataset
    scales: Scales
    values: Mapping[str, float]
    variables: Mapping[str, Variable]
    settings: Settings

    def cause(self, name: str) -> Diagnostic:
        """Return what the log lacks to identify a parameter."""
        match self.variables[name].excitation:
            case "acceleration":
                top = float(np.max(np.abs(self.dataset.acceleration)))
                return self._lacking("low-acceleration", name, acceleration=top)
            case "speed":
                return self._about_speed(name)
            case "stribeck":
                return self._about_fall(name)
            case "presliding":
                return self._about_presliding(name)
            case "displacement":
                return self._lacking("no-bend", name, stroke=self.scales.stroke)
            case "sliding":
                return self._lacking("few-strokes", name, reversals=self._reversals, stroke=self.scales.stroke)
        return self._lacking("small-effect", name)

    def is_hidden(self, name: str, *, filtered: bool = True) -> bool:
        """Return whether a parameter shapes only what lasts less than a period of the filter, or less than the noise.

        Where nothing is `filtered`, as in a simulation, two samples take the place of that period.

        A pre-sliding zone that is crossed within one period of the cut-off leaves in the filtered effort its area but
        not its shape: the fit still has a clear minimum there, and it is one of the filter, not of friction. Noise
        of the position turns the friction of the model to and fro as pre-sliding would.
        """
        if self.variables[name].excitation != "presliding":
            return False
        if not self._reversals:
            return True
        zone = self._zone()
        if zone is None:
            return False
        period = self._filter_period if filtered else 2.0
        return self._samples_within(zone) < period or self._below_the_noise(name, zone) is not None

    @property
    def _reversals(self) -> int:
        return sum(len(turns) for turns in self.dataset.reversals)

    @property
    def _filter_period(self) -> float:
        """Samples of one period of the cut-off."""
        return 1.0 / (self.dataset.cutoff * self.dataset.sample_time)

    def _lacking(self, code: str, parameter: str, **numbers: Number) -> Diagnostic:
        return Diagnostic(code, parameter, "warning", numbers, self.dataset.kind)

    def _about_speed(self, name: str) -> Diagnostic:
        low, high = np.quantile(np.abs(self.dataset.velocity), [0.1, 0.9])
        code = "one-speed" if high < self.settings.one_speed * low else "low-speed"
        return self._lacking(code, name, speed=self.scales.speed)

    def _about_fall(self, name: str) -> Diagnostic:
        speeds = self.dataset.all_velocities
        fall = name_of(Role.FALL, self.variables)
        slow = self.scales.slowest if fall is None else self.values[fall]
        numbers = {"slow_samples": int(np.sum(np.abs(speeds) < slow)), "samples": speeds.size, "speed": slow}
        steady = self._steady_speeds()
        if not steady:
            return self._lacking("no-steady-slide", name, **numbers)
        return self._lacking("no-fall", name, **numbers, slowest=min(steady), fastest=max(steady))

    def _steady_speeds(self) -> list[float]:
        """Return the speeds at which the log slides steadily [m/s or rad/s], both ends of each passage."""
        dataset = self.dataset
        grain = max(self.settings.zone_counts * dataset.resolution, self.settings.zone_noise * dataset.noise)
        return [
            end
            for part in dataset.segments
            for passage in passages_along(part.time, part.position, part.effort, grain)
            if passage.kind == "constant_velocity"
            for end in passage.speeds
        ]

    def _about_presliding(self, name: str) -> Diagnostic:
        count, zone = self._reversals, self._zone()
        if not count:
            return self._lacking("no-reversal", name)
        if zone is None:
            return self._lacking("few-reversals", name, reversals=count)
        blurred = self._below_the_noise(name, zone)
        if blurred is not None:
            return blurred
        return self._lacking(
            "fast-reversals", name, reversals=count, zone=zone, samples=self._samples_within(zone),
            filter_samples=self._filter_period,
        )  # fmt: skip

    def _zone(self) -> float | None:
        """Return the displacement [m or rad] over which friction builds up, where the model has a stiffness."""
        stiffness = [
            value
            for name, value in self.values.items()
            if self.variables[name].quantity == "force/length" and value > 0.0
        ]
        return self.scales.force / max(stiffness) if stiffness else None

    def _below_the_noise(self, name: str, zone: float) -> Diagnostic | None:
        """Return why a displacement [m or rad] is too short for the position that was recorded, if it is."""
        dataset, least = self.dataset, self.settings
        if zone < least.zone_counts * dataset.resolution:
            return self._lacking(
                "coarse-position", name, zone=zone, counts=least.zone_counts, resolution=dataset.resolution
            )
        if zone < least.zone_noise * dataset.noise:
            return self._lacking("noisy-position", name, zone=zone, deviations=least.zone_noise, noise=dataset.noise)
        return None

    def _samples_within(self, zone: float) -> float:
        """Return the median number of samples from a reversal until the body has moved by `zone`."""
        counts = []
        for segment, turns in zip(self.dataset.segments, self.dataset.reversals, strict=True):
            for first in turns:
                left = np.abs(segment.position[first:] - segment.position[first]) > zone
                counts.append(int(np.argmax(left)) if left.any() else left.size)
        return float(np.median(counts))
