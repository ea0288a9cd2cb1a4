"""Sensors, each in a file."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from bristle.core.contracts import Sensor
from bristle.core.loading import loaded_from
from bristle.models.family import Family

if TYPE_CHECKING:
    # Every sensor of bristle, in the order of the lists.
    # isort: off
    from bristle.models.sensors.encoder import encoder as encoder

    # isort: on
    from bristle.models.sensors.torque import torque_seen

__getattr__ = loaded_from(__name__)

SENSORS: Mapping[str, Sensor] = Family(__name__)

__all__ = ["SENSORS", "torque_seen"]


def __dir__() -> list[str]:
    return [*SENSORS, "torque_seen"]
