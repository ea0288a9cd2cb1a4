"""Report of an arm: its bodies, base parameters with intervals, and the files for other programs."""

from typing import Any

from bristle.arm import Arm
from bristle.core import number
from bristle.report.page import Section
from bristle.report.table import Table, percent_text

UNITS = {"m": "kg", "mc": "kg·m", "I": "kg·m²", "J": "kg·m²"}


def arm_summary(arm: Arm) -> dict[str, Any]:
    """Return the dynamics of an arm in numbers, in SI."""
    dynamics = arm.dynamics
    rows = zip(arm.tables, dynamics.errors.tolist(), dynamics.bodies.tolist(), dynamics.rotors.tolist(), strict=True)
    return {
        "joints": {name: {"error": error, "body": body, "rotor": rotor} for name, error, body, rotor in rows},
        "base_parameters": {
            entry.name: {"value": entry.value, "half_width": entry.half_width, "sum_of": dict(entry.members)} for entry in dynamics.base
        },
    }


def joints_table(arm: Arm) -> Table:
    """Return the error of each joint with the bodies of the arm and any friction, its body and its rotor."""
    rows = [
        (name, percent_text(100.0 * error), number(body[0]), *(number(value, 1e-3) for value in body[1:4] / body[0]), number(rotor))
        for name, error, body, rotor in zip(arm.tables, arm.dynamics.errors, arm.dynamics.bodies, arm.dynamics.rotors, strict=True)
    ]
    heads = ("Joint", "Error without a friction model", "Mass [kg]", "Centre x [m]", "y [m]", "z [m]", "Rotor inertia [kg·m²]")
    return Table("The bodies", heads, rows)


def base_table(arm: Arm) -> Table:
    """Return the base parameters with their intervals and members."""
    rows = []
    for entry in arm.dynamics.base:
        unit = UNITS[entry.name.rpartition(".")[2].partition("_")[0]]
        members = " ".join(f"{'+' if factor > 0 else '−'} {number(abs(factor), digits=3)} {name}" for name, factor in entry.members)
        rows.append(
            (entry.name, number(entry.value, entry.half_width), number(entry.half_width, digits=2), unit, members.removeprefix("+ "))
        )
    return Table("The base parameters", ("Name", "Value", "Half-width (95 %)", "Unit", "Sum of"), rows)


def arm_sections(arm: Arm) -> list[Section]:
    """Return the sections of the report on an arm."""
    text = (
        "The efforts determine the base parameters, which are sums of the parameters of the bodies. The bodies below have these sums, "
        "positive masses, and otherwise the values of the robot file."
    )
    return [Section("arm", "The arm", [text, joints_table(arm), base_table(arm)], "Arm")]
