"""What is found of a log before any model: how its channels stand in time, and how heavy the axis is."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Alignment"]


@dataclass(frozen=True)
class Alignment:
    """How the effort of a log stands in time to its position, and the inertia that was found with it."""

    delay: float | None = None
    delay_half_width: float | None = None
    smoothing: float | None = None
    smoothing_half_width: float | None = None
    mass: float | None = None
    mass_half_width: float | None = None
    slow: float = 0.0
    sought: bool = True
    of_position: bool = False
    filter_open: bool = False

    def as_data(self) -> dict[str, float]:
        """Return what is known of it, as the treatment of a log tells it."""
        smoothing = "position_smoothing" if self.of_position else "smoothing"
        data = {
            "delay": self.delay,
            "delay_half_width": self.delay_half_width,
            smoothing: abs(self.smoothing or 0.0) if self.of_position else self.smoothing,
            f"{smoothing}_half_width": self.smoothing_half_width,
            "mass": self.mass,
            "mass_half_width": self.mass_half_width,
            "slow": self.slow,
        }
        return {name: value for name, value in data.items() if value}
