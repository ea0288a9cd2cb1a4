"""Figures 1 and 8: the contact led along a path up to break-away."""

from __future__ import annotations

import math

import numpy as np

from bristle.certificates import holding_of
from bristle.core.errors import InputError
from bristle.core.typography import number
from bristle.paper.economy import repeated
from bristle.paper.reproduced import Reproduced, in_micrometres, percent, spread
from bristle.paper.returns import comes_back, missing_at, must_return, told, traces, walks_of
from bristle.paper.setting import Setting
from bristle.paper.torque_bench import bench_of, led, sensor_numbers, sensor_says
from bristle.paper.walk import Walk

__all__ = ["figure_1", "figure_8"]

NEARLY = 0.95  # of the break-away torque: where an eye sees it
SAID = 7e-6  # where the paper sees it [m]
LUGRE, RIG = "LuGre", "virtual rig"
FRICTION, SENSOR = f"{RIG}, friction", f"{RIG}, torque sensor"


def figure_1(setting: Setting) -> Reproduced:
    """Return figure 1: from A over B, C and B again to D, LuGre beside a contact that closes its loops."""
    from bristle.figures import marked_path

    must_return(setting, ((0, 2),))
    walks = walks_of(setting, LUGRE, RIG)
    missing = {name: missing_at(one, (0, 2)) for name, one in walks.items()}
    found = [f"{name}: {comes_back(share, 'B')}." for name, share in missing.items()]
    return Reproduced(
        number=1,
        verdict="found" if abs(missing[LUGRE]) > 5.0 * abs(missing[RIG]) else "refuted",
        found=found,
        draw=lambda: marked_path(
            traces(walks), {name: [0, *one.turns] for name, one in walks.items()}, "ABCBD",
            {name: f"{name}: {told(missing[name])}" for name in walks}, "translational", "rotational",
        ),
        origin=setting.origin,
        numbers={"missing_at_return": missing},
    )  # fmt: skip


def figure_8(setting: Setting) -> Reproduced:
    """Return figure 8: where friction breaks away when the table is moved one way."""
    from bristle.figures import break_away

    if np.any(setting["path", "turns"] <= 0.0):
        raise InputError("must lead forward", path=f"{setting.source}: path.turns", allowed="> 0 m")
    walks, bench, rig = walks_of(setting, RIG), bench_of(setting), setting.contact(RIG)
    runs = [led(setting, one, setting["path", "turns"], setting["path", "speed"]) for one in repeated(setting, rig)]
    sensor = sensor_numbers([one.sensed for one in runs])
    walks[RIG] = runs[0].sensor
    # A limit that scatters may lie above the one that it starts with.
    held = {
        name: max(setting.arm * holding_of(model).forward, float(np.max(walks[name].torque)))
        for name, model in setting.contacts.items()
    }
    reached = {name: _reached(one, NEARLY * held[name]) for name, one in walks.items()}
    again = [_reached(one.sensor, NEARLY * float(np.max(one.sensor.torque))) for one in runs]
    tops = [float(np.max(one.sensor.torque)) for one in runs]
    at = float(np.mean(again))
    shown = {FRICTION: runs[0].friction, SENSOR: runs[0].sensor} | walks
    del shown[RIG]
    marks = {FRICTION: math.nan, SENSOR: reached[RIG]} | reached
    return Reproduced(
        number=8,
        verdict="reproduced by calibration" if abs(at - SAID) < 0.15 * SAID else "refuted",
        found=[
            *(_breaks_away(name, walks[name], held[name], reached[name]) for name in walks),
            f"{RIG}, {len(runs)} runs: {spread(1e3 * np.array(tops))} mN·m, {percent(NEARLY, 1.0)} of it after "
            f"{spread(1e6 * np.array(again))} µm.",
            sensor_says(bench, sensor, "At this speed"),
        ],
        draw=lambda: break_away(traces(shown), marks, SAID, "translational", "rotational"),
        origin=setting.origin,
        numbers={"position_at_95_percent": reached, "break_away": held, "positions_of_runs": again,
                 "torques_of_runs": tops, "torque_sensor": sensor},
    )  # fmt: skip


def _reached(one: Walk, torque: float) -> float:
    """Return where a torque is first reached [m]; NaN where it is not."""
    beyond = np.flatnonzero(one.torque >= torque)
    return float(one.x[beyond[0]]) if beyond.size else math.nan


def _breaks_away(name: str, one: Walk, held: float, at: float) -> str:
    told = f"{number(1e3 * held, digits=3)} mN·m"
    if math.isnan(at):
        last = percent(float(one.torque[-1]) / held, 1.0)
        return f"{name} breaks away at {told}, of which it has {last} after {in_micrometres(float(one.x[-1]))}."
    return f"{name} breaks away at {told}, and has {percent(NEARLY, 1.0)} of it after {in_micrometres(at)}."
