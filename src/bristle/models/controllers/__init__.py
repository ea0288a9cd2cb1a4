"""Controllers, each in a file."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from bristle.core.contracts import Controller
from bristle.core.loading import loaded_from
from bristle.models.controllers.open_loop import open_loop as open_loop
from bristle.models.family import Family

if TYPE_CHECKING:
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
    # isort: on

__getattr__ = loaded_from(__name__)

# Controllers that a file may name; an open loop has no controller.
CONTROLLERS: Mapping[str, Controller] = Family(__name__)

__all__ = ["CONTROLLERS"]


def __dir__() -> list[str]:
    return [*CONTROLLERS, "open_loop"]
