"""An axis with known friction in a loop, and its log by the engine of bristle."""

import numpy as np

from bristle import controllers, friction, sensors
from bristle.core import Axis
from bristle.engine import run_closed_loop
from bristle.logs.log import Channel, Log
from bristle.models.plants import inertia

DT = 1e-3
PLANT = inertia(M=12.0)
TRUTH = friction.find("stribeck+asymmetry")(
    F_C_pos=8.0,
    F_C_neg=6.0,
    F_S_pos=10.0,
    F_S_neg=7.5,
    v_S=5e-3,
    F_v_pos=30.0,
    F_v_neg=35.0,
    offset=1.0,
)
AXIS = Axis(controller=controllers.cascade(k_p=80.0, k_v=3000.0), resolution=1e-7)


def recorded(
    slow=3.1,
    quick=10.7,
    *,
    count=6000,
    noise=0.0,
    injected=None,
    start=0,
    resolution=AXIS.resolution,
):
    """Return the log of the axis on a sum of two sines [rad/s], from a sample on."""
    t = DT * np.arange(count)
    desired = np.zeros((4, t.size))
    desired[0] = 0.02 * (np.sin(slow * t) + 0.4 * np.sin(quick * t)) * np.minimum(t, 1.0)
    trace = run_closed_loop(
        PLANT,
        TRUTH,
        AXIS.controller,
        sensors.encoder(resolution=resolution),
        desired,
        DT,
        steps=8,
        injected=injected,
    )
    effort = trace.command + noise * np.random.default_rng(3).normal(size=t.size)
    cut = slice(start, None)
    return Log(
        time=Channel(t[cut], "s", "t"),
        position=Channel(trace.measured[cut], "m", "q"),
        effort=Channel(effort[cut], "N", "u"),
        reference=Channel(desired[0][cut], "m", "r"),
        injected=() if injected is None else (Channel(injected[cut], "N", "pulses"),),
        sample_time=DT,
        segments=(slice(0, t.size - start),),
    )
