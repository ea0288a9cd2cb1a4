"""Models of an axis, each in a file: friction, hysteresis operators, plants, controllers, sensors, references.

A model states its equation and its source, and imports only `core`. It knows no log, no file and no figure.
"""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.models import controllers, friction, hysteresis, plants, references, sensors

__getattr__ = loaded_from(__name__)
