"""The engine: integrators, drivers, and the only code besides the kernel decorator that compiles."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.engine.adaptive import AdaptiveTrace, run_adaptive
    from bristle.engine.batch import WORTH_LANES, BatchTrace, run_batch
    from bristle.engine.checks import FRICTION
    from bristle.engine.compilation import interpreted, is_interpreted
    from bristle.engine.contact import Contact
    from bristle.engine.equations import contact_step, system_of
    from bristle.engine.loop import Compensator, LoopTrace, Trace, run_closed_loop, run_open_loop
    from bristle.engine.motion import conditioned, force_along, response, settled
    from bristle.engine.path import after

__getattr__ = loaded_from(__name__)

__all__ = [
    "AdaptiveTrace",
    "BatchTrace",
    "Compensator",
    "Contact",
    "LoopTrace",
    "Trace",
    "conditioned",
    "force_along",
    "interpreted",
    "is_interpreted",
    "response",
    "run_adaptive",
    "run_batch",
    "run_closed_loop",
    "run_open_loop",
    "settled",
]
