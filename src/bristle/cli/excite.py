"""``bristle excite``: the motion to run on an axis, and what its log will identify."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bristle.cli.options import Force, Json, Out
from bristle.cli.terminal import complain, progress, say, show_table

if TYPE_CHECKING:
    from bristle.core import Axis
    from bristle.excitation import Frame, Plan
    from bristle.excitation.foresight import Prior

__all__ = ["EXAMPLE", "excite"]

EXAMPLE = """Example:
  bristle excite axis.toml --duration "60 s" --out excitation"""


def excite(
    context: typer.Context,
    axis: Annotated[Path, typer.Argument(metavar="AXIS.toml", help="The axis, with its limits.")],
    out: Out = None,
    duration: Annotated[str, typer.Option("--duration", metavar="TIME", help="Of the motion.")] = "60 s",
    prior: Annotated[
        Path | None, typer.Option("--prior", metavar="MODEL.toml", help="What is thought of the axis beforehand.")
    ] = None,
    model: Annotated[
        str | None, typer.Option("--model", metavar="NAME", help="What is to be identified; that of the prior.")
    ] = None,
    draws: Annotated[
        int, typer.Option("--draws", metavar="COUNT", help="Simulated logs for what is foreseen; 0 for none.")
    ] = 60,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Plan a motion that identifies friction, and foresee how well.

    Conditioning slide, triangles, a decaying loop, break-away ramps, constant speeds and a chirp, within the limits of
    the axis. Its log is simulated with a prior model and identified.

    Writes motion.csv (time, position, velocity, acceleration, in SI) and summary.json into DIR.
    """
    from bristle.core.units import quantity
    from bristle.core.variable import Variable
    from bristle.excitation import foreseen, frame_of, planned
    from bristle.files.axis import read_axis
    from bristle.files.motion import write_motion
    from bristle.files.provenance import provenance
    from bristle.files.results import SUMMARY, results_folder
    from bristle.files.summary import as_json as json_text
    from bristle.report.excitation import excitation_summary, experiment_table, foresight_table

    with results_folder(out, force=force) if out else nullcontext() as folder, progress("planning") as report:
        described = read_axis(axis)
        time = quantity(duration, Variable("time", "duration"), path="--duration")
        known, distance = _known(prior)
        frame = frame_of(described, distance)
        plan = planned(frame, time)
        known = known or _guess(described, frame)
        foresight = (
            foreseen(plan.motion, described, known, model=model, draws=draws, progress=report) if draws else None
        )
        source = provenance(context.obj, axis=axis, **({"prior": prior} if prior else {}))
        summary = excitation_summary(plan, frame, described, foresight, provenance=source)
        if folder:
            write_motion(folder / "motion.csv", plan.motion, described.kind)
            (folder / SUMMARY).write_text(json_text(summary), encoding="utf-8")
    if as_json:
        sys.stdout.write(json_text(summary))
    else:
        show_table(experiment_table(plan, described.kind))
        if foresight:
            show_table(foresight_table(foresight))
        for line in _sentences(plan, frame, described, guessed=prior is None):
            say(line)
    if out:
        complain(f"wrote {out}; run {out / 'motion.csv'} on the axis and record position and effort")


def _known(prior: Path | None) -> tuple[Prior | None, float | None]:
    """Return the prior of a model file, and the displacement over which its friction builds up [m or rad]."""
    if prior is None:
        return None, None
    from bristle.core import InputError
    from bristle.engine.motion import presliding_distance
    from bristle.excitation.foresight import NOISE, SCATTER, Prior
    from bristle.files.model import read_model

    plant, friction, info = read_model(prior)
    if plant is None or plant.name != "inertia":
        raise InputError("must be an inertia", path=f"{prior}: plant", mend='Write [plant], model = "inertia" and M')
    half = presliding_distance(friction)
    bands = info["bands"] or {}
    known = Prior(plant, friction, bands.get("scatter") or SCATTER, NOISE)
    return known, 4.0 * half if half < float("inf") else None


def _guess(axis: Axis, frame: Frame) -> Prior:
    from bristle.excitation import prior_of

    return prior_of(axis, frame)


def _sentences(plan: Plan, frame: Frame, axis: Axis, *, guessed: bool) -> list[Any]:
    from bristle.core.typography import with_unit
    from bristle.core.variable import unit_of

    length = unit_of("length", axis.kind)
    span = " to ".join(with_unit(float(one), length) for one in (min(plan.motion.position), max(plan.motion.position)))
    found = [
        f"{with_unit(float(plan.motion.time[-1]), 's')} of motion from {span}, at rest at both ends.",
        f"Friction is taken to build up over {with_unit(frame.breakaway, length)}.",
    ]
    if guessed:
        found.append(
            "What is foreseen rests on a guess at the axis. With a first log, identify a model and give it by --prior."
        )
    return found
