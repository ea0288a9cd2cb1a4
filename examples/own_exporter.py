"""A target of your own: the friction table of an invented drive, as TOML in the units of the log.

``bristle export results --to own_exporter.py --axis axis.toml --out acme`` writes the table. The drive accepts
at most 16 entries for each direction, in order of speed, and no friction that depends on the position.
"""

import tomllib

import numpy as np

from bristle.core import InputError
from bristle.exports import Product, Target
from bristle.exports.drive import losses, side_of
from bristle.models.friction.slots import variations_of
from bristle.prediction.drive_units import log_units

MOST = 16


def write(request):
    if variations_of(request.model.component):
        raise InputError(
            "the drive has one table for all positions",
            path="acme",
            value=request.model.name,
            mend="Identify the model without +position, +periodic, +load and +temperature",
        )
    velocity, effort = log_units(request.axis, request.model.kind)
    points = min(request.points, MOST)
    sides = {
        name: side_of(request.model, way, request.speed, points)
        for name, way in (("forward", 1), ("backward", -1))
    }
    lines = [f"# {line}" for line in request.source.lines]
    lines += [f'velocity_unit = "{velocity.name}"', f'effort_unit = "{effort.name}"']
    for name, side in sides.items():
        rows = [
            f"  [{velocity.of(v):.6g}, {effort.of(force):.6g}],"
            for v, force in side.entries.tolist()
        ]
        lines += [f"{name} = [", *rows, "]"]
    notes = losses(request.model, sides["forward"], sides["backward"], effort, symmetric=False)
    if request.points > MOST:
        notes = (f"the drive takes {MOST} entries for each direction, not {request.points}", *notes)
    return Product({f"{request.name}.toml": "\n".join([*lines, ""])}, notes)


def reads(files, request):
    """Return the force that the drive computes from its file. bristle simulates the axis with it, and states the effect."""
    velocity, effort = log_units(request.axis, request.model.kind)
    table = tomllib.loads(files[f"{request.name}.toml"])
    speeds, forces = zip(
        *(np.transpose(table[name]) for name in ("forward", "backward")), strict=True
    )

    def drive(x, dt):
        v = np.diff(x, prepend=x[:1]) / dt / velocity.si
        forward, backward = (
            effort.si * np.interp(np.abs(v), speeds[side], forces[side]) for side in (0, 1)
        )
        return np.where(v > 0.0, forward, np.where(v < 0.0, -backward, 0.0))

    return drive


TARGET = Target(
    name="acme",
    description="the friction table of an ACME servo drive, TOML",
    write=write,
    reads=reads,
    pushes=True,
)
