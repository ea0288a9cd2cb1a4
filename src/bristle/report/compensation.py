"""What feeding the friction forward gains, from two variants of one loop."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bristle.core.status import Status
from bristle.core.typography import number, scale_of, with_unit
from bristle.core.variable import Kind, unit_of

if TYPE_CHECKING:
    from bristle.core.experiment import Variant
    from bristle.simulation.result import SimulationResult, VariantResult

__all__ = ["Gain", "gain_of"]

NO_CHANGE = 0.05  # relative change below which nothing is claimed
MOSTLY_LAG = 0.5  # share of the mean square of the following error that is in proportion to velocity


class Errors(NamedTuple):
    """The following error of one variant after its settling time, and what of it is lag.

    Parameters
    ----------
    peak_to_peak, beyond_lag : float
        Peak to peak [m or rad], as it is, and less the part in proportion to the velocity of the reference.
    lag : float
        That part over the velocity [s].
    lag_share : float
        Its share of the mean square, 0 to 1.
    """

    peak_to_peak: float
    beyond_lag: float
    lag: float
    lag_share: float


class Gain(NamedTuple):
    """The loop without friction fed forward, and with it; None for errors where a loop diverged."""

    errors: tuple[Errors, Errors] | None
    kind: Kind

    @property
    def peaks(self) -> str:
        """Following error peak to peak, without and with compensation, as text."""
        return "–" if self.errors is None else self._both([one.peak_to_peak for one in self.errors], " → ")

    def sentences(self) -> list[str]:
        """Return what compensation does to the following error, in words."""
        if self.errors is None:
            return ["A simulated loop left the finite numbers, so nothing can be said of the compensation."]
        before, after = (one.peak_to_peak for one in self.errors)
        old, new = (with_unit(one, unit_of("length", self.kind)) for one in (before, after))
        if after > (1.0 + NO_CHANGE) * before:
            found = [
                f"In simulation, feeding the friction forward raises the following error from {old} to {new} "
                "peak to peak: do not use this compensation as it is."
            ]
        elif after > (1.0 - NO_CHANGE) * before:
            found = [f"In simulation, feeding the friction forward hardly changes the following error ({self.peaks})."]
        else:
            times = f", by a factor of {before / after:.1f}" if after > 0.0 else ""
            found = [
                f"In simulation, feeding the friction forward lowers the following error from {old} to {new} "
                f"peak to peak{times}."
            ]
        return found + self._about_lag()

    def _about_lag(self) -> list[str]:
        assert self.errors is not None
        compensated = self.errors[1]
        if compensated.lag_share < MOSTLY_LAG:
            return []
        beyond = self._both([one.beyond_lag for one in self.errors], " to ")
        share, lag = 100.0 * compensated.lag_share, with_unit(compensated.lag, "s")
        return [
            f"{share:.3g} % of the mean square of what is left is in proportion to the velocity, a lag of {lag}: that "
            "is not friction but the position loop, and velocity fed forward removes it. Beyond this lag the error "
            f"goes from {beyond} peak to peak."
        ]

    def _both(self, values: list[float], between: str) -> str:
        scale = scale_of(unit_of("length", self.kind), max(values))
        return f"{between.join(number(one * scale.factor, digits=3) for one in values)} {scale.unit}"


def gain_of(simulation: SimulationResult) -> Gain | None:
    """Return the first variant without friction fed forward and the first one with it; None where one is missing."""
    variants = simulation.experiment.variants
    plain = next((one for one in variants if one.feedforward.friction is None), None)
    compensated = next((one for one in variants if one.feedforward.friction is not None), None)
    if plain is None or compensated is None:
        return None
    results = [simulation.variants[one.name] for one in (plain, compensated)]
    kind = simulation.experiment.kind
    if any(one.status is Status.NOT_FINITE for one in results):
        return Gain(None, kind)
    return Gain((_errors(plain, results[0]), _errors(compensated, results[1])), kind)


def _errors(variant: Variant, result: VariantResult) -> Errors:
    judged = slice(round(variant.run.settle / variant.run.sample_time), None)
    error = (result.reference - result.measured)[judged]
    velocity = np.gradient(result.reference, variant.run.sample_time)[judged]
    power, square = float(velocity @ velocity), float(error @ error)
    lag = float(error @ velocity) / power if power > 0.0 else 0.0
    beyond = error - lag * velocity
    share = 1.0 - float(beyond @ beyond) / square if square > 0.0 else 0.0
    return Errors(result.following_error.peak_to_peak, float(np.ptp(beyond)), lag, share)
