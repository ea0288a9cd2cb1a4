"""A slot of a person's own, by no equation and on no channel of bristle, and the log of an axis that has it."""

import numpy as np

SLOT = '''
r"""Friction that falls off with the pressure of the oil, by no equation of bristle.

.. math:: F = e^{-a (b - b_0)} F_\\text{model}
"""
from typing import Annotated, NamedTuple

from bristle.core import Slot, Surrounding, Variable, kernel
from bristle.core.mathematics import exp


class Parameters(NamedTuple):
    a: Annotated[float, Variable("length^2/force", "fall over the pressure", nominal=1e-5, excitation="channel")] = 0.0
    b_0: Annotated[float, Variable("force/length^2", "pressure that friction is told at")] = 2e5


@kernel
def factor(pressure, p):
    return exp(-p.a * (pressure - p.b_0))


SLOT = Slot(
    name="oiled", description="friction that falls with the pressure of the oil",
    channel=Surrounding("pressure", Variable("force/length^2", "pressure of the oil", min=0.0), usual=2e5),
    Parameters=Parameters, factor=factor, example={"a": 3e-6},
)
'''
AXIS = """
schema = 1
kind = "translational"

[columns]
time = { column = "t", unit = "s" }
position = { column = "q", unit = "mm" }
effort = { column = "u", unit = "N" }
pressure = { column = "oil", unit = "bar" }
"""
TRUTH = {"F_C": 8.0, "F_v": 30.0, "a": 2.5e-6, "offset": 1.5}
DT = 1e-3


SEALS = {"F_C": 8.0, "F_v": 30.0, "k_P": 2e-6, "offset": 1.5}


def falling(pressure, v):
    return (
        np.exp(-TRUTH["a"] * (pressure - 2e5)) * (TRUTH["F_C"] * np.sign(v) + TRUTH["F_v"] * v)
        + TRUTH["offset"]
    )


def pressed(pressure, v):
    return (
        (1.0 + SEALS["k_P"] * pressure) * SEALS["F_C"] * np.sign(v)
        + SEALS["F_v"] * v
        + SEALS["offset"]
    )


def recorded(friction, count=12_000):
    """Position, effort and pressure of an axis of 12 kg, its friction in the plain words of numpy."""
    t = DT * np.arange(count)
    w, amplitude, phase = (
        2.0 * np.pi * np.array([0.5, 1.7, 3.1]),
        np.array([0.02, 0.008, 0.004]),
        np.array([0, 1, 2]),
    )
    angle = np.outer(t, w) + phase
    q, v, a = (
        np.sin(angle) @ amplitude,
        np.cos(angle) @ (amplitude * w),
        -np.sin(angle) @ (amplitude * w * w),
    )
    pressure = 2e5 + 1e5 * np.sin(0.9 * t)
    return (
        t,
        q,
        12.0 * a + friction(pressure, v) + np.random.default_rng(1).normal(0.0, 0.2, count),
        pressure,
    )


def write_bench(folder, friction=falling, count=12_000):
    """Write the slot, an axis and its log."""
    t, q, u, pressure = recorded(friction, count)
    table = np.column_stack([t, 1e3 * q, u, 1e-5 * pressure])
    np.savetxt(
        folder / "log.csv", table, delimiter=",", header="t,q,u,oil", comments="", fmt="%.9g"
    )
    (folder / "axis.toml").write_text(AXIS)
    (folder / "oiled.py").write_text(SLOT)
