"""Tuning of a running axis: the friction feedforward is identified, loaded, proved better, and kept, or the machine is restored."""

from typing import TYPE_CHECKING

from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.tune.machine import FrictionFeedforward, Limits, Machine, MachineRefusedError, MachineStoppedError, Recording
    from bristle.tune.run import Options
    from bristle.tune.tuning import Tuning, save, tune, undo

__getattr__ = loaded_from(__name__)
