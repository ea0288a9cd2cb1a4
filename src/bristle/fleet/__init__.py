"""Fleets: many logs, identified separately, in one store."""

from bristle.fleet.identify import identify_each

__all__ = ["identify_each"]
