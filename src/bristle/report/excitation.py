"""A planned motion and what it will identify, as tables and as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from bristle.core.typography import number, scale_of, with_unit
from bristle.core.variable import Kind, unit_of
from bristle.report.table import Table

if TYPE_CHECKING:
    from bristle.core.axis import Axis
    from bristle.excitation import Foresight, Frame, Plan

__all__ = ["excitation_summary", "experiment_table", "foresight_table"]

SHOWS = {
    "conditioning slide": "nothing: it wipes out what the contact remembers",
    "triangles": "pre-sliding stiffness and its shape",
    "decaying loop": "memory: loops inside loops",
    "break-away ramps": "break-away force, and whether it depends on the rate",
    "constant speeds": "Stribeck curve and viscous friction",
    "chirp": "damping of the bristles, at the resonance of the mass on them",
}


def experiment_table(plan: Plan, kind: Kind) -> Table:
    """Return the experiments of a plan: when, how far, how fast, and what for."""
    motion, rows = plan.motion, []
    for one in plan.experiments:
        part = slice(one.first, one.last)
        far = 0.5 * float(motion.position[part].max() - motion.position[part].min())
        fast = float(abs(motion.velocity[part]).max())
        rows.append((
            one.kind, with_unit(float(motion.time[one.first]), "s"),
            with_unit(float(motion.time[one.last - 1] - motion.time[one.first]), "s"),
            with_unit(far, unit_of("length", kind)), with_unit(fast, unit_of("length/time", kind)), SHOWS[one.kind],
        ))  # fmt: skip
    return Table("Motion to run", ("Experiment", "From", "Lasts", "Reach", "Top speed", "Shows"), rows)


def foresight_table(foresight: Foresight) -> Table:
    """Return what the motion will identify, and how well."""
    rows = []
    for one in foresight.fit.estimates:
        if one.status == "held":
            continue
        truth = _prior_value(foresight, one.name)
        scale = scale_of(one.unit, truth or one.value)
        half, told = one.interval_percent, "–" if truth is None else number(scale.factor * truth, digits=3)
        rows.append((
            one.name, one.description, told, scale.unit or "–",
            "–" if half is None else f"± {number(half, digits=2)}",
            "identified" if one.status == "identified" else "not identified",
        ))  # fmt: skip
    heads = ("Parameter", "Meaning", "Prior", "Unit", "95 % interval foreseen [%]", "Verdict")
    return Table(f"What {foresight.fit.name} would be known to", heads, rows)


def _prior_value(foresight: Foresight, name: str) -> float | None:
    values = {**foresight.prior.plant.values, **foresight.prior.friction.values}
    return values.get(name)


def excitation_summary(
    plan: Plan, frame: Frame, axis: Axis, foresight: Foresight | None, *, provenance: Mapping[str, str]
) -> dict[str, Any]:
    """Return a planned motion in numbers, in SI of the axis."""
    motion = plan.motion
    return {
        "name": axis.name,
        "kind": axis.kind,
        "duration": float(motion.time[-1]),
        "samples": int(motion.time.size),
        "sample_time": motion.sample_time,
        "range": [float(motion.position.min()), float(motion.position.max())],
        "top_speed": float(abs(motion.velocity).max()),
        "top_acceleration": float(abs(motion.acceleration).max()),
        "breakaway_distance": frame.breakaway,
        "experiments": [
            {"kind": one.kind, "from": float(motion.time[one.first]), "to": float(motion.time[one.last - 1])}
            for one in plan.experiments
        ],
        "foreseen": None if foresight is None else {
            "model": foresight.fit.name,
            "scatter": foresight.prior.scatter,
            "noise": foresight.prior.noise,
            "parameters": {
                one.name: {
                    "prior": _prior_value(foresight, one.name), "unit": one.unit, "status": one.status,
                    "interval_percent": one.interval_percent, "note": one.note,
                }
                for one in foresight.fit.estimates
            },
        },
        "provenance": provenance,
    }  # fmt: skip
