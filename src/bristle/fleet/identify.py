"""`identify_each`: many logs, each identified by itself, into one store that is gone on with and may grow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from os import PathLike
from pathlib import Path
from typing import Any

from bristle.core.content import SIZE_LIMIT, Content
from bristle.core.errors import InputError
from bristle.files.arguments import AXIS, axes_for
from bristle.files.user_model import origins_of_code
from bristle.fleet.columns import described_columns
from bristle.fleet.identifier import Identifier
from bristle.fleet.listing import listed_logs
from bristle.fleet.plan import Fleet
from bristle.fleet.store import FleetStore
from bristle.identification.request import models_of
from bristle.logs.readers import read_log
from bristle.study.run import Progress, Ran, run_within
from bristle.study.store import opened

__all__ = ["fleet_of", "identify_each", "identify_within"]


def fleet_of(
    logs: Sequence[str | Path],
    *,
    model: Any = "coulomb_viscous",
    axes: Sequence[Any] = (),
    name: str = "fleet",
    options: Mapping[str, Any] | None = None,
    readers: Sequence[Content] = (),
    size_limit: int = SIZE_LIMIT,
) -> Fleet:
    """Return many logs as a fleet: listed, looked up, nothing identified yet."""
    listed = listed_logs(logs, size_limit=size_limit)
    chosen, *others = models_of(model)
    if others:
        raise InputError(
            "takes one model: parameters of different ones do not compare",
            path="--each",
            value=", ".join(component.name for component in (chosen, *others)),
            mend="Compare models on one log first, then name the best one",
        )
    described: list[Any] = [AXIS(axis, "axis", None) for axis in axes] or [None]
    axes_for(described, len(listed))
    kinds = {axis.kind for axis in described if axis is not None} or {_kind_of(listed[0].place, size_limit)}
    plants = {(axis.plant, axis.gravity, axis.cogging, axis.regressors) for axis in described if axis is not None}
    if len(kinds) > 1 or len(plants) > 1:
        raise InputError("describe axes of different kinds", path="--axis", mend="Make a fleet of each kind")
    own = len(described) > 1
    numbered = [replace(log, axis=number if own else 0) for number, log in enumerate(listed)]
    fleet = Fleet(name, tuple(numbered), tuple(described), kinds.pop(), chosen, dict(options or {}), tuple(readers), size_limit, {})
    return replace(fleet, described=_described(fleet))


def _kind_of(place: str, size_limit: int) -> Any:
    """Return the kind of axis that a log itself tells; the usual one where it cannot be read."""
    try:
        return read_log(place, size_limit=size_limit).kind
    except InputError:
        return "translational"


def _described(fleet: Fleet) -> dict[str, Any]:
    """Return what tells this fleet from another: the model, how it is fitted, the axis, and what computes it."""
    from bristle.files.summary import plain

    texts = {axis.text or repr(axis).encode() for axis in fleet.axes if axis is not None}
    of_axes = sorted(Content(Path("axis"), text).checksum for text in texts)
    code = {origin.name: origin.checksum for origin in origins_of_code([fleet.model])}
    return {
        "fleet": {"model": fleet.model.name} | plain(fleet.options),
        "axes": of_axes,
        "code": code,
        "readers": [content.checksum for content in fleet.readers],
        "columns": sorted(described_columns(fleet)),
        "bristle": version("bristle"),
    }


def identify_each(
    logs: Sequence[str | Path],
    folder: str | PathLike[str],
    *,
    model: Any = "coulomb_viscous",
    axis: Any = None,
    workers: int | None = None,
    progress: Progress | None = None,
    **options: Any,
) -> Ran:
    """Identify each of many logs by itself, with one model, and keep a row of each in a folder.

    Parameters
    ----------
    logs : sequence of path-like
        Files, ``FILE::TABLE`` with ``*`` for several tables of one, folders with all that is in them and below.
    folder : path-like
        A new folder, or that of the same fleet: what is missing is done, and logs that are new are added.
    model : str or FrictionModel
        The one model that is fitted to all of them.
    axis : Axis or path-like, or list of either, optional
        One for all logs, or one for each.
    workers : int, optional
        Processes; as many as there are cores where not given.
    progress : callable, optional
        Called with the share done, and how long the rest takes.
    **options
        Arguments of `bristle.identify`.

    Returns
    -------
    Ran
        How much was there, and what is missing. `bristle.read_study` reads the rows.

    Raises
    ------
    InputError
        If a log is not there, the folder holds something else, or the disk is full. A log that cannot be read or
        fitted is a row with its reason.
    """
    axes = list(axis) if isinstance(axis, (list, tuple)) else [axis] if axis is not None else []
    fleet = fleet_of(logs, model=model, axes=axes, name=Path(folder).name, options=options)
    with opened(Path(folder), fleet, {}, FleetStore) as store:
        return identify_within(store, workers=workers, progress=progress)


def identify_within(store: FleetStore, *, workers: int | None = None, progress: Progress | None = None) -> Ran:
    """Identify what is missing of a fleet in its folder, which this process has; as `identify_each`."""
    return run_within(store, workers=workers, progress=progress, simulator=Identifier)
