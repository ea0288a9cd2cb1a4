"""Sensors, one a file."""

from bristle.core.contracts import Sensor
from bristle.sensors.encoder import MODEL as encoder

SENSORS: dict[str, Sensor] = {sensor.name: sensor for sensor in (encoder,)}

__all__ = ["SENSORS", "encoder"]
