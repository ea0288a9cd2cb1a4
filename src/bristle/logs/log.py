"""`Log`: recorded channels of a motion axis, each with unit and source column; logs from data frames and arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core import InputError, Variable, did_you_mean, error_text, unit_of
from bristle.core.axis import CHANNELS, OF_COUPLING, Axis, Column, Injected
from bristle.core.edge import KIND, amount, guarded, optional
from bristle.core.tabular import of_upper_layer
from bristle.core.values import shown
from bristle.logs.assembly import record_of
from bristle.logs.channel import Channel, LogData  # noqa: F401  (asked for here)
from bristle.logs.gather import kind_of
from bristle.logs.problems import REPAIR
from bristle.logs.table import USUAL_NAMES, Table, some_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Position and effort have alternative names; for other channels a letter could mean something else.
NAMES = {
    name: (USUAL_NAMES[name] if name in ("time", "position", "effort") else (name,))
    for name in CHANNELS
}
KNOWN_INPUT = "injected."
PLACE = "columns"
SOURCE = Path("<columns>")
MEND = 'Give a data frame or a dictionary with the columns "time", "position" and "effort"'


@guarded(
    kind=optional(KIND),
    sample_time=optional(amount(Variable("time", "time between samples", min=0.0), exclusive=True)),
    columns=lambda columns, path, kind: table_of(columns),
)
def record_of_columns(
    columns: Any, *, axis: Axis | None = None, kind: Any = None, sample_time: Any = None
) -> LogData:
    """Return the log in a table of columns; see `Log.from_columns`."""
    by_name, table = axis is None or not axis.columns, columns
    moved = _named(table.names, "position") or _named(table.names, "velocity") or ""
    used = axis or Axis(kind=kind or kind_of(table.units.get(moved, "")))
    if by_name:
        used = _axis_of(table, used)
        table = replace(table, notes=tuple(_notes_on(table, used)))
    if kind is not None and used.kind != kind:
        raise InputError(
            "differs from the kind of the axis", path="kind", value=kind, allowed=used.kind
        )
    record = record_of(
        table, used if sample_time is None else replace(used, sample_time=sample_time)
    )
    renamed = (
        replace(channel, column=channel.column.removeprefix(KNOWN_INPUT))
        for channel in record.injected
    )
    return replace(record, injected=tuple(renamed)) if by_name else record


def is_table(source: Any) -> bool:
    """Return whether an object is a dictionary, a data frame, a data set or an array with named fields."""
    try:
        named = getattr(getattr(source, "dtype", None), "names", None)
        frame = any(
            hasattr(source, name)
            for name in ("columns", "column_names", "variables", "collect_schema")
        )
        return (
            isinstance(source, Mapping) or bool(named) or (frame and hasattr(source, "__getitem__"))
        )
    except Exception:  # noqa: BLE001  (an object that stops when it is asked what it has is no table)
        return False


def table_of(source: Any) -> Table:
    """Return the columns of numbers in a data frame, a data set, a record array or a mapping."""
    stated, series = _columns_of(source)
    texts: dict[str, InputError] = {}
    columns: dict[str, np.ndarray] = {}
    stated_units: dict[str, str] = {
        name: str(unit) for name, unit in stated.items() if isinstance(unit, str)
    }
    for name, values in series.items():
        try:
            columns[name] = _numbers(values, name)
        except InputError as error:
            texts[name] = error
        attributes = getattr(values, "attrs", None)
        unit = attributes.get("units") if isinstance(attributes, Mapping) else None
        if unit is None and hasattr(values, "magnitude"):  # a quantity with units
            unit = str(values.units).replace(" ", "").replace("**", "^")
        if isinstance(unit, str) and unit:
            stated_units[name] = unit
    return Table(columns, stated_units, texts=texts, source=SOURCE, names=tuple(columns))


def _columns_of(source: Any) -> tuple[Mapping[str, Any], dict[str, Any]]:
    """Return the units that a table states for its columns, and the columns by name."""
    if callable(collect := getattr(source, "collect", None)):  # a lazy frame
        source = collect()
    attributes = getattr(source, "attrs", None)
    stated = attributes.get("units", {}) if isinstance(attributes, Mapping) else {}
    is_mapping = isinstance(source, Mapping)
    names = getattr(getattr(source, "dtype", None), "names", None)  # an array with named fields
    # Xarray; pyarrow; pandas and polars.
    for attribute in ("variables",) if is_mapping else ("column_names", "columns"):
        names = names or getattr(source, attribute, None)
    if names is None and is_mapping:
        names = list(source)
    if names is None or isinstance(names, str) or not hasattr(source, "__getitem__"):
        raise InputError("is not a table of columns", path=PLACE, value=shown(source), mend=MEND)
    series = {str(name): source[name] for name in names}
    index = getattr(source, "index", None)
    if (
        index is not None
        and not callable(index)
        and not set(NAMES["time"]) & {name.lower() for name in series}
    ):
        dates = getattr(getattr(index, "dtype", None), "kind", "") in ("M", "m")
        series |= (
            {"time": index}
            if dates or str(getattr(index, "name", "")).lower() in NAMES["time"]
            else {}
        )
    return stated if isinstance(stated, Mapping) else {}, series


def _numbers(values: Any, name: str) -> np.ndarray:
    """Return a column as numbers; dates as seconds from the first."""
    place = f"{SOURCE}: column {name!r}"
    if np.ma.is_masked(values):
        raise InputError("has masked values", path=place, mend=REPAIR)
    to_numpy: Callable[[], Any] | None = getattr(values, "to_numpy", None)
    samples = np.asarray(
        to_numpy() if to_numpy is not None else getattr(values, "magnitude", values)
    )
    if samples.ndim != 1:
        raise InputError(
            "must be 1-D",
            path=place,
            value=f"an array of shape {samples.shape}",
            mend="Give each signal a separate column",
        )
    if samples.dtype.kind in "mM":
        return (samples - samples[:1]) / np.timedelta64(1, "s")
    if samples.dtype.kind not in "fiubO":
        raise InputError("holds no numbers", path=place, value=samples[0] if samples.size else None)
    try:
        return samples.astype(float)
    except (TypeError, ValueError) as error:
        at = next((i for i, sample in enumerate(samples) if not _is_number(sample)), 0)
        raise InputError(
            f"has no number at sample {at} ({error_text(error)})",
            path=place,
            value=samples[at],
            mend=REPAIR,
        ) from None


def _is_number(sample: Any) -> bool:
    try:
        np.array([sample], dtype=object).astype(float)
    except (TypeError, ValueError):
        return False
    return True


def _named(names: Iterable[str], channel: str) -> str | None:
    """Return the column of a channel: by its exact name first, then by its usual names."""
    columns = list(names)
    spelt = {name.lower(): name for name in reversed(columns)} | {name: name for name in columns}
    return next((spelt[usual] for usual in NAMES[channel] if usual in spelt), None)


def _notes_on(table: Table, axis: Axis) -> Iterator[str]:
    """Yield notes on the choice of columns."""
    named = {channel: column.name for channel, column in axis.columns.items()}
    yield from (
        f"bristle uses column {name} as the {channel}"
        for channel, name in named.items()
        if name != channel
    )
    used = {
        *named.values(),
        *(injected.column for injected in axis.injected),
        *(term.place for term in axis.regressors),
    }
    left = [name for name in (*table.names, *table.texts) if name not in used]
    if left:
        yield f"unused columns: {some_of(left)}"


def _axis_of(table: Table, axis: Axis) -> Axis:
    """Return the axis with the columns of a table that have names of channels, in SI unless they state another unit."""
    columns = {}
    for channel, quantity in CHANNELS.items():
        name, base = _named((*table.names, *table.texts), channel), unit_of(quantity, axis.kind)
        if name is not None and name in table.texts:
            raise table.texts[name]
        if name is not None:
            columns[channel] = Column(name, table.units.get(name, base), base)
    if not {"position", "velocity"} & set(columns):
        hints = filter(None, (did_you_mean(name, NAMES["position"]) for name in table.names))
        mend = next(hints, "Rename the column of the position to position, or give an axis")
        present = some_of(table.names, 40) or "no columns"
        raise InputError(
            "has no position column",
            path=PLACE,
            value=present,
            allowed=f"names: {', '.join(CHANNELS)}",
            mend=mend,
        )
    for name, quantity in OF_COUPLING.items():
        if name in table.names:
            base = unit_of(quantity, axis.kind)
            columns[name] = Column(name, table.units.get(name, base), base)
    injected = tuple(Injected(name, 1.0) for name in table.names if name.startswith(KNOWN_INPUT))
    return replace(axis, columns=columns, injected=injected)


@guarded()
@dataclass(frozen=True, eq=False)
class Log(LogData):
    """Recorded channels of a motion axis, in SI units of the axis, on a uniform grid of time.

    Made by `read_log` from a file, or by `Log.from_columns` from a data frame or a dictionary; both check the data. Arrays
    are accepted without a check: ``Log(time=t, position=x, effort=u)``.

    Parameters
    ----------
    time : Channel or array_like, shape (sample_count,)
        Time [s], uniform within a segment. Here and below, plain numbers are in SI.
    position : Channel or array_like
        Position [m or rad].
    velocity : Channel or None
        Velocity [m/s or rad/s]; this channel and those below are None if not recorded.
    effort : Channel or None
        Effort [N or N*m].
    reference : Channel or None
        Desired position [m or rad].
    load : Channel or None
        Normal load over its nominal value.
    temperature : Channel or None
        Temperature [K].
    injected : tuple of Channel
        Known inputs added to the controller's output [N or N*m]; `effort` contains them.
    sample_time : float
        Time between samples [s]; if 0, bristle computes it from `time`.
    segments : tuple of slice
        Stretches without a gap; derivatives and filters must not cross their ends. The default is a single segment.
    source : Path
        The file.
    origin : Origin
        Name and SHA-256 of the file, and the table in it.
    notes : tuple of str
        Notes on samples that bristle resampled or left out, and on assumptions.
    kind : {"translational", "rotational"}
        Kind of axis.
    findings : tuple of Diagnostic
        Resampling with its error, and contradictions between names and units of columns.
    regressors : tuple of Channel
        Columns in their original units; an identified coefficient turns each into an effort.
    further : mapping of str to Channel
        Further channels by name, for your own slots.
    """

    @classmethod
    def from_columns(
        cls,
        columns: Any,
        *,
        axis: Axis | None = None,
        kind: str | None = None,
        sample_time: Any = None,
    ) -> Log:
        """Return the log in a data frame, a data set or a dictionary of arrays.

        The data are checked like a file by `read_log`: bristle refuses missing or saturated samples, resamples small jitter of
        the time, and splits the log at gaps.

        Parameters
        ----------
        columns : mapping, or a table of pandas, polars, xarray, pyarrow or numpy
            Columns called ``time``, ``position`` and ``effort``, and optionally ``velocity``, ``reference``, ``load``,
            ``temperature``, ``load_position`` (second encoder), ``coupling_effort`` (sensor of torque or force between motor and
            load) and ``injected.NAME``, in SI; other columns are ignored.
            Without a position, bristle integrates the velocity. The index of a frame can be the time, also as dates. Units
            stated by a column (``attrs["units"]``) are converted.
        axis : Axis, optional
            Names, units and signs of the columns, if they differ from those above.
        kind : {"translational", "rotational"}, optional
            Kind of axis; by default that of the axis or of the unit of the position, else translational.
        sample_time : float or str, optional
            Time between samples [s], if there is no time column.

        Returns
        -------
        Log
            All channels, each with unit and source column.

        Raises
        ------
        InputError
            If a column is missing, has no numbers, has a wrong unit, or is not finite, constant or saturated, or if time is
            uneven; the error names the column and the sample.

        Examples
        --------
        >>> import numpy as np
        >>> t = np.arange(200) * 1e-3
        >>> log = Log.from_columns({"time": t, "position": 0.01 * np.sin(9 * t), "effort": 5 * np.cos(9 * t)})
        >>> len(log), log.position.unit, log.sample_time
        (200, 'm', 0.001)
        """
        return log_of(record_of_columns(columns, axis=axis, kind=kind, sample_time=sample_time))

    def plot(self) -> Figure:
        """Return position [m or rad], velocity [m/s or rad/s] and effort [N or N*m] over time as a matplotlib figure."""
        return of_upper_layer("bristle.report.figures", "log_over_time")(self)


def log_of(record: LogData) -> Log:
    """Return the data as a `Log`."""
    return Log(**{field.name: getattr(record, field.name) for field in fields(LogData)})
