"""Sensors, one a file."""

# Every sensor of bristle, a line each, in the order in which they are listed.
# isort: off
from bristle.sensors.encoder import encoder as encoder
# isort: on

from bristle.core.contracts import Sensor
from bristle.sensors.torque import torque_seen

SENSORS: dict[str, Sensor] = {sensor.name: sensor for sensor in tuple(vars().values()) if isinstance(sensor, Sensor)}

__all__ = ["SENSORS", "torque_seen"]


def __dir__() -> list[str]:
    return [*SENSORS, "torque_seen"]
