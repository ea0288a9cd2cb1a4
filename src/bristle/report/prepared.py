"""`prepare`: identify the models of an experiment file from its logs or its simulated rig, before the simulation."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from bristle.core import (
    SIZE_LIMIT,
    Axis,
    Experiment,
    InputError,
    Progress,
    Readable,
    Status,
    Variant,
    digest,
    guarded,
    located,
    size_of,
)
from bristle.files import FITTED_TO, Planned, Sources, planned_in, read_toml, results_folder

if TYPE_CHECKING:
    from bristle.identification import Fit
    from bristle.logs import Log

SIGNALS = ("time", "position", "effort", "reference")


@dataclass(frozen=True)
class Prepared:
    """A model identified for an experiment.

    Parameters
    ----------
    name : str
        Name in the experiment file.
    folder : Path
        Folder of its results, with a report.
    best : Fit or None
        The fit; None if the folder already had results of the same log or rig.
    """

    name: str
    folder: Path
    best: Fit | None


@guarded()
def prepare(
    experiment: Readable,
    *,
    allow_code: bool = False,
    size_limit: int | str = SIZE_LIMIT,
    progress: Progress | None = None,
) -> tuple[Prepared, ...]:
    """Identify the models under ``[identify.NAME]`` in an experiment file, unless their results are present.

    bristle identifies a model again if a log, the axis file, the options or the version of bristle change. It also
    identifies a model of the simulated rig again if any value of the loop of the rig changes.

    Parameters
    ----------
    experiment : path-like
        An experiment file.
    allow_code : bool
        Whether user code in files that it names may run without earlier permission.
    size_limit : int or str
        Largest size of a log [byte], or text such as ``"2 GB"``.
    progress : callable, optional
        Called with the completed share of the work and the current task.

    Returns
    -------
    tuple of Prepared
        The models in the order of the file; empty if the file has no models to identify.

    Raises
    ------
    InputError
        With file, key, value and allowed values, if a log or the rig is unsuitable, or the folder
        ``<file>_identified`` is not writable.
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
    from bristle.files import logs_and_axes, read_axis
    from bristle.report.identified import identify

    plan.folder.parent.mkdir(exist_ok=True)
    with results_folder(plan.folder, force=True) as folder:
        axis = None if plan.axis is None else read_axis(plan.axis)
        if plan.excited:
            logs, axis = _excited(plan.excited, axis)
        else:
            logs = [log for log, _ in logs_and_axes(list(plan.logs), axis, size_limit=size_limit)]
        identification = identify(
            logs, axis=axis, progress=progress, **{"draws": 0, **plan.options}
        ).finished
        outcome = identification.outcome_with(command=f"[{plan.path}] of {source.name}")
        if plan.excited:
            facts = {
                "identified from a run of": f"{source.name}: {plan.excited.name}",
                FITTED_TO: digest(plan.excited.friction),
            }
            outcome = replace(outcome, provenance={**outcome.provenance, **facts})
        outcome.write(folder)
        folder.write(*plan.note)
    return identification.best


def _excited(variant: Variant, axis: Axis | None) -> tuple[list[Log], Axis]:
    """Return the log that the drive of a loop would record, and its axis."""
    from bristle.logs import Log
    from bristle.simulation import simulate

    kind = variant.plant.kind
    outcome = simulate(Experiment(variant.name, kind, (variant,))).variants[variant.name]
    if outcome.status is not Status.OK:
        raise InputError(
            "the simulation stopped early",
            path=f"compare.{variant.name}",
            value=outcome.status.sentence,
            mend="Correct this loop",
        )
    signals = (
        outcome.time,
        outcome.measured,
        outcome.command,
        *(() if outcome.is_open else (outcome.reference,)),
    )
    axis = axis or Axis(kind=kind, resolution=variant.sensor.values.get("resolution"))
    return [Log.from_columns(dict(zip(SIGNALS, signals, strict=False)), axis=axis)], axis
