"""The loop of the rig, simulated once for all figures that show it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.content import Origin
from bristle.core.errors import BristleError, InputError
from bristle.core.experiment import Experiment
from bristle.core.lazy import cached_property
from bristle.core.status import Status
from bristle.core.typography import number
from bristle.files.experiment import read_experiment
from bristle.paper.bench import SETS
from bristle.simulation import SimulationResult, VariantResult, simulate

__all__ = ["BEFORE", "CALIBRATED", "NAMES", "PRINTED", "WITH_CONSTANT", "DivergedError", "Tracked", "spread_of", "with_spread"]

BEFORE, PRINTED, WITH_CONSTANT, CALIBRATED = "none", "printed", "printed_constant", "paper"
NAMES = {BEFORE: "no compensator", PRINTED: "(5)–(7) as printed", WITH_CONSTANT: "(5)–(7) and a constant", CALIBRATED: "calibrated, × 0.64"}
NEEDED = (BEFORE, CALIBRATED)


class DivergedError(BristleError):
    """A loop that was to be shown left the finite numbers."""

    exit_code = 1


@dataclass(frozen=True)
class Tracked:
    """The tracking experiment, simulated once for all figures that show it."""

    source: Path
    allow_code: bool = False
    needed: tuple[str, ...] = NEEDED
    listeners: list[Callable[[float, str], None]] = field(default_factory=list)

    @cached_property
    def experiment(self) -> Experiment:
        """The experiment."""
        experiment = read_experiment(self.source, allow_code=self.allow_code)
        names = [variant.name for variant in experiment.variants]
        for name in self.needed:
            if name not in names:
                raise InputError("is missing, and the figures of the paper need it", path=f"{self.source}: compare.{name}")
        return experiment

    @property
    def origin(self) -> Origin:
        """Name and checksum of its file."""
        return self.experiment.origins["experiment"][0]

    @cached_property
    def result(self) -> SimulationResult:
        """All variants, simulated."""
        result = simulate(self.experiment, self._tell)
        for name, loop in result.variants.items():
            if loop.status is Status.NOT_FINITE:
                raise DivergedError(f"{self.source}: compare.{name}: {loop.status.sentence}")
        return result

    def _tell(self, share: float, text: str) -> None:
        for listener in self.listeners:
            listener(share, text)

    @property
    def published(self) -> dict[str, VariantResult]:
        """The loops that figures show, by name: those of `NAMES` that the experiment has."""
        return {name: self.result.variants[name] for name in NAMES if name in self.result.variants}

    @property
    def pictured(self) -> dict[str, VariantResult]:
        """The same under the names that stand at their panels."""
        return {NAMES[name]: loop for name, loop in self.published.items()}

    @property
    def after(self) -> str:
        """The loop that the claims of the paper are held against: that of its own equations where there is one."""
        return PRINTED if PRINTED in self.result.variants else CALIBRATED

    @property
    def settle(self) -> float:
        """Time at the start that is left out [s]."""
        return self.experiment.variants[0].run.settle

    @property
    def arm(self) -> float:
        """Torque of the screw over force at the table [m/rad]."""
        return SETS["set_a"].lead / (2.0 * math.pi)

    def turn(self, before: float, after: float) -> tuple[float, float]:
        """Return two times around the highest point of the reference [s]."""
        loop = self.result.variants[BEFORE]
        judged = loop.time >= self.settle
        top = float(loop.time[judged][np.argmax(loop.reference[judged])])
        return top - before, top + after


def spread_of(loop: VariantResult, *keys: str) -> float:
    """Return the standard deviation over the runs of a number of `VariantResult.as_dict`; NaN for one run."""
    value: Any = loop.spread
    for key in keys:
        value = value.get(key, {}) if isinstance(value, Mapping) else value
    return float(value) if isinstance(value, float) else math.nan


def with_spread(value: float, spread: float, step: float) -> str:
    """Return a number with its spread as text, both to this step; without it where there is none."""
    text = number(value, resolution=step)
    return text if math.isnan(spread) else f"{text} ± {number(spread, resolution=step)}"
