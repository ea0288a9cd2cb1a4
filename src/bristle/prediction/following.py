"""The following error that a log has, beside that of the simulated loop: the log is the judge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.diagnostic import Diagnostic
from bristle.core.experiment import Variant
from bristle.core.status import Status
from bristle.identification.settings import DEFAULT, Settings
from bristle.logs.log import Log
from bristle.prediction.loop import longest_of
from bristle.prediction.suspects import apart, explanations
from bristle.simulation.compensation import AS_RECORDED, COMPENSATED, settling
from bristle.simulation.result import SimulationResult, Statistics, statistics_of

__all__ = ["Following", "following_of"]


@dataclass(frozen=True, eq=False)
class Following:
    """How an axis followed its reference, as recorded and as simulated."""

    time: np.ndarray
    error: np.ndarray
    measured: Statistics
    simulated: Statistics | None = None
    compensated: Statistics | None = None
    contradiction: Diagnostic | None = None

    def as_data(self) -> dict[str, Any]:
        """Return it as it stands in JSON; a gain that is not believed is none."""
        believed = None if self.contradiction is not None else self.compensated
        sides = {"measured": self.measured, "simulated": self.simulated, "compensated": believed}
        return {name: None if error is None else {"peak_to_peak": error.peak_to_peak, "rms": error.rms} for name, error in sides.items()}


def following_of(log: Log, simulation: SimulationResult | None = None, settings: Settings = DEFAULT) -> Following | None:
    """Return how an axis followed its reference."""
    if log.reference is None:
        return None
    everywhere, part = log.reference.values - log.position.values, longest_of(log)
    error = everywhere[part]
    time = log.sample_time * np.arange(error.size)
    simulable = statistics_of(error[_settled(error.size, log.sample_time)])
    first = log.segments[0]
    judged = np.ones(everywhere.size, dtype=bool)
    judged[first] = _settled(first.stop - first.start, log.sample_time)
    measured = statistics_of(everywhere[judged])
    if simulation is None:
        return Following(time, error, measured)
    simulated, compensated = (_completed(simulation, name) for name in (AS_RECORDED, COMPENSATED))
    differs = simulated is None or apart(simulable, simulated) > settings.loop_differs
    recorded = next(variant for variant in simulation.experiment.variants if variant.name == AS_RECORDED)
    contradiction = _contradiction(recorded, error, simulable, simulated, settings) if differs else None
    return Following(time, error, measured, simulated, compensated, contradiction)


def _settled(count: int, dt: float) -> np.ndarray:
    """Return which samples of a stretch are behind the time in which its loop settles."""
    return dt * np.arange(count) >= settling(dt * count) - 0.5 * dt


def _completed(simulation: SimulationResult, name: str) -> Statistics | None:
    variant = simulation.variants[name]
    return None if variant.status is Status.NOT_FINITE else variant.following_error


def _contradiction(
    variant: Variant, error: np.ndarray, measured: Statistics, simulated: Statistics | None, settings: Settings
) -> Diagnostic:
    """Return by how much a loop is another one than the log shows, and what would explain that."""
    suspects = explanations(variant, error, settings.loop_differs)
    sides = {"measured": measured, "simulated": simulated} if simulated is not None else {"measured": measured}
    errors = {name: side.peak_to_peak for name, side in sides.items()}
    errors |= {f"{name}_rms": side.rms for name, side in sides.items()}
    causes = {
        "suspects": tuple(_side(cause.value) if cause.name == "reference" else cause.name for cause in suspects),
        "factors": tuple(abs(cause.value) for cause in suspects),
    }
    return Diagnostic("loop_contradicts", numbers=errors | causes, kind=variant.plant.kind)


def _side(time: float) -> str:
    return "reference_later" if time > 0.0 else "reference_earlier"
