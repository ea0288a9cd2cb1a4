"""Fleets: many logs, identified separately, in one store."""

from functools import partial

from bristle.fleet.identify import identify_each
from bristle.removed import removed_name

__getattr__ = partial(removed_name, __name__)
__all__ = ["identify_each"]
