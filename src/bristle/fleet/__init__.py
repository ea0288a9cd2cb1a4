"""Fleets: many logs identified each by itself into one store."""

from bristle.fleet.identify import identify_each

__all__ = ["identify_each"]
