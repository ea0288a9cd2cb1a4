"""`prepare`: what an experiment file identifies, from its logs or by exciting its rig, before it is simulated."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from bristle.core import SIZE_LIMIT, Axis, Experiment, InputError, Progress, Readable, Status, Variant, digest, located, size_of
from bristle.files import FITTED_TO, Planned, Sources, planned_in, read_toml, results_folder

if TYPE_CHECKING:
    from bristle.identification import Fit
    from bristle.logs import Log

SIGNALS = ("time", "position", "effort", "reference")


@dataclass(frozen=True)
class Prepared:
    """A model that an experiment identifies, ready to be used.

    Parameters
    ----------
    name : str
        What its tables call it.
    folder : Path
        Where its results lie, a report among them.
    best : Fit or None
        What was fitted; None where it was there already, from the same log or rig.
    """

    name: str
    folder: Path
    best: Fit | None


def prepare(
    experiment: Readable, *, allow_code: bool = False, size_limit: int | str = SIZE_LIMIT, progress: Progress | None = None
) -> tuple[Prepared, ...]:
    """Identify what an experiment file has under ``[identify.NAME]``, as far as it is not there already.

    A model is kept until something changes that it depends on: a log or the axis file, or where the rig itself is
    excited any value of that loop; the options; or the version of bristle.

    Parameters
    ----------
    experiment : path-like
        An experiment file.
    allow_code : bool
        Whether components of a person's own, in files that it names, may run without having been allowed before.
    size_limit : int or str
        Largest log that it names [byte], or text such as ``"2 GB"``.
    progress : callable, optional
        Called with the share of the work done and what is being done.

    Returns
    -------
    tuple of Prepared
        In the order of the file; empty where it identifies nothing.

    Raises
    ------
    InputError
        With file, key, value and what is allowed there; if a log or the rig does not serve, or the folder
        ``<file>_identified`` cannot be written.
    """
    data, source, _ = read_toml(experiment, path="experiment", what="an experiment file")
    sources = Sources(source.parent, allow_code, size_of(size_limit))
    with located(source):
        planned = planned_in(data, source, sources)
    ready = []
    for number, plan in enumerate(planned.values()):
        best = None
        if not plan.is_current:

            def part(share: float, words: str, done: int = number) -> None:
                if progress is not None:
                    progress((done + share) / len(planned), words)

            with located(f"{source}: {plan.path}"):
                best = _identified(plan, source, size_of(size_limit), part)
        ready.append(Prepared(plan.name, plan.folder, best))
    return tuple(ready)


def _identified(plan: Planned, source: Path, size_limit: int, progress: Progress) -> Fit:
    from bristle.files import read_axis, read_log
    from bristle.report.identified import identify

    plan.folder.parent.mkdir(exist_ok=True)
    with results_folder(plan.folder, force=True) as folder:
        axis = None if plan.axis is None else read_axis(plan.axis)
        if plan.excited:
            logs, axis = _excited(plan.excited, axis)
        else:
            logs = [read_log(log, axis, size_limit=size_limit) for log in plan.logs]
        identification = identify(logs, axis=axis, progress=progress, **{"draws": 0, **plan.options}).finished
        outcome = identification.outcome_with(command=f"[{plan.path}] of {source.name}")
        if plan.excited:
            facts = {"identified from a run of": f"{source.name}: {plan.excited.name}", FITTED_TO: digest(plan.excited.friction)}
            outcome = replace(outcome, provenance={**outcome.provenance, **facts})
        outcome.write(folder)
        folder.write(*plan.note)
    return identification.best


def _excited(variant: Variant, axis: Axis | None) -> tuple[list[Log], Axis]:
    """Return what the drive of a loop would record in a run of it, and what is known of the axis."""
    from bristle.logs import Log
    from bristle.simulation import simulate

    kind = variant.plant.kind
    outcome = simulate(Experiment(variant.name, kind, (variant,))).variants[variant.name]
    if outcome.status is not Status.OK:
        raise InputError("does not run to its end", path=f"compare.{variant.name}", value=outcome.status.sentence, mend="Mend its loop")
    signals = (outcome.time, outcome.measured, outcome.command, *(() if outcome.is_open else (outcome.reference,)))
    axis = axis or Axis(kind=kind, resolution=variant.sensor.values.get("resolution"))
    return [Log.from_columns(dict(zip(SIGNALS, signals, strict=False)), axis=axis)], axis
