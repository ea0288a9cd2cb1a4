"""What the files of a control law say of it, and the walk that its self-test makes, whatever the target."""

from typing import Any

import numpy as np

from bristle.controllers.feedforward import Shape
from bristle.core.variable import unit_of
from bristle.exports.described import Source, command_facts, parameter_table, plain, version
from bristle.exports.law import Inputs, Law, loads_of
from bristle.exports.printing import loops_of
from bristle.exports.subject import Walk, subject_of, walk_of, walk_over
from bristle.exports.tunable import TOLERANCE
from bristle.friction.level import rises_with_effort
from bristle.prediction.drive_units import command_units

WITHOUT_FRICTION = 1e-5  # distance that the self-test of a law without a compensator takes for its walk [m or rad]
PER_VELOCITY = 100.0
"""Acceleration of the self-test over its velocity [1/s]."""
INPUTS = {
    "position": ("desired position", "length"),
    "velocity": ("desired velocity", "length/time"),
    "acceleration": ("desired acceleration", "length/time^2"),
    "measured": ("position as the sensor reads it", "length"),
    "place_ahead": ("desired positions of the samples that follow, the next one first", "length"),
    "acceleration_ahead": ("desired accelerations of the samples that follow, the next one first", "length/time^2"),
}


def law_facts(law: Law, name: str, source: Source) -> dict[str, Any]:
    """Return what is said of a law."""
    variant = law.variant
    kind, friction = variant.controller.kind, variant.feedforward.friction
    inputs = []
    for fed in law.inputs:
        several = fed.endswith("_ahead")
        declared, unit = f"{fed}[{law.samples_ahead}]" if several else fed, unit_of(INPUTS[fed][1], kind)
        inputs.append({"name": fed, "declared": declared, "told": INPUTS[fed][0], "unit": unit, "several": several})
    limit = variant.run.effort_limit
    return (
        {"name": name, "version": version(), "title": plain(f"Control law of an axis: {variant.controller.name}")}
        | {"variant": plain(variant.name), "description": plain(variant.controller.component.description), "facts": source.lines}
        | {"along": variant.feedforward.along if friction else "", "friction": plain(friction.name) if friction else ""}
        | {"table": parameter_table(law.controller, source).rstrip(), "fed": _fed(law)}
        | {"fed_table": parameter_table(friction, source).rstrip() if friction else ""}
        | {"unit_force": unit_of("force", kind), "unit_x": unit_of("length", kind), "dt": repr(law.dt), "rate": f"{1.0 / law.dt:g}"}
        | {"ahead": law.samples_ahead, "delay": variant.run.delay, "limit": f"{limit:g}" if np.isfinite(limit) else "", "inputs": inputs}
        | {"drive": command_facts(command_units(variant.axis, kind), kind), "loops": loops_of(law.unit, law.memory_size)}
        | {"single": law.single, "tunable": law.tunable, "result": "effort", "allowed": f"{TOLERANCE:g}", "several_places": True}
    )


def law_walk(law: Law, steps: int) -> tuple[Walk, int, np.ndarray]:
    """Return the walk of the self-test of a law, how many positions of it are told, and the efforts along it."""
    ahead, friction = law.samples_ahead, law.variant.feedforward.friction
    walk = walk_over(WITHOUT_FRICTION, law.dt) if friction is None else walk_of(subject_of(friction), law.dt)
    x = walk.positions(steps + ahead + 1)
    v = np.diff(x) / law.dt
    a = PER_VELOCITY * v
    at, speed, change = x.tolist(), v.tolist(), a.tolist()
    samples = [
        Inputs(at[k], speed[k], change[k], at[max(k - 1, 0)], x[k + 1 : k + 1 + ahead], a[k + 1 : k + 1 + ahead]) for k in range(steps)
    ]
    return walk, x.size, law.efforts(samples)


def _fed(law: Law) -> list[str]:
    """Return what is fed forward, a line each."""
    feedforward, kind = law.variant.feedforward, law.variant.controller.kind
    fed, carried = loads_of(feedforward)
    lines = [f"inertia along the desired motion: {feedforward.mass:g} {unit_of('mass', kind)}"] if feedforward.mass else []
    if fed.place and feedforward.plant is not None:
        lines.append(f"what {feedforward.plant.name} takes by its place, along the desired motion")
    if feedforward.friction is not None:
        shape = [f", {name} {value:g}" for name, value in law.p.shape._asdict().items() if value != Shape._field_defaults[name]]
        lines.append(f"friction along the {feedforward.along} motion by {feedforward.friction.name}" + "".join(shape))
        if rises_with_effort(feedforward.friction):
            plant = None if carried is fed else feedforward.carries
            passing = "what is fed forward beside it" if plant is None else plant.name
            lines.append(f"its level rises with the effort that passes on along the desired motion: that of {passing}")
    return [plain(line) for line in lines] or ["nothing"]
