"""Tracks: what the logs of each axis say of one quantity over time, read from folders of fleets."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.errors import InputError, did_you_mean
from bristle.core.normal import NORMAL_95
from bristle.fleet.moment import moment_in
from bristle.study.dataset import OK, runs_in
from bristle.study.store import STUDY

__all__ = ["DAY", "SCATTER", "Rows", "Track", "pattern_of", "rows_in", "tracks_of"]

DAY = 86400.0  # [s]
SCATTER = "scatter"
TOLD_BY_MOST = 0.5  # share of the logs of an axis that must tell a quantity
TEMPERATURE_IN_MOST = 0.9
FEWEST = 5  # observations of a track


@dataclass(frozen=True)
class Rows:
    """The rows of all logs that are watched, in order of time."""

    axis: tuple[str, ...]
    log: tuple[str, ...]
    time: np.ndarray | None
    columns: Mapping[str, np.ndarray]
    described: Mapping[str, Mapping[str, str]]


@dataclass(frozen=True)
class Track:
    """One quantity of one axis over time, an observation for each day on which there are logs."""

    axis: str
    quantity: str
    unit: str
    time: np.ndarray
    value: np.ndarray
    std: np.ndarray
    temperature: np.ndarray | None
    is_dated: bool

    @property
    def is_logarithmic(self) -> bool:
        """Whether the values are logarithms: of a standard deviation, which is positive and spreads by factors."""
        return self.quantity == SCATTER


def pattern_of(text: str | None) -> re.Pattern[str] | None:
    """Return the pattern by which the axis of a log is known, and its date."""
    if text is None:
        return None
    try:
        pattern = re.compile(text)
    except (re.error, RecursionError) as error:
        raise InputError(f"is no regular expression: {error}", path="--axis-from", value=text) from None
    if "axis" not in pattern.groupindex:
        raise InputError("has no group called axis", path="--axis-from", value=text, mend='Write "(?P<axis>[^_]+)_(?P<date>.*)"')
    return pattern


def _stores_in(folder: Path) -> Iterator[Path]:
    """Yield the folders of fleets: this one, else those right below it."""
    if (folder / STUDY).is_file():
        yield folder
        return
    if not folder.is_dir():
        raise InputError("there is no such folder", path=str(folder), mend="Name what bristle identify --each wrote")
    below = [folder / name for name in sorted(os.listdir(folder)) if (folder / name / STUDY).is_file()]
    if not below:
        raise InputError("holds no fleet", path=str(folder), mend="Name what bristle identify --each wrote")
    yield from below


def rows_in(folders: Sequence[str | Path], *, axis_from: str | None = None) -> Rows:
    """Return the rows of fleets."""
    pattern = pattern_of(axis_from)
    stores = [store for folder in folders for store in _stores_in(Path(folder))]
    parts = [runs_in(store) for store in stores]
    for store, part in zip(stores, parts, strict=True):
        if "logs" not in part.described:
            raise InputError("is a study, not a fleet", path=str(store), mend="Name what bristle identify --each wrote")
        if part.described["model"] != parts[0].described["model"] or part.described["kind"] != parts[0].described["kind"]:
            raise InputError(
                "is of another model or kind than the first",
                path=str(store),
                value=part.described["model"],
                allowed=parts[0].described["model"],
            )
    parts = [part for part in parts if part.count]
    if not parts:
        raise InputError("holds no log yet", path=str(stores[0]))
    names = [name for name in parts[0].columns if all(name in part.columns for part in parts)]
    columns = {name: np.concatenate([part.columns[name] for part in parts]) for name in names}
    axes, times = _axes_and_times(columns, pattern)
    order = np.lexsort((columns["log"], times)) if np.all(np.isfinite(times)) else np.arange(len(axes))
    return Rows(
        tuple(axes[place] for place in order),
        tuple(str(columns["log"][place]) for place in order),
        times[order] if np.all(np.isfinite(times)) else None,
        {name: column[order] for name, column in columns.items()},
        parts[0].described["columns"],
    )


def _axes_and_times(columns: Mapping[str, Any], pattern: re.Pattern[str] | None) -> tuple[list[str], np.ndarray]:
    stamps = columns["time_of_log"]
    if stamps.dtype.kind == "M":
        times = np.where(np.isnat(stamps), np.nan, stamps.astype("datetime64[us]").astype(float) * 1e-6)
    else:
        times = np.full(len(stamps), np.nan)
    if pattern is None:
        return [str(folder) for folder in columns["folder"]], times
    axes = []
    for place, (folder, log) in enumerate(zip(columns["folder"], columns["log"], strict=True)):
        match = pattern.search(f"{folder}/{log}")
        if match is None or not match["axis"]:
            raise InputError(
                "does not fit the pattern of its axis", path=f"{folder}/{log}", allowed=pattern.pattern, mend="Mend --axis-from"
            )
        axes.append(match["axis"])
        if "date" in pattern.groupindex and match["date"]:
            moment = moment_in(match["date"])
            if moment is None:
                raise InputError(
                    "is no date that is written year, month, day", path=f"{folder}/{log}", value=match["date"], mend="Mend --axis-from"
                )
            times[place] = moment
    return axes, times


def tracks_of(rows: Rows, quantities: Sequence[str] = (), *, since: float | None = None) -> list[Track]:
    """Return the tracks of each axis."""
    usual = [name for name, about in rows.described.items() if about.get("stands_for")]
    numbers = [name for name, about in rows.described.items() if about["role"] in ("parameter", "fit")]
    for name in quantities:
        if name not in numbers:
            raise InputError(
                "is no quantity of this fleet", path="--track", value=name, allowed=", ".join(numbers), mend=did_you_mean(name, numbers)
            )
    usable = rows.columns["status"] == OK
    if since is not None:
        if rows.time is None:
            raise InputError("needs logs that all say when they were recorded", path="--since", mend="Name the date with --axis-from")
        usable = usable & (rows.time >= since)
    axes = np.array(rows.axis)
    tracks = []
    for axis in dict.fromkeys(rows.axis):
        chosen = np.flatnonzero((axes == axis) & usable)
        candidates = [_track(rows, axis, chosen, name) for name in (quantities or usual)]
        tracks += [track for track in candidates if track is not None]
    return tracks


def _track(rows: Rows, axis: str, chosen: np.ndarray, name: str) -> Track | None:
    value, std = rows.columns[name][chosen], _std(rows, name, chosen)
    logarithmic = name == SCATTER
    usable = np.isfinite(value) & np.isfinite(std) & ((value > 0.0) if logarithmic else True)
    status = rows.columns.get(f"{name}.status")
    if status is not None:
        usable &= status[chosen] == "identified"
    if usable.sum() < max(FEWEST, TOLD_BY_MOST * chosen.size):
        return None
    temperature = rows.columns["temperature"][chosen]
    warm = np.isfinite(temperature)
    with_temperature = warm[usable].mean() >= TEMPERATURE_IN_MOST and np.ptp(temperature[usable & warm]) > 0.0
    if with_temperature:
        usable &= warm
    value, std, temperature = value[usable], std[usable], temperature[usable]
    if logarithmic:
        value, std = np.log(value), std / value
    time = rows.time[chosen][usable] / DAY if rows.time is not None else np.arange(usable.sum(), dtype=float)
    groups = np.unique(np.floor(time), return_inverse=True)[1]
    weight = 1.0 / np.square(std)
    total = np.bincount(groups, weight)

    def mean(values: np.ndarray) -> np.ndarray:
        return np.bincount(groups, weight * values) / total

    return Track(
        axis,
        name,
        "" if logarithmic else rows.described[name].get("unit", ""),
        mean(time),
        mean(value),
        1.0 / np.sqrt(total),
        mean(temperature) if with_temperature else None,
        rows.time is not None,
    )


def _std(rows: Rows, name: str, chosen: np.ndarray) -> np.ndarray:
    """Return the standard error of each log by its interval; all alike where there is none."""
    ends = [rows.columns.get(f"{name}.{end}") for end in ("lower", "upper")]
    if ends[0] is None or ends[1] is None:
        return np.ones(chosen.size)
    std = (ends[1][chosen] - ends[0][chosen]) / (2.0 * NORMAL_95)
    if not np.any(np.isfinite(std)):
        return np.ones(chosen.size)
    least = 1e-3 * float(np.nanmedian(std)) or 1e-12
    return np.maximum(std, least)
