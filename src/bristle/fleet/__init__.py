"""Fleets: many logs, identified separately, in one store."""

from bristle.fleet.identify import identify_each
from bristle.loading import loaded_from

__getattr__ = loaded_from(__name__)
__all__ = ["identify_each"]
