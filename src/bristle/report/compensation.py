"""What feeding the friction forward gains, from two variants of one loop."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from bristle.core.status import Status
from bristle.core.typography import with_unit
from bristle.core.variable import Kind, unit_of

if TYPE_CHECKING:
    from bristle.simulation.result import SimulationResult, VariantResult

__all__ = ["Gain", "gain_of"]

NO_CHANGE = 0.05  # relative change below which nothing is claimed


class Gain(NamedTuple):
    """The loop without friction fed forward, and with it."""

    without: VariantResult
    compensated: VariantResult
    kind: Kind

    @property
    def diverged(self) -> bool:
        """Whether a loop left the finite numbers, so that its errors mean nothing."""
        return Status.NOT_FINITE in (self.without.status, self.compensated.status)

    @property
    def peaks(self) -> tuple[str, str]:
        """Following error peak to peak, without and with compensation, in words."""
        unit = unit_of("length", self.kind)
        before, after = (one.following_error.peak_to_peak for one in (self.without, self.compensated))
        return with_unit(before, unit), with_unit(after, unit)

    def sentence(self) -> str:
        """Return what compensation does to the following error, in words."""
        if self.diverged:
            return "A simulated loop left the finite numbers, so nothing can be said of the compensation."
        before, after = (one.following_error.peak_to_peak for one in (self.without, self.compensated))
        old, new = self.peaks
        if abs(after - before) <= NO_CHANGE * before:
            return (
                f"In simulation, feeding the friction forward leaves the following error as it is, {old} peak to peak."
            )
        if after > before:
            return (
                f"In simulation, feeding the friction forward raises the following error from {old} to {new} "
                "peak to peak: do not use this compensation as it is."
            )
        times = f", by a factor of {before / after:.1f}" if after > 0.0 else ""
        return (
            f"In simulation, feeding the friction forward lowers the following error from {old} to {new} "
            f"peak to peak{times}."
        )


def gain_of(simulation: SimulationResult) -> Gain | None:
    """Return the first variant without friction fed forward and the first one with it; None where one is missing."""
    variants = simulation.experiment.variants
    plain = next((one for one in variants if one.feedforward.friction is None), None)
    compensated = next((one for one in variants if one.feedforward.friction is not None), None)
    if plain is None or compensated is None:
        return None
    return Gain(simulation.variants[plain.name], simulation.variants[compensated.name], simulation.experiment.kind)
