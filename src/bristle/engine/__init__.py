"""The engine: integrators, drivers, and the only code besides the kernel decorator that compiles."""

from bristle.engine.adaptive import AdaptiveTrace, run_adaptive
from bristle.engine.batch import BatchTrace, run_batch
from bristle.engine.compilation import interpreted, is_interpreted
from bristle.engine.contact import Contact
from bristle.engine.loop import Compensator, LoopTrace, Trace, run_closed_loop, run_open_loop
from bristle.engine.motion import conditioned, force_along, response, settled

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
