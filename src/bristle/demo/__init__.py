"""The demonstration: the whole workflow on a simulated axis whose friction differs in structure from every fitted model."""

from functools import partial

from bristle.demo.run import BANNER, run
from bristle.removed import removed_name

__getattr__ = partial(removed_name, __name__)
__all__ = ["BANNER", "run"]
