"""Controllers, each in a file."""

# Every controller of bristle, in the order of the lists.
# isort: off
from bristle.models.controllers.cascade import cascade as cascade
from bristle.models.controllers.sliding_mode import sliding_mode as sliding_mode
from bristle.models.controllers.disturbance_observer import (
    disturbance_observer as disturbance_observer,
)
from bristle.models.controllers.super_twisting import super_twisting as super_twisting
from bristle.models.controllers.lugre_observer import lugre_observer as lugre_observer
from bristle.models.controllers.adaptive_hysteresis import (
    adaptive_hysteresis as adaptive_hysteresis,
)
from bristle.models.controllers.asymptotic_observer import (
    asymptotic_observer as asymptotic_observer,
)
from bristle.models.controllers.predictive_reversal import (
    predictive_reversal as predictive_reversal,
)
from bristle.models.controllers.open_loop import open_loop as open_loop
# isort: on

from bristle.core.contracts import Controller

# Controllers that a file may name; an open loop has no controller.
CONTROLLERS: dict[str, Controller] = {
    controller.name: controller
    for controller in tuple(vars().values())
    if isinstance(controller, Controller) and controller is not open_loop
}

__all__ = ["CONTROLLERS"]


def __dir__() -> list[str]:
    return [*CONTROLLERS, "open_loop"]
