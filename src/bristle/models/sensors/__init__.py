"""Sensors, each in a file."""

# Every sensor of bristle, in the order of the lists.
# isort: off
from bristle.models.sensors.encoder import encoder as encoder
# isort: on

from bristle.core.contracts import Sensor
from bristle.models.sensors.torque import torque_seen

SENSORS: dict[str, Sensor] = {
    sensor.name: sensor for sensor in tuple(vars().values()) if isinstance(sensor, Sensor)
}

__all__ = ["SENSORS", "torque_seen"]


def __dir__() -> list[str]:
    return [*SENSORS, "torque_seen"]
