"""The demonstration: the main job on a simulated axis, whose friction no fitted model has."""

from bristle.demo.run import BANNER, run

__all__ = ["BANNER", "run"]
