"""How far, how fast and how hard a contact is moved on the page, so that it shows what its model does."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.exports.subject import Subject, presliding_distance
from bristle.plants import pulled_inertia

__all__ = ["Scales", "pulled_by", "scales_of"]

FAST = 1000.0  # distances of pre-sliding in a second, where no Stribeck velocity tells what is fast
PULL = 0.25  # velocity of the far end of the spring over that at which friction falls
PERIODS = 30.0  # natural periods that a mass on the spring sticks for
DROP = 0.3  # share of friction that the spring gains meanwhile
MASS = 1.0  # [kg or kg*m^2]


class Scales(NamedTuple):
    """Distance of pre-sliding [m or rad], velocity at which friction falls [m/s or rad/s], and force [N or N*m]."""

    reach: float
    speed: float
    force: float


def scales_of(subject: Subject) -> Scales:
    """Return the scales of a friction model."""
    model = subject.model
    reach = presliding_distance(subject)
    variables = model.component.variables
    forces = [
        float(np.max(np.abs(value)))
        for name, value in model.values.items()
        if variables[name].quantity == "force" and not isinstance(value, str)
    ]
    speed = float(model.values.get("v_S", FAST * reach))
    viscous = float(model.values.get("F_v", 0.0)) * 10.0 * speed
    return Scales(reach, speed, max([*forces, viscous], default=0.0) or 1.0)


def pulled_by(scales: Scales, model: Model, mass: float | None = None) -> Model:
    """Return a mass on a spring that this friction lets stick and slip, its far end moving slowly."""
    m, v_e = mass or MASS, float(f"{PULL * scales.speed:.2g}")
    # It sticks for 2 * drop / (k * v_e), which is so many times 2 * pi * sqrt(m / k).
    root = DROP * scales.force / (v_e * PERIODS * math.pi * math.sqrt(m))
    return pulled_inertia(M=m, k=float(f"{root**2:.2g}"), v_e=v_e, kind=model.kind)
