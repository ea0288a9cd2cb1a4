"""Results as people and other libraries take them: a card, a data frame, a data set with units, plain lists."""

import importlib
import math
from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass
from html import escape
from typing import Any, NamedTuple

import numpy as np

from bristle.core.errors import MOST_SHOWN, MissingExtraError, in_one_line, shortened
from bristle.core.motion import RECORDED
from bristle.core.status import Status
from bristle.core.typography import number, scale_of
from bristle.core.variable import Variable

MOST_REMARKS = 6  # with title, heads and what is left out 30 lines: a screen


class Card(NamedTuple):
    """A title, a table, and remarks; what is too much of it is counted."""

    title: str
    heads: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def _rest(self) -> list[str]:
        """The remarks, as many as there is room for, and how much is left out."""
        lines = [shortened(in_one_line(remark), 100) for remark in self.remarks[:MOST_REMARKS]]  # characters of a remark
        for left, noun in ((len(self.rows) - MOST_SHOWN, "rows"), (len(self.remarks) - MOST_REMARKS, "remarks")):
            lines += [f"and {left} more {noun}"] if left > 0 else []
        return lines

    def text(self) -> str:
        """Return it as lines of text, fewer than a screen has."""
        rows = [tuple(map(in_one_line, row)) for row in (self.heads, *self.rows[:MOST_SHOWN]) if row]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
        return "\n".join([in_one_line(self.title), *(f"  {line}".rstrip() for line in (*lines, *self._rest))])

    def html(self) -> str:
        """Return it as HTML; what comes from files is escaped."""

        def row(cells: tuple[str, ...], tag: str) -> str:
            side = ' style="text-align: left; padding-right: 1em"'
            return "<tr>" + "".join(f"<{tag}{side}>{escape(in_one_line(cell))}</{tag}>" for cell in cells) + "</tr>"

        body = "".join(row(cells, "td") for cells in self.rows[:MOST_SHOWN])
        table = f"<table><thead>{row(self.heads, 'th')}</thead><tbody>{body}</tbody></table>" if self.rows else ""
        remarks = "".join(f"<li>{escape(remark)}</li>" for remark in self._rest)
        listed = f"<ul>{remarks}</ul>" if remarks else ""
        return f"<div><strong>{escape(in_one_line(self.title))}</strong>{table}{listed}</div>"


class WithCard:
    """A result that is shown as a card rather than with all its numbers."""

    def __init_subclass__(cls, **arguments: object) -> None:
        super().__init_subclass__(**arguments)
        # A dataclass brings a representation of its own for each class that has none.
        cls.__repr__ = WithCard.__repr__  # type: ignore[method-assign]

    def _card(self) -> Card:
        """Return what is shown of it."""
        return Card(type(self).__name__)

    def __repr__(self) -> str:
        return self._card().text()

    def _repr_html_(self) -> str:
        return self._card().html()


SIGNALS: dict[str, Variable] = {
    "time": Variable("time", "time"),
    "position": Variable("length", "position"),
    "velocity": Variable("length/time", "velocity"),
    "effort": Variable("force", "effort of the drive"),
    "reference": Variable("length", "desired position"),
    **RECORDED,
    "measured": Variable("length", "position as the sensor reads it"),
    "command": Variable("force", "effort that the controller asks for"),
    "feedforward": Variable("force", "effort that is fed forward"),
    "compensation": Variable("force", "effort fed forward along the measured motion"),
    "friction": Variable("force", "friction force, mean until the next sample"),
    "motor_position": Variable("length", "position of the motor"),
    "motor_velocity": Variable("length/time", "velocity of the motor"),
    "effort_predicted": Variable("force", "effort that the model predicts"),
    "half_width": Variable("force", "half-width of the 95 % band around the effort"),
    "position_predicted": Variable("length", "position that the model predicts"),
    "position_half_width": Variable("length", "half-width of the 95 % band around the position"),
}
"""Name of a signal -> what it is."""


class Signal(NamedTuple):
    """One signal: its samples, its unit in SI, what it is."""

    values: np.ndarray
    unit: str
    description: str


class Tabular(WithCard):
    """What holds signals of one length, by name, and numbers beside them."""

    def _signals(self) -> dict[str, Signal]:
        """Return the signals that there are, time first."""
        held: dict[str, Any] = {name: getattr(self, name, None) for name in SIGNALS}
        return {
            name: Signal(held[name], variable.unit(getattr(self, "kind", "translational")), variable.description)
            for name, variable in SIGNALS.items()
            if isinstance(held[name], np.ndarray) and np.shape(held[name]) == np.shape(held["time"])
        }

    def _facts(self) -> dict[str, Any]:
        """Return what is told beside the signals, as plain data."""
        rest = (spec.name for spec in fields(self) if spec.name not in SIGNALS)  # type: ignore[arg-type]
        return {"kind": getattr(self, "kind", "translational")} | {name: plain(getattr(self, name)) for name in rest}

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data: ``signals`` and ``units`` by name, and what is told beside them."""
        signals = self._signals()
        return self._facts() | {
            "units": {name: signal.unit for name, signal in signals.items()},
            "signals": {name: signal.values.tolist() for name, signal in signals.items()},
        }

    def to_dataframe(self) -> Any:
        """Return the signals as a data frame of pandas, one row a sample, in SI."""
        pandas = library("pandas", "to_dataframe()")
        signals = self._signals()
        frame = pandas.DataFrame({name: signal.values for name, signal in signals.items()})
        frame.attrs["units"] = {name: signal.unit for name, signal in signals.items()}
        return frame

    def to_xarray(self) -> Any:
        """Return the signals as a data set of xarray over time, in SI."""
        xarray = library("xarray", "to_xarray()")
        held = {
            name: ("time", np.array(signal.values), {"units": signal.unit, "long_name": signal.description})
            for name, signal in self._signals().items()
        }
        facts = {name: fact for name, fact in self._facts().items() if isinstance(fact, (str, int, float))}
        return xarray.Dataset(held, coords={"time": held.pop("time")}, attrs=facts)

    def _card(self) -> Card:
        signals = self._signals()
        rows = tuple((name, ranged(signal.values, signal.unit), signal.description) for name, signal in signals.items())
        return Card(self._title(), ("Signal", "Range", "What it is"), rows, tuple(self._remarks()))

    def _title(self) -> str:
        return f"{type(self).__name__} of {len(self._signals()['time'].values)} samples, {getattr(self, 'kind', 'translational')}"

    def _remarks(self) -> list[str]:
        status = getattr(self, "status", Status.OK)
        return [f"status: {status.sentence}", *getattr(self, "notes", ())]


def ranged(values: np.ndarray, unit: str) -> str:
    """Return the range of a signal in a fitting multiple of its unit."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return "no finite number"
    low, high = float(finite.min()), float(finite.max())
    scale = scale_of(unit, max(abs(low), abs(high)))
    lost = f", {values.size - finite.size} not finite" if finite.size < values.size else ""
    ends = dict.fromkeys(number(end * scale.factor) for end in (low, high))
    return f"{' to '.join(ends)} {scale.unit}".rstrip() + lost


def plain(value: Any) -> Any:
    """Return a value as text, numbers, lists and dictionaries, as JSON knows them; what is no finite number is None."""
    if isinstance(value, Status):
        return value.sentence
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if hasattr(value, "_asdict"):
        return plain(value._asdict())
    if hasattr(value, "tolist"):  # arrays and numbers of numpy
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, slice):
        return [value.start, value.stop]
    if is_dataclass(value) and not isinstance(value, type):
        return plain(asdict(value))
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if value is None or isinstance(value, (str, bool, int, float)) else str(value)


def library(name: str, wanted_by: str, extra: str = "") -> Any:
    """Return a library that is no dependency."""
    try:
        return importlib.import_module(name)
    except ImportError:
        if extra:
            raise MissingExtraError.of(wanted_by, extra) from None
        raise MissingExtraError(f"needs {name}, which is not installed", path=wanted_by, mend=f"Type: pip install {name}") from None
