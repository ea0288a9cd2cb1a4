"""Figure 7: the mechanics of the rig, and the control scheme of its loop."""

from __future__ import annotations

import math

from bristle.core.typography import number, with_unit
from bristle.paper.reproduced import Reproduced, in_micrometres
from bristle.paper.setting import Setting
from bristle.paper.torque_bench import bench_of
from bristle.paper.tracking import Tracked

__all__ = ["figure_7"]


def figure_7(tracked: Tracked, setting: Setting) -> Reproduced:
    """Return figure 7: the rig and its control scheme, drawn from their experiments."""
    from bristle.figures import Mechanics, rig_layout

    variant = next(variant for variant in tracked.experiment.variants if variant.name == tracked.after)
    run, resolution = variant.run, float(variant.sensor.values["resolution"])
    law, fed = variant.controller.name.replace("_", " "), variant.feedforward.friction
    compensator = fed.name.replace("_", " ") if fed else "none"
    bench, lead = bench_of(setting), 2.0 * math.pi * setting.arm
    total, before = (with_unit(inertia, "kg*m^2") for inertia in (bench.J, bench.J_m))
    return Reproduced(
        number=7,
        verdict="shown",
        found=[
            f"A screw with a lead of {with_unit(lead, 'm')}. Of an inertia of {total} at the screw, which is "
            f"{number(bench.J / setting.arm**2, digits=3)} kg at the table, {before} is before the torque sensor.",
            f"A loop at {number(1e-3 / run.sample_time, digits=2)} kHz with {run.delay} sample of delay and an encoder "
            f"of {in_micrometres(resolution)}; control is {law}, the compensator {compensator}.",
        ],
        draw=lambda: rig_layout(Mechanics(lead, bench.J, bench.J_m, bench.cutoff, resolution), variant),
        origin=tracked.origin,
        numbers={
            "sample_time": run.sample_time,
            "delay": run.delay,
            "resolution": resolution,
            "lead": lead,
            "inertia": bench.J,
            "inertia_before_sensor": bench.J_m,
        },
    )
