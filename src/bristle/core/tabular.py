"""Display and export of results: a card, a data frame, a data set with units, plain lists."""

import importlib
import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, fields, is_dataclass
from html import escape
from typing import Any, NamedTuple

import numpy as np

from bristle.core.errors import MOST_SHOWN, MissingExtraError, in_one_line, shortened
from bristle.core.motion import RECORDED
from bristle.core.status import Status
from bristle.core.typography import number, scale_of
from bristle.core.variable import Variable

MOST_REMARKS = 6  # with title, heads and omissions at most 30 lines, a screen


class Card(NamedTuple):
    """A title, a table and remarks; the card states the number of omitted rows and remarks."""

    title: str
    heads: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def _rest(self) -> list[str]:
        """Remarks up to the limit, and the number of omitted rows and remarks."""
        # Characters of a remark.
        lines = [shortened(in_one_line(remark), 100) for remark in self.remarks[:MOST_REMARKS]]
        for left, noun in (
            (len(self.rows) - MOST_SHOWN, "rows"),
            (len(self.remarks) - MOST_REMARKS, "remarks"),
        ):
            lines += [f"and {left} more {noun}"] if left > 0 else []
        return lines

    def text(self) -> str:
        """Return the card as text that fits a screen."""
        rows = [
            tuple(map(in_one_line, row)) for row in (self.heads, *self.rows[:MOST_SHOWN]) if row
        ]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = [
            "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
            for row in rows
        ]
        return "\n".join(
            [in_one_line(self.title), *(f"  {line}".rstrip() for line in (*lines, *self._rest))]
        )

    def html(self) -> str:
        """Return the card as HTML; text from files is escaped."""

        def row(cells: tuple[str, ...], tag: str) -> str:
            side = ' style="text-align: left; padding-right: 1em"'
            return (
                "<tr>"
                + "".join(f"<{tag}{side}>{escape(in_one_line(cell))}</{tag}>" for cell in cells)
                + "</tr>"
            )

        body = "".join(row(cells, "td") for cells in self.rows[:MOST_SHOWN])
        table = (
            f"<table><thead>{row(self.heads, 'th')}</thead><tbody>{body}</tbody></table>"
            if self.rows
            else ""
        )
        remarks = "".join(f"<li>{escape(remark)}</li>" for remark in self._rest)
        listed = f"<ul>{remarks}</ul>" if remarks else ""
        return f"<div><strong>{escape(in_one_line(self.title))}</strong>{table}{listed}</div>"


class WithCard:
    """A result that is displayed as a card instead of all its numbers."""

    def __init_subclass__(cls, **arguments: object) -> None:
        super().__init_subclass__(**arguments)
        # A dataclass adds a __repr__ to each class without it.
        cls.__repr__ = WithCard.__repr__  # type: ignore[method-assign]

    def _card(self) -> Card:
        """Return the card of the result."""
        return Card(type(self).__name__)

    def __repr__(self) -> str:
        return self._card().text()

    def _repr_html_(self) -> str:
        return self._card().html()


def of_upper_layer(place: str, function: str) -> Callable[..., Any]:
    """Return a method that is a function of an upper layer, imported at its first use."""

    def method(self: Any, **options: Any) -> Any:
        return getattr(importlib.import_module(place), function)(self, **options)

    return method


SIGNALS: dict[str, Variable] = {
    "time": Variable("time", "time"),
    "position": Variable("length", "position"),
    "velocity": Variable("length/time", "velocity"),
    "effort": Variable("force", "effort of the drive"),
    "reference": Variable("length", "desired position"),
    **RECORDED,
    "measured": Variable("length", "position measured by the sensor"),
    "command": Variable("force", "effort commanded by the controller"),
    "feedforward": Variable("force", "feedforward effort"),
    "compensation": Variable("force", "feedforward effort along the measured motion"),
    "friction": Variable("force", "friction force, mean until the next sample"),
    "motor_position": Variable("length", "position of the motor"),
    "motor_velocity": Variable("length/time", "velocity of the motor"),
    "effort_predicted": Variable("force", "predicted effort"),
    "half_width": Variable("force", "half-width of the 95 % band around the effort"),
    "position_predicted": Variable("length", "predicted position"),
    "position_half_width": Variable("length", "half-width of the 95 % band around the position"),
}
"""Name of a signal -> its variable."""


class Signal(NamedTuple):
    """Samples, SI unit and description of a signal."""

    values: np.ndarray
    unit: str
    description: str


class Tabular(WithCard):
    """Base of results with named signals of equal length and further data."""

    def _signals(self) -> dict[str, Signal]:
        """Return the available signals, time first."""
        held: dict[str, Any] = {name: getattr(self, name, None) for name in SIGNALS}
        return {
            name: Signal(
                held[name],
                variable.unit(getattr(self, "kind", "translational")),
                variable.description,
            )
            for name, variable in SIGNALS.items()
            if isinstance(held[name], np.ndarray) and np.shape(held[name]) == np.shape(held["time"])
        }

    def _facts(self) -> dict[str, Any]:
        """Return the further data as plain data."""
        rest = (spec.name for spec in fields(self) if spec.name not in SIGNALS)  # type: ignore[arg-type]
        return {"kind": getattr(self, "kind", "translational")} | {
            name: plain(getattr(self, name)) for name in rest
        }

    def to_dict(self) -> dict[str, Any]:
        """Return plain data: ``signals`` and ``units`` by name, and all other fields."""
        signals = self._signals()
        return self._facts() | {
            "units": {name: signal.unit for name, signal in signals.items()},
            "signals": {name: signal.values.tolist() for name, signal in signals.items()},
        }

    def to_dataframe(self) -> Any:
        """Return the signals as a pandas data frame in SI units, with one row per sample."""
        pandas = library("pandas", "to_dataframe()")
        signals = self._signals()
        frame = pandas.DataFrame({name: signal.values for name, signal in signals.items()})
        frame.attrs["units"] = {name: signal.unit for name, signal in signals.items()}
        return frame

    def to_xarray(self) -> Any:
        """Return the signals as an xarray data set over time, in SI units."""
        xarray = library("xarray", "to_xarray()")
        held = {
            name: (
                "time",
                np.array(signal.values),
                {"units": signal.unit, "long_name": signal.description},
            )
            for name, signal in self._signals().items()
        }
        facts = {
            name: fact
            for name, fact in self._facts().items()
            if isinstance(fact, (str, int, float))
        }
        return xarray.Dataset(held, coords={"time": held.pop("time")}, attrs=facts)

    def _card(self) -> Card:
        signals = self._signals()
        rows = tuple(
            (name, ranged(signal.values, signal.unit), signal.description)
            for name, signal in signals.items()
        )
        return Card(self._title(), ("Signal", "Range", "Description"), rows, tuple(self._remarks()))

    def _title(self) -> str:
        return f"{type(self).__name__} of {len(self._signals()['time'].values)} samples, {getattr(self, 'kind', 'translational')}"

    def _remarks(self) -> list[str]:
        status = getattr(self, "status", Status.OK)
        return [f"status: {status.sentence}", *getattr(self, "notes", ())]


def ranged(values: np.ndarray, unit: str) -> str:
    """Return the range of a signal in a suitable multiple of its unit."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return "no finite number"
    low, high = float(finite.min()), float(finite.max())
    scale = scale_of(unit, max(abs(low), abs(high)))
    lost = f", {values.size - finite.size} not finite" if finite.size < values.size else ""
    ends = dict.fromkeys(number(end * scale.factor) for end in (low, high))
    return f"{' to '.join(ends)} {scale.unit}".rstrip() + lost


def plain(value: Any) -> Any:
    """Convert a value to text, numbers, lists and dictionaries of JSON; numbers that are not finite become None."""
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
    """Import an optional library."""
    try:
        return importlib.import_module(name)
    except ImportError:
        if extra:
            raise MissingExtraError.of(wanted_by, extra) from None
        raise MissingExtraError(
            f"needs {name}, which is not installed",
            path=wanted_by,
            mend=f"Type: pip install {name}",
        ) from None
