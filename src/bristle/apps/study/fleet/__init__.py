"""Fleets: many logs, identified separately, in one store."""

from bristle.apps.study.fleet.identify import identify_each
from bristle.core.loading import loaded_from

__getattr__ = loaded_from(__name__)
__all__ = ["identify_each"]
