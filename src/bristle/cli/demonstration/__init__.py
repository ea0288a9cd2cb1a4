"""The demonstration: the whole workflow on a simulated axis whose friction differs in structure from every fitted model."""

from bristle.cli.demonstration.run import BANNER, run

__all__ = ["BANNER", "run"]
