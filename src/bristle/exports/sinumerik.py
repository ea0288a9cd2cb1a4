r"""Start values of the friction compensation of a SINUMERIK 840D sl or 828D, for tuning with the circularity test.

The control adds a pulse to the velocity setpoint at each reversal. Its documentation gives names, units and a tuning
procedure, but no values for an axis: bristle computes them from the identified friction and the gains of the velocity
loop. A pulse :math:`\Delta v\,e^{-t/T}` through a loop :math:`k_v (1 + 1/(T_n s))` commands the effort
:math:`k_v \Delta v` at once, and keeps it if :math:`T = T_n`. Friction changes by :math:`F_+ + F_-`, hence
:math:`\Delta v = (F_+ + F_-)/k_v`.

Two settings are left to the machine, because they do not follow from friction and loop. The characteristic over the
acceleration (sections 4.6.4.1 and 4.6.4.3 of the manual) comes from circles of several radii and feeds, if a constant
value is not good enough. The share for short blocks (section 4.6.5) is found by trial.

References
----------
.. [1] Siemens, "SINUMERIK 840D sl / 828D Extended Functions", Function Manual 03/2013, 6FC5397-1BP40-3BA1, K3,
   section 4.6: friction compensation.
.. [2] Siemens, "SINUMERIK 840C (IA)", 6FC5197-AA50, section 9.5.3.1: first amplitude and time constant.
.. [3] Siemens, "CNC Part 1 (NCK, PLC, drive)", Commissioning Manual 11/2006, 6FC5397-2AP10-2BA0, table 10-2: units of
   machine data.
"""

import math
from collections.abc import Mapping

import numpy as np

from bristle.core.errors import InputError
from bristle.exports.described import Request
from bristle.exports.drive import behind_comments, curve_of, last_direction, memory_lost
from bristle.exports.effect import Drive
from bristle.exports.loops import loop_for
from bristle.exports.targets import Product
from bristle.prediction.drive_units import table_units

CONTROLLER = "cascade"
UNIT = {"translational": ("mm/min", 1e-3 / 60.0), "rotational": ("rev/min", 2.0 * math.pi / 60.0)}
FUNCTION_MANUAL = "Function Manual Extended Functions, K3 section 4.6, 03/2013, 6FC5397-1BP40-3BA1"
UNITS_MANUAL = "Commissioning Manual CNC Part 1, table 10-2, 11/2006, 6FC5397-2AP10-2BA0"
START_MANUAL = "SINUMERIK 840C (IA), section 9.5.3.1, 6FC5197-AA50"


def write(request: Request) -> Product:
    """Return the machine data, one per line, with meanings and sources as comments."""
    axis = request.axis
    model = request.model
    forward, backward = [curve_of(model, way, request.speed)[0] for way in (1.0, -1.0)]
    controller = None
    if axis is not None:
        controller = axis.controller
    if controller is None or controller.name != CONTROLLER or not controller.values["k_v"]:
        raise InputError(
            "needs the gain of the velocity loop, because the compensation is a pulse of the velocity setpoint",
            path="sinumerik",
            value=None if controller is None else controller.name,
            allowed=f"a {CONTROLLER} with k_v",
            mend=f'Write model = "{CONTROLLER}", k_p, k_v and, if the loop has an integral, T_n under [controller] of the axis file',
        )
    gains = controller.values
    unit, si = UNIT[model.kind]
    # The pulse of velocity [m/s or rad/s]; its time constant [s], if the loop has an integral.
    pulse = float(forward[0, 1] + backward[0, 1]) / gains["k_v"]
    effort = table_units(axis, model.kind).efforts[0]
    notes = (
        "start values: tune them with the circularity test",
        *memory_lost(model, forward, backward, effort),
    )
    lasts = None
    said_of_time = (
        "MD32540, the time constant of the pulse, is not written: the velocity loop has no integral"
    )
    if gains["k_i"]:
        lasts = gains["k_v"] / gains["k_i"]
        said_of_time = "MD32540 is the integral time of the velocity loop: with this time constant the pulse commands a step of effort"
    head = [
        f"Friction compensation of {model.name}: SINUMERIK 840D sl, 828D. START VALUES: tune them with the circularity test.",
        *request.source.lines,
        *notes,
        f"Machine data: {FUNCTION_MANUAL}.",
        f"Units: {UNITS_MANUAL}.",
        "Constant compensation value, without adaptation to the acceleration. MD32520 is the pulse of the velocity "
        "setpoint that commands the change of friction at a reversal at once, through the gain of the velocity loop.",
        f"Begin with a part of MD32520 ({START_MANUAL}: begin with a relatively small amplitude), run a circle, and change "
        "MD32520 in small steps until the quadrant transitions do not show.",
        f"{said_of_time} ({START_MANUAL}: begin with a few cycles of the position controller).",
        "bristle does not write MD32530 and MD32550 to MD32570, the adaptation: find them with circles at several accelerations "
        "(section 4.6.4.3). It does not write MD32580, the share for short blocks: find this share by trial (section 4.6.5).",
    ]
    rows = [
        ("32490", "FRICT_COMP_MODE", "1", ""),
        ("32500", "FRICT_COMP_ENABLE", "1", ""),
        ("32510", "FRICT_COMP_ADAPT_ENABLE", "0", ""),
        ("32520", "FRICT_COMP_CONST_MAX", f"{pulse / si:.6g}", unit),
    ]
    if lasts is not None:
        rows += [("32540", "FRICT_COMP_TIME", f"{lasts:.6g}", "s")]
    lines = [
        f"MD{number} ${f'MA_{name}':<28}{value:<14}{unit}".rstrip()
        for number, name, value, unit in rows
    ]
    return Product({f"{request.name}.txt": behind_comments(head, *lines, mark=";")}, notes)


def reads(files: Mapping[str, str | bytes], request: Request) -> Drive | None:
    """Return the effort that the pulses command through the velocity loop after reversals; None without loop or time constant."""
    axis = request.axis
    kind = request.model.kind
    if axis is None or loop_for(request) is None:
        return None
    lines = [
        line.split()
        for line in str(files[f"{request.name}.txt"]).splitlines()
        if not line.startswith(";")
    ]
    values = {name.removeprefix("$MA_"): float(value) for _, name, value, *_ in lines if _}
    if "FRICT_COMP_TIME" not in values or axis.controller is None:
        return None
    pulse = values["FRICT_COMP_CONST_MAX"] * UNIT[kind][1]
    lasts = values["FRICT_COMP_TIME"]
    k_v, k_i = (axis.controller.values[name] for name in ("k_v", "k_i"))

    def drive(x: np.ndarray, dt: float) -> np.ndarray:
        way = last_direction(np.diff(x, prepend=x[:1]) / dt)
        time = dt * np.arange(x.size)
        force = np.zeros(x.size)
        for turn in np.flatnonzero(way[1:] * way[:-1] < 0.0) + 1:
            decay = np.exp(-(time[turn:] - time[turn]) / lasts)
            force[turn:] += way[turn] * pulse * (k_v * decay + k_i * lasts * (1.0 - decay))
        return force

    return drive
