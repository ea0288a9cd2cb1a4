"""One log of a fleet: read, identified, and what is kept of it as a row; one that fails is a row with its reason."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any

import numpy as np

from bristle.core.errors import BristleError, InputError, told_by
from bristle.core.normal import NORMAL_95
from bristle.files.user_model import load_reader_file
from bristle.fleet.columns import numbers_of, texts_of
from bristle.fleet.plan import Fleet, LogFile
from bristle.identification.identify import identify
from bristle.identification.result import Estimate, Fit
from bristle.logs.formats import reading
from bristle.logs.log import Log
from bristle.logs.readers import read_log
from bristle.study.block import RAISED, REASON, REFUSED
from bristle.study.dataset import OK
from bristle.study.plan import Block

__all__ = ["Identifier"]


class Identifier:
    """What identifies the logs of a fleet, in this process."""

    def __init__(self, fleet: Fleet) -> None:
        self.fleet = fleet
        self.formats = [load_reader_file(content) for content in fleet.readers]

    def columns(self, block: Block) -> dict[str, Any]:
        """Return the rows of the logs of a block, by column, each of shape (log,)."""
        rows = [self._row(number) for number in range(block.first, block.last)]
        numbers = {quantity.column: np.nan for quantity in numbers_of(self.fleet)}
        blank = dict.fromkeys(texts_of(self.fleet), "") | numbers | {"time_of_log": None}
        return {name: [row.get(name, blank.get(name)) for row in rows] for name in ("run", *blank)}

    def _row(self, number: int) -> dict[str, Any]:
        log = self.fleet.logs[number]
        row: dict[str, Any] = {"run": number, "folder": log.folder, "log": log.name, "status": OK, "reason": ""}
        if log.time is not None:
            row["time_of_log"] = round(1e6 * log.time)
        try:
            with ExitStack() as context:
                context.enter_context(warnings.catch_warnings())
                warnings.simplefilter("ignore")
                context.enter_context(reading(*self.formats))
                return row | self._numbers(log)
        except BristleError as error:
            return row | {"status": REFUSED, "reason": told_by(error)[:REASON]}
        except MemoryError:
            return row | {"status": RAISED, "reason": "there is not enough memory for this log"}
        except Exception as error:  # noqa: BLE001  (a model or a reader of a person's own may raise anything)
            return row | {"status": RAISED, "reason": f"{type(error).__name__}: {told_by(error)}"[:REASON]}

    def _numbers(self, entry: LogFile) -> dict[str, Any]:
        axis = self.fleet.axes[entry.axis]
        log = read_log(entry.place, axis, size_limit=self.fleet.size_limit)
        if entry.checksum and log.origin.checksum != entry.checksum:
            raise InputError("has changed since the command began", path=entry.place)
        if log.kind != self.fleet.kind:
            raise InputError(f"is {log.kind}, and this fleet is {self.fleet.kind}", path=entry.place)
        identification = identify(log, self.fleet.model, axis=axis, **self.fleet.options)
        if identification.unfinished:  # a person wants it to end: half a fit is no row
            raise KeyboardInterrupt
        fit = identification.fits[0]
        row: dict[str, Any] = _of_fit(fit) | _of_log(log)
        for name, quantity in self.fleet.parameters.items():
            if name in fit.parameters:
                row |= _of_estimate(quantity.column, fit.parameters[name])
        return row


def _of_fit(fit: Fit) -> dict[str, Any]:
    row: dict[str, Any] = {"error": 0.01 * fit.error_percent}
    row["diagnostics"] = ", ".join(dict.fromkeys(diagnostic.code for diagnostic in fit.diagnostics if diagnostic.severity == "warning"))
    if fit.held_out is not None:
        row["held_out_error"] = 0.01 * fit.held_out.mean_percent
    if fit.resampling is not None:
        scatter = fit.resampling.scatter
        row |= {"scatter": scatter.value, "scatter.lower": scatter.low, "scatter.upper": scatter.high}
    return row


def _of_log(log: Log) -> dict[str, Any]:
    row: dict[str, Any] = {"duration": log.duration}
    if log.temperature is not None:
        row["temperature"] = float(np.mean(log.temperature.values))
    return row


def _of_estimate(column: str, estimate: Estimate) -> Mapping[str, Any]:
    """Return value, ends of the 95 % interval and status of a parameter; no value where the log does not tell it."""
    row: dict[str, Any] = {f"{column}.status": estimate.status}
    if estimate.status == "unidentifiable":
        return row
    row[column] = estimate.value
    ends = estimate.interval
    if ends is None and estimate.larger_std is not None and math.isfinite(estimate.larger_std):
        ends = tuple(estimate.value + side * NORMAL_95 * estimate.larger_std for side in (-1.0, 1.0))
    if ends is not None:
        row |= {f"{column}.lower": ends[0], f"{column}.upper": ends[1]}
    return row
