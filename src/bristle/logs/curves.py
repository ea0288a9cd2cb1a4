"""`Curves`: what was recorded of a hysteresis, output over input, along one path or several that start alike."""

from __future__ import annotations

import fnmatch
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bristle.core import units
from bristle.core.content import NOWHERE, SIZE_LIMIT, Origin, Readable
from bristle.core.edge import CURVE, TEXT, among, guarded, instance, many, taken
from bristle.core.errors import InputError
from bristle.core.lazy import cached_property
from bristle.core.variable import KINDS, Kind, unit_of
from bristle.logs.problems import LARGEST, SMALLEST
from bristle.logs.readers import read_table
from bristle.logs.table import Table


class Curve(NamedTuple):
    """One path of the input and the output along it.

    Parameters
    ----------
    u, f : ndarray, shape (sample,)
        Input and output, in SI.
    """

    u: np.ndarray
    f: np.ndarray


@guarded()
@dataclass(frozen=True, eq=False)
class Curves:
    """Hysteresis as it was recorded: no time, only the order of the samples.

    Parameters
    ----------
    curves : tuple of Curve
        Each begins anew from `start`.
    start : {"virgin", "saturated"}
        The state before each curve: demagnetised, or saturated at the end of the range that the curve heads for, so
        that its first sample lies on the major branch.
    kind : {"translational", "rotational", "magnetic", "piezo"}
        Input and output are displacement and force, angle and torque, or field and moment.
    source : Path
        The file.
    origin : Origin
        Name and SHA-256 of the file, and the table in it.
    notes : tuple of str
        What was left out.
    """

    curves: tuple[Curve, ...] = taken(many(lambda pair, path, kind: Curve(*CURVE(pair, path, kind)), least=1))
    start: str = taken(among("virgin", "saturated"), "virgin")
    kind: Kind = taken(among(*KINDS, "magnetic", "piezo"), "translational")
    source: Path = taken(instance(Path, "a path", read=Path), Path())
    origin: Origin = taken(instance(Origin, "an Origin"), NOWHERE)
    notes: tuple[str, ...] = taken(many(TEXT), ())

    @cached_property
    def full_scale(self) -> float:
        """Largest output of all."""
        return max(float(np.max(np.abs(curve.f))) for curve in self.curves)

    @cached_property
    def low(self) -> float:
        """Smallest input of all."""
        return min(float(np.min(curve.u)) for curve in self.curves)

    @cached_property
    def high(self) -> float:
        """Largest input of all."""
        return max(float(np.max(curve.u)) for curve in self.curves)

    def history(self, curve: Curve) -> np.ndarray:
        """Return the inputs that the operator went through before a curve, from its virgin state."""
        if self.start == "virgin":
            return np.empty(0)
        far = 10.0 * max(abs(self.low), abs(self.high))  # times the largest input of the record
        return np.array([far if curve.u[-1] >= curve.u[0] else -far])


@dataclass(frozen=True)
class SignalColumn:
    """Which column holds a signal, in what unit (empty: what the file says, else SI), and with what sign."""

    name: str
    unit: str = ""
    sign: float = 1.0


@dataclass(frozen=True)
class CurveColumns:
    """Where the curves of a hysteresis are in a file."""

    input: SignalColumn
    output: SignalColumn
    kind: Kind = "translational"
    start: str = "virgin"
    tables: str = ""
    curve: str = ""
    shortest: int = 2
    name: str = "hysteresis"


def read_curves(given: Readable, columns: CurveColumns, *, size_limit: int = SIZE_LIMIT) -> Curves:
    """Return the curves in a file; `bristle.files.curves.read_curves` tells more."""
    table = read_table(given, size_limit=size_limit)
    notes, place, candidates = list(table.notes), str(table.source), []
    names = [name for name in table.tables if fnmatch.fnmatchcase(name, columns.tables)]
    if columns.tables and not names:
        allowed = (", ".join(table.tables[:5]) or "one table only") + (" and more" if len(table.tables) > 5 else "")
        raise InputError("fits the name of no table of the log", path="log.tables", value=columns.tables, allowed=allowed)
    for part in [f"{name}/" for name in names] if columns.tables else [""]:
        u = _signal(table, part, columns.input, "input", "length", columns.kind)
        f = _signal(table, part, columns.output, "output", "force", columns.kind)
        number = _column(table, part, columns.curve, "curve") if columns.curve else np.zeros(u.size)
        if u.size != f.size:
            raise InputError(f"has an input of {u.size} samples and an output of {f.size}", path=place)
        if number.size != u.size:
            raise InputError(f"has {number.size} samples, and the input has {u.size}", path=f"{place}: curve")
        starts = np.flatnonzero(np.diff(number)) + 1
        candidates += [Curve(*pair) for pair in zip(np.split(u, starts), np.split(f, starts), strict=True)]
    chosen = [curve for curve in candidates if curve.u.size >= columns.shortest]
    if not chosen:
        allowed = f"at least {columns.shortest} samples"
        raise InputError("holds no curve that is long enough", path=place, value=f"{len(candidates)} curves", allowed=allowed)
    if len(chosen) < len(candidates):
        notes.append(f"{len(candidates) - len(chosen)} curves of less than {columns.shortest} samples were left out")
    if np.ptp(np.concatenate([curve.u for curve in chosen])) < SMALLEST:
        raise InputError("is constant", path=f"{place}: {columns.input.name}", mend="Which column is the input?")
    return Curves(tuple(chosen), columns.start, columns.kind, table.source, table.origin, tuple(notes))


def _signal(table: Table, part: str, column: SignalColumn, key: str, quantity: str, kind: Kind) -> np.ndarray:
    values = _column(table, part, column.name, key)
    place = f"{table.source}: column {part}{column.name}"
    unit = column.unit or table.units.get(table.name_of(part + column.name) or "", "")
    values = column.sign * (units.factor(unit, unit_of(quantity, kind), path=place) if unit else 1.0) * values
    bad = np.flatnonzero(~(np.abs(values) <= LARGEST))
    if bad.size:
        message = "is no measurement" if np.isfinite(values[bad[0]]) else "is not a finite number"
        mend = "Cut the curve before that sample, or repair it"
        raise InputError(message, path=f"{place}[{bad[0]}]", value=float(values[bad[0]]), mend=mend)
    return values


def _column(table: Table, part: str, name: str, key: str) -> np.ndarray:
    stored_name = table.name_of(part + name)
    if stored_name is None:
        raise table.missing(part + name, key)
    return np.asarray(table.columns[stored_name], dtype=float)
