"""`identify_each`: identifies each of many logs separately and stores the results in a folder that may grow."""

import json
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from importlib.metadata import version
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from bristle.apps.study.block import RAISED, REASON, REFUSED
from bristle.apps.study.fleet.plan import Fleet
from bristle.apps.study.plan import Block
from bristle.apps.study.run import Ran, run_within
from bristle.apps.study.store import (
    OK,
    RUNS,
    SCHEMA,
    STUDY,
    Store,
    opened,
    refuse_another,
    study_in,
)
from bristle.core import (
    SIZE_LIMIT,
    BristleError,
    Content,
    InputError,
    Progress,
    error_text,
    guarded,
)
from bristle.files import (
    AXIS,
    as_json,
    axes_for,
    load_reader_file,
    origins_of_code,
    plain,
    provenance,
    write_model,
)
from bristle.identification import (
    Estimate,
    Identification,
    Settings,
    identify,
    models_of,
    refuse_options,
)
from bristle.logs import LogFile, listed_logs, read_log, reading


class FleetStore(Store):
    """The folder of a fleet: the folder of a study, with a list of logs that may grow."""

    study: Fleet
    kind: ClassVar[str] = "fleet"

    def begin(self, provenance: Mapping[str, str]) -> None:
        """Append the logs of this command to those in the folder, each once; refuse another fleet."""
        past = None
        if self.grown.is_whole(STUDY):
            past = study_in(self.folder)
            refuse_another(past["described"], plain(self.study.described), self.folder)
            self.study = self.study.following(past["logs"])
            provenance = past["provenance"]
        text = as_json(self._content(provenance))
        if past != json.loads(text):
            self.grown.write(STUDY, text)
        self.grown.make(RUNS)

    def blocks_present(self) -> set[int]:
        """Return the logs that need no work: those with a row, and those that this command does not name."""
        return super().blocks_present() | {
            number for number, log in enumerate(self.study.logs) if not log.place
        }

    def _content(self, provenance: Mapping[str, str]) -> dict[str, Any]:
        fleet = self.study
        return {
            "schema": SCHEMA,
            "name": fleet.name,
            "kind": fleet.kind,
            "runs": fleet.count,
            "block": 1,
            "draws": fleet.count,
            "grid": {},
            "model": fleet.model.name,
            "metrics": list(fleet.parameters),
            "columns": fleet.columns,
            "logs": [
                {"folder": log.folder, "log": log.name, "sha256": log.checksum, "time": log.time}
                for log in fleet.logs
            ],
            "described": fleet.described,
            "provenance": provenance,
        }

    def _probe(self) -> Mapping[str, np.ndarray]:
        return {}


class Identifier:
    """Identification of the logs of a fleet in this process; `level_of` judges each, and `models` names a folder for their models."""

    def __init__(
        self,
        fleet: Fleet,
        level_of: Callable[[Identification], str] = lambda _: "",
        models: Path | None = None,
    ) -> None:
        self.fleet = fleet
        self.level_of = level_of
        self.models = models
        self.formats = [load_reader_file(content) for content in fleet.readers]

    def columns(self, block: Block) -> dict[str, Any]:
        """Return the rows of the logs of a block, by column, each of shape (log,)."""
        rows = [self._row(number) for number in range(block.first, block.last)]
        blank = {
            name: "" if column["role"] == "run" else np.nan
            for name, column in self.fleet.columns.items()
        } | {"time_of_log": None}
        return {name: [row.get(name, value) for row in rows] for name, value in blank.items()}

    def _row(self, number: int) -> dict[str, Any]:
        """Return the row of a log, with the reason if it cannot be read or fitted."""
        log = self.fleet.logs[number]
        row: dict[str, Any] = {
            "run": number,
            "folder": log.folder,
            "log": log.name,
            "status": OK,
            "reason": "",
        }
        if log.time is not None:
            row["time_of_log"] = round(1e6 * log.time)
        try:
            with warnings.catch_warnings(), reading(*self.formats):
                warnings.simplefilter("ignore")
                return row | self._numbers(log)
        except BristleError as error:
            return row | {"status": REFUSED, "reason": error_text(error)[:REASON]}
        except MemoryError:
            return row | {"status": RAISED, "reason": "there is not enough memory for this log"}
        except Exception as error:  # noqa: BLE001  (a user-defined model or reader may raise any exception)
            return row | {
                "status": RAISED,
                "reason": f"{type(error).__name__}: {error_text(error)}"[:REASON],
            }

    def _numbers(self, entry: LogFile) -> dict[str, Any]:
        axis = self.fleet.axes[entry.axis]
        log = read_log(entry.place, axis, size_limit=self.fleet.size_limit)
        if entry.checksum and log.origin.checksum != entry.checksum:
            raise InputError("has changed since the command began", path=entry.place)
        if log.kind != self.fleet.kind:
            raise InputError(
                f"is the log of a {log.kind} axis, but this fleet has {self.fleet.kind} axes",
                path=entry.place,
            )
        options: dict[str, Any] = {"settings": {}} | dict(self.fleet.options)
        thresholds = options.pop("settings")
        if isinstance(thresholds, Settings):
            settings = thresholds.as_data()
        else:
            settings = dict(thresholds or {})
        # The logs of an axis are compared: no lines of its own for a log.
        if self.models is None:
            settings |= {"lines_gain": 1.0}
        identification = identify(
            log, self.fleet.model, axis=axis, settings=settings, **options
        ).finished
        fit = identification.fits[0]
        if self.models is not None and axis is not None:
            (self.models / axis.name).mkdir(exist_ok=True)
            place = self.models / axis.name / "model.toml"
            treatment = identification.treatment
            bands = fit.resampling and fit.resampling.bands
            source = {key: text for key, text in provenance("", log=log).items() if text}
            write_model(
                place,
                fit.plant,
                fit.friction,
                estimates=fit.estimates,
                provenance=source,
                treatment=treatment,
                bands=bands,
            )
        codes = dict.fromkeys(
            diagnostic.code for diagnostic in fit.diagnostics if diagnostic.severity == "warning"
        )
        row: dict[str, Any] = {
            "error": 0.01 * fit.error_percent,
            "diagnostics": ", ".join(codes),
            "duration": log.duration,
            "verdict": self.level_of(identification),
        }
        if fit.held_out is not None:
            row["held_out_error"] = 0.01 * fit.held_out.mean_percent
        if fit.resampling is not None:
            scatter = fit.resampling.scatter
            row |= {
                "scatter": scatter.value,
                "scatter.lower": scatter.low,
                "scatter.upper": scatter.high,
            }
        if log.temperature is not None:
            row["temperature"] = float(np.mean(log.temperature.values))
        for column in self.fleet.parameters:
            estimate = fit.parameters.get(column.partition(".")[2])
            if estimate is not None:
                row |= _of_estimate(column, estimate)
        return row


def _of_estimate(column: str, estimate: Estimate) -> Mapping[str, Any]:
    """Return value, ends of the 95 % interval and status of a parameter; no value if the log does not identify it."""
    row: dict[str, Any] = {f"{column}.status": estimate.status}
    if estimate.status == "unidentifiable":
        return row
    row[column] = estimate.value
    if estimate.ends is not None and math.isfinite(estimate.ends[1]):
        row |= dict(zip((f"{column}.lower", f"{column}.upper"), estimate.ends, strict=True))
    return row


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
    """Return many logs as a fleet, with the data that distinguish it from others; identification starts later."""
    listed = listed_logs(logs, size_limit=size_limit)
    if not listed:
        raise InputError("has no logs", path="logs", mend="Name the logs, or a folder of logs")
    chosen, *further = models_of(model)
    if further:
        raise InputError(
            "takes one model, because parameters of different models are not comparable",
            path="--each",
            value=", ".join(component.name for component in (chosen, *further)),
            mend="Compare models on one log first, then name the best model",
        )
    described: list[Any] = [AXIS(axis, "axis", None) for axis in axes] or [None]
    is_trace = len(listed) == 1 < len(described)  # of several axes
    if is_trace:
        named = [axis.name if axis is not None else "" for axis in described]
        if len(set(named)) < len(named):
            raise InputError(
                "must differ, because one log contains all axes",
                path="name",
                value=", ".join(named),
            )
        listed = [replace(listed[0], name=f"{name}: {listed[0].name}") for name in named]
    axes_for(described, len(listed))
    kinds: set[Any] = {axis.kind for axis in described if axis is not None}
    plants = {
        (
            axis.plant,
            is_trace
            or (
                axis.gravity,
                axis.spring,
                axis.cogging,
                tuple(term.name for term in axis.regressors),
            ),
        )
        for axis in described
        if axis is not None
    }
    if len(kinds) > 1 or len(plants) > 1:
        raise InputError(
            "the files describe axes of different kinds or plants",
            path="--axis",
            mend="Write a separate fleet for each kind",
        )
    if not kinds:  # the kind of the log; the usual kind if it cannot be read
        kinds = {"translational"}
        with suppress(InputError):
            kinds = {read_log(listed[0].place, size_limit=size_limit).kind}
    numbered = tuple(
        replace(log, axis=number if len(described) > 1 else 0) for number, log in enumerate(listed)
    )
    kind = kinds.pop()
    refuse_options(identify, options or {}, chosen, kind)
    fleet = Fleet(
        name,
        numbered,
        tuple(described),
        kind,
        chosen,
        dict(options or {}),
        tuple(readers),
        size_limit,
        {},
    )
    texts = {axis.text or repr(axis).encode() for axis in described if axis is not None}
    identity = {
        "fleet": {"model": fleet.model.name} | plain(fleet.options),
        "axes": sorted(Content(Path("axis"), text).checksum for text in texts),
        "code": {origin.name: origin.checksum for origin in origins_of_code([fleet.model])},
        "readers": [content.checksum for content in fleet.readers],
        "columns": sorted(fleet.columns),
        "bristle": version("bristle"),
    }
    return replace(fleet, described=identity)


@guarded()
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
    """Identify each of many logs separately, with one model, and store one row per log in a folder.

    Parameters
    ----------
    logs : sequence of path-like
        Files, folders with all their contents, or ``FILE::TABLE``, with ``*`` for several tables of a file.
    folder : path-like
        A new folder, or the folder of the same fleet: bristle then identifies missing logs and adds new logs.
    model : str or FrictionModel
        The model for all logs.
    axis : Axis or path-like, or list of either, optional
        One axis for all logs, or one for each log.
    workers : int, optional
        Number of processes; by default the number of cores.
    progress : callable, optional
        Called with the share done and the remaining time.
    **options
        Arguments of `bristle.identify`.

    Returns
    -------
    Ran
        Number of logs that needed no work, and the logs whose process crashed. `bristle.read_study` reads the rows.

    Raises
    ------
    InputError
        If a log does not exist, the folder has other contents, or the disk is full. A log that cannot be read or
        fitted gets a row with the reason.
    """
    if axis is None:
        axes = []
    elif isinstance(axis, (list, tuple)):
        axes = list(axis)
    else:
        axes = [axis]
    fleet = fleet_of(logs, model=model, axes=axes, name=Path(folder).name, options=options)
    with opened(Path(folder), fleet, {}, FleetStore) as store:
        return run_within(store, workers=workers, progress=progress, simulator=Identifier)
