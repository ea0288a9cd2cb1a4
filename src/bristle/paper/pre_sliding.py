"""Figures 1 and 8: the contact led along a path up to break-away."""

from __future__ import annotations

import math

import numpy as np

from bristle.certificates import holding_of
from bristle.core.errors import InputError
from bristle.core.typography import number
from bristle.paper.economy import repeated
from bristle.paper.reproduced import Reproduced, in_micrometres, percent, spread
from bristle.paper.returns import closure_text, comes_back, missing_at, must_return, traces, walks_of
from bristle.paper.setting import Setting
from bristle.paper.torque_bench import bench_of, led, sensor_numbers, sensor_says
from bristle.paper.walk import Walk

__all__ = ["figure_1", "figure_8"]

NEARLY = 0.95  # of the break-away torque: where an eye sees it
PUBLISHED = 7e-6  # where the paper sees it [m]
LUGRE, RIG = "LuGre", "virtual rig"
FRICTION, SENSOR = f"{RIG}, friction", f"{RIG}, torque sensor"


def figure_1(setting: Setting) -> Reproduced:
    """Return figure 1: from A over B, C and B again to D, LuGre beside a contact that closes its loops."""
    from bristle.figures import marked_path

    must_return(setting, ((0, 2),))
    walks = walks_of(setting, LUGRE, RIG)
    missing = {name: missing_at(path, (0, 2)) for name, path in walks.items()}
    sentences = [f"{name}: {comes_back(share, 'B')}." for name, share in missing.items()]
    return Reproduced(
        number=1,
        verdict="built in in part" if abs(missing[LUGRE]) > 5.0 * abs(missing[RIG]) else "refuted",
        found=sentences,
        draw=lambda: marked_path(
            traces(walks),
            {name: [0, *path.turns] for name, path in walks.items()},
            "ABCBD",
            {name: f"{name}: {closure_text(missing[name])}" for name in walks},
            "translational",
            "rotational",
        ),
        origin=setting.origin,
        numbers={"missing_at_return": missing},
    )


def figure_8(setting: Setting) -> Reproduced:
    """Return figure 8: where friction breaks away when the table is moved one way."""
    from bristle.figures import break_away

    if np.any(setting["path", "turns"] <= 0.0):
        raise InputError("must lead forward", path=f"{setting.source}: path.turns", allowed="> 0 m")
    walks, bench, rig = walks_of(setting, RIG), bench_of(setting), setting.contact(RIG)
    runs = [led(setting, contact, setting["path", "turns"], setting["path", "speed"]) for contact in repeated(setting, rig)]
    sensor = sensor_numbers([run.sensed for run in runs])
    walks[RIG] = runs[0].sensor
    # A limit that scatters may lie above the one that it starts with.
    break_away_torques = {
        name: max(setting.arm * holding_of(model).forward, float(np.max(walks[name].torque))) for name, model in setting.contacts.items()
    }
    reached = {name: _reached(path, NEARLY * break_away_torques[name]) for name, path in walks.items()}
    again = [_reached(run.sensor, NEARLY * float(np.max(run.sensor.torque))) for run in runs]
    tops = [float(np.max(run.sensor.torque)) for run in runs]
    at = float(np.mean(again))
    paths = {FRICTION: runs[0].friction, SENSOR: runs[0].sensor} | walks
    del paths[RIG]
    marks = {FRICTION: math.nan, SENSOR: reached[RIG]} | reached
    return Reproduced(
        number=8,
        verdict="calibrated" if abs(at - PUBLISHED) < 0.15 * PUBLISHED else "refuted",
        found=[
            *(_breaks_away(name, walks[name], break_away_torques[name], reached[name]) for name in walks),
            f"{RIG}, {len(runs)} runs: {spread(1e3 * np.array(tops))} mN·m, {percent(NEARLY, 1.0)} of it after "
            f"{spread(1e6 * np.array(again))} µm.",
            sensor_says(bench, sensor, "At this speed"),
        ],
        draw=lambda: break_away(traces(paths), marks, PUBLISHED, "translational", "rotational"),
        origin=setting.origin,
        numbers={
            "position_at_95_percent": reached,
            "break_away": break_away_torques,
            "positions_of_runs": again,
            "torques_of_runs": tops,
            "torque_sensor": sensor,
        },
    )


def _reached(path: Walk, torque: float) -> float:
    """Return where a torque is first reached [m]; NaN where it is not."""
    beyond = np.flatnonzero(path.torque >= torque)
    return float(path.x[beyond[0]]) if beyond.size else math.nan


def _breaks_away(name: str, path: Walk, break_away: float, at: float) -> str:
    torque = f"{number(1e3 * break_away, digits=3)} mN·m"
    if math.isnan(at):
        last = percent(float(path.torque[-1]) / break_away, 1.0)
        return f"{name} breaks away at {torque}, of which it has {last} after {in_micrometres(float(path.x[-1]))}."
    return f"{name} breaks away at {torque}, and has {percent(NEARLY, 1.0)} of it after {in_micrometres(at)}."
