"""Sensors, one a file."""

from bristle.core.contracts import Sensor
from bristle.sensors.encoder import MODEL as encoder
from bristle.sensors.torque import torque_seen

SENSORS: dict[str, Sensor] = {sensor.name: sensor for sensor in (encoder,)}

__all__ = ["SENSORS", "encoder", "torque_seen"]


def __dir__() -> list[str]:
    return [name for name in __all__ if not name.isupper()]
