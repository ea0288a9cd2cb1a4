"""An inertia on a contact: pushed over break-away, let rest, then loaded up and down below it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.engine import run_open_loop
from bristle.paper.setting import Setting
from bristle.paper.torque_bench import Sensed, bench_of, plant_of, read_torque

__all__ = ["Rippled", "rippled", "torque_of"]

SAMPLE_TIME, STEPS = 2.5e-4, 4


class Rippled(NamedTuple):
    """What a torque up and down does to a contact."""

    time: np.ndarray
    driving: np.ndarray
    x: np.ndarray
    torque: np.ndarray
    cycles: np.ndarray
    sensed: Sensed | None = None

    @property
    def moved(self) -> np.ndarray:
        """How far the table went in each cycle [m]."""
        return np.diff(self.x[self.cycles])


def torque_of(setting: Setting) -> tuple[np.ndarray, np.ndarray]:
    """Return the driving torque of an experiment [N*m], sample by sample, and the samples at which cycles begin.

    It rises over four periods to where the contact breaks away, falls over two to the upper level of the ripple,
    and goes down and up from there.
    """
    top, low, high = (float(setting["torque", key]) for key in ("break_away", "low", "high"))
    if not low < high < top:
        raise InputError("must have low < high < break_away", path=f"{setting.source}: torque", value=(low, high, top))
    period, cycles = round(setting["torque", "period"] / SAMPLE_TIME), round(setting["torque", "cycles"])
    wave = low + (high - low) * np.abs(2.0 * ((np.arange(cycles * period + 1) / period) % 1.0) - 1.0)
    rise = np.linspace(0.0, top, 4 * period, endpoint=False)
    back = np.linspace(top, high, 2 * period, endpoint=False)
    start = rise.size + back.size
    return np.concatenate((rise, back, wave)), start + period * np.arange(cycles + 1)


def rippled(setting: Setting, friction: Model) -> Rippled:
    """Return what the torque of an experiment does to a contact."""
    driving, cycles = torque_of(setting)
    arm = setting.arm
    trace = run_open_loop(plant_of(setting), friction, driving / arm, SAMPLE_TIME, steps=STEPS, hold="linear")
    torque, sensed = trace.friction * arm, None
    if "bench" in setting.numbers:
        # Between samples the torque runs straight from one to the next.
        mean = 0.5 * (driving[:-1] + driving[1:])
        sensed = read_torque(bench_of(setting), mean, trace.velocity / arm, torque[:-1], SAMPLE_TIME)
    return Rippled(trace.time, driving, trace.position, torque, cycles, sensed)
