"""Tuning of a running axis: the friction feedforward is identified, loaded, proved better, and kept, or the machine is restored."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.apps.tune.machine import (
        FrictionFeedforward,
        Limits,
        Machine,
        MachineRefusedError,
        MachineStoppedError,
        Recording,
    )
    from bristle.apps.tune.run import Options, Tuning
    from bristle.apps.tune.tuning import save, tune, undo

__getattr__ = loaded_from(__name__)
