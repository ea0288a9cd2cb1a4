"""Controllers, one a file."""

from bristle.controllers.adaptive_hysteresis import MODEL as adaptive_hysteresis
from bristle.controllers.cascade import MODEL as cascade
from bristle.controllers.disturbance_observer import MODEL as disturbance_observer
from bristle.controllers.lugre_observer import MODEL as lugre_observer
from bristle.controllers.open_loop import MODEL as open_loop
from bristle.controllers.sliding_mode import MODEL as sliding_mode
from bristle.controllers.super_twisting import MODEL as super_twisting
from bristle.core.contracts import Controller

# Those that a file may name: an open loop has none.
CONTROLLERS: dict[str, Controller] = {
    controller.name: controller
    for controller in (cascade, sliding_mode, disturbance_observer, super_twisting, lugre_observer, adaptive_hysteresis)
}

__all__ = [
    "CONTROLLERS",
    "adaptive_hysteresis",
    "cascade",
    "disturbance_observer",
    "lugre_observer",
    "open_loop",
    "sliding_mode",
    "super_twisting",
]


def __dir__() -> list[str]:
    return [name for name in __all__ if not name.isupper()]
