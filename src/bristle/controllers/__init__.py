"""Controllers, one a file."""

from bristle.controllers.cascade import MODEL as cascade
from bristle.core.contracts import Controller

CONTROLLERS: dict[str, Controller] = {controller.name: controller for controller in (cascade,)}

__all__ = ["CONTROLLERS", "cascade"]
