"""What a loop is told of the desired motion besides its position: velocity and inertia, each once."""

from __future__ import annotations

import math
from dataclasses import replace

from bristle.core.contracts import Model, Reference
from bristle.core.experiment import Variant
from bristle.loop_design.tuning import inertia_of

__all__ = ["feeds_inertia", "told_the_motion"]

ALIKE = 0.01  # relative difference of two masses that are the same one


def feeds_inertia(controller: Model, dt: float) -> bool:
    """Return whether a control law answers the acceleration of its reference by itself."""
    component, p = controller.component, controller.parameters
    efforts = []
    for acceleration in (1e-6, 0.0):
        rest = component.start(0.0, 0.0, 0.0, dt, p)
        efforts.append(component.step(rest, Reference(0.0, 0.0, acceleration, 0.0), 0.0, dt, p)[0])
    return efforts[0] != efforts[1]


def told_the_motion(variant: Variant) -> Variant:
    """Return the loop with velocity and inertia of the desired motion fed forward, where it was not already."""
    controller, feedforward = variant.controller, variant.feedforward
    if controller.values.get("k_ff", 1.0) != 1.0:
        controller = controller.with_values(k_ff=1.0)
    mass = 0.0 if feeds_inertia(controller, variant.run.sample_time) else inertia_of(variant)
    if not math.isclose(mass, feedforward.mass, rel_tol=ALIKE):
        feedforward = replace(feedforward, mass=mass)
    return replace(variant, controller=controller, feedforward=feedforward)
