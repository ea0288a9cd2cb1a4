"""Ratios that gears, leads and units have, when two numbers that should be one differ by such a factor."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bristle.core.axis import Axis
from bristle.core.diagnostic import Diagnostic
from bristle.logs.check.thresholds import CheckThresholds

__all__ = ["GEARS", "gears_near"]

GEARS = {
    "1/2": 0.5,
    "2": 2.0,
    "pi": np.pi,
    "1/pi": 1.0 / np.pi,
    "2 pi": 2.0 * np.pi,
    "1/(2 pi)": 0.5 / np.pi,
    "60": 60.0,
    "1/60": 1.0 / 60.0,
    "30/pi": 30.0 / np.pi,
    "pi/30": np.pi / 30.0,
    "180/pi": 180.0 / np.pi,
    "pi/180": np.pi / 180.0,
    "1000": 1e3,
    "1/1000": 1e-3,
}


def gears_near(ratio: float, of: str, axis: Axis, settings: CheckThresholds) -> Iterator[Diagnostic]:
    """Yield a ratio that is one of those that gears and units have."""
    name, value = min(GEARS.items(), key=lambda gear: abs(np.log(abs(ratio) / gear[1])))
    if abs(abs(ratio) / value - 1.0) < settings.gear_near:
        yield Diagnostic("gear_suspect", "", "warning", {"of": of, "ratio": ratio, "gear": name}, axis.kind)
