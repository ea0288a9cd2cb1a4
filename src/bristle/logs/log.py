"""`Log`: what was recorded of a motion axis, each channel with its unit and the column it came from; logs from data frames and arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core import units
from bristle.core.axis import CHANNELS, Axis, Column, Injected
from bristle.core.edge import KIND, amount, guarded, instance, optional
from bristle.core.errors import InputError, did_you_mean, told_by
from bristle.core.values import shown
from bristle.core.variable import KINDS, Variable, unit_of
from bristle.logs.assembly import record_of
from bristle.logs.channel import Channel, LogData  # noqa: F401  (asked for here)
from bristle.logs.table import USUAL_NAMES, Table, some_of

# What a log cannot do without may be called otherwise; of the rest any letter may stand for something else.
NAMES = {name: (USUAL_NAMES[name] if name in ("time", "position", "effort") else (name,)) for name in CHANNELS}
KNOWN_INPUT = "injected."
PLACE = "columns"
SOURCE = Path("<columns>")
MEND = 'Give a data frame or a dictionary with the columns "time", "position" and "effort"'


@guarded(
    axis=optional(instance(Axis, "an axis")),
    kind=optional(KIND),
    sample_time=optional(amount(Variable("time", "time between samples", min=0.0), exclusive=True)),
    columns=lambda columns, path, kind: table_of(columns),
)
def record_of_columns(columns: Any, *, axis: Axis | None = None, kind: Any = None, sample_time: Any = None) -> LogData:
    """Return what was recorded in a table of columns; `Log.from_columns` tells more."""
    by_name, table = axis is None or not axis.columns, columns
    used = axis or Axis()
    if axis is None and kind:
        used = Axis(kind=kind)
    elif axis is None:
        position = _named(table.names, "position")
        name, base = (position, "rad") if position else (_named(table.names, "velocity"), "rad/s")
        unit = table.units.get(name or "", "")
        used = Axis(kind=KINDS[1] if unit and units.compatible(unit, base, path=str(SOURCE)) else KINDS[0])
    if by_name:
        used = _axis_of(table, used)
        table = replace(table, notes=tuple(_notes_on(table, used)))
    if kind is not None and used.kind != kind:
        raise InputError("is not that of the axis", path="kind", value=kind, allowed=used.kind)
    record = record_of(table, used if sample_time is None else replace(used, sample_time=sample_time))
    renamed = (replace(channel, column=channel.column.removeprefix(KNOWN_INPUT)) for channel in record.injected)
    return replace(record, injected=tuple(renamed)) if by_name else record


def is_table(source: Any) -> bool:
    """Return whether something is a dictionary, a data frame, a data set or an array with named fields."""
    try:
        named = getattr(getattr(source, "dtype", None), "names", None)
        frame = any(hasattr(source, name) for name in ("columns", "column_names", "variables", "collect_schema"))
        return isinstance(source, Mapping) or bool(named) or (frame and hasattr(source, "__getitem__"))
    except Exception:  # noqa: BLE001  (an object that stops when it is asked what it has is no table)
        return False


def table_of(source: Any) -> Table:
    """Return the columns of numbers in a data frame, a data set, a record array or a mapping."""
    stated, series = _columns_of(source)
    texts: dict[str, InputError] = {}
    columns: dict[str, np.ndarray] = {}
    stated_units: dict[str, str] = {name: str(unit) for name, unit in stated.items() if isinstance(unit, str)}
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
    """Return the units that a table says of all its columns, and the columns by name."""
    if callable(collect := getattr(source, "collect", None)):  # a frame that was only asked for so far
        source = collect()
    attributes = getattr(source, "attrs", None)
    stated = attributes.get("units", {}) if isinstance(attributes, Mapping) else {}
    is_mapping = isinstance(source, Mapping)
    names = getattr(getattr(source, "dtype", None), "names", None)  # an array with named fields
    for attribute in ("variables",) if is_mapping else ("column_names", "columns"):  # xarray; pyarrow; pandas and polars
        names = names or getattr(source, attribute, None)
    if names is None and is_mapping:
        names = list(source)
    if names is None or isinstance(names, str) or not hasattr(source, "__getitem__"):
        raise InputError("is no table of columns", path=PLACE, value=shown(source), mend=MEND)
    series = {str(name): source[name] for name in names}
    index = getattr(source, "index", None)
    if index is not None and not callable(index) and not set(NAMES["time"]) & {name.lower() for name in series}:
        dates = getattr(getattr(index, "dtype", None), "kind", "") in ("M", "m")
        series |= {"time": index} if dates or str(getattr(index, "name", "")).lower() in NAMES["time"] else {}
    return stated if isinstance(stated, Mapping) else {}, series


def _numbers(values: Any, name: str) -> np.ndarray:
    """Return a column as numbers; dates as seconds from the first."""
    place = f"{SOURCE}: column {name!r}"
    if np.ma.is_masked(values):
        raise InputError("has masked values", path=place, mend="Fill them, or delete their rows: a gap is understood")
    to_numpy: Callable[[], Any] | None = getattr(values, "to_numpy", None)
    samples = np.asarray(to_numpy() if to_numpy is not None else getattr(values, "magnitude", values))
    if samples.ndim != 1:
        raise InputError("must be 1-D", path=place, value=f"an array of shape {samples.shape}", mend="Give each signal a column of its own")
    if samples.dtype.kind in "mM":
        return (samples - samples[:1]) / np.timedelta64(1, "s")
    if samples.dtype.kind not in "fiubO":
        raise InputError("holds no numbers", path=place, value=samples[0] if samples.size else None)
    try:
        return samples.astype(float)
    except (TypeError, ValueError) as error:
        at = next((i for i, sample in enumerate(samples) if not _is_number(sample)), 0)
        mend = "Repair these samples or delete their rows: a gap in time is understood"
        raise InputError(f"holds no number at sample {at} ({told_by(error)})", path=place, value=samples[at], mend=mend) from None


def _is_number(sample: Any) -> bool:
    try:
        np.array([sample], dtype=object).astype(float)
    except (TypeError, ValueError):
        return False
    return True


def _named(names: Iterable[str], channel: str) -> str | None:
    """Return the column that is called as a channel: by its name first, then as it usually is."""
    columns = list(names)
    spelt = {name.lower(): name for name in reversed(columns)} | {name: name for name in columns}
    return next((spelt[usual] for usual in NAMES[channel] if usual in spelt), None)


def _notes_on(table: Table, axis: Axis) -> Iterator[str]:
    """Yield what is to be known of the choice of columns."""
    named = {channel: column.name for channel, column in axis.columns.items()}
    yield from (f"column {name} is taken as the {channel}" for channel, name in named.items() if name != channel)
    used = {*named.values(), *(beside.column for beside in (*axis.injected, *axis.regressors))}
    left = [name for name in (*table.names, *table.texts) if name not in used]
    if left:
        yield f"columns that are not used: {some_of(left)}"


def _axis_of(table: Table, axis: Axis) -> Axis:
    """Return the axis with the columns of a table that are called as channels are, in SI unless they say otherwise."""
    columns = {}
    for channel, quantity in CHANNELS.items():
        name, base = _named((*table.names, *table.texts), channel), unit_of(quantity, axis.kind)
        if name is not None and name in table.texts:
            raise table.texts[name]
        if name is not None:
            columns[channel] = Column(name, table.units.get(name, base), base)
    if not {"position", "velocity"} & set(columns):
        hints = filter(None, (did_you_mean(name, NAMES["position"]) for name in table.names))
        mend, present = next(hints, "Rename it to position, or give an axis"), some_of(table.names, 40) or "no columns"
        raise InputError("has no column of the position", path=PLACE, value=present, allowed=", ".join(CHANNELS), mend=mend)
    injected = tuple(Injected(name, 1.0) for name in table.names if name.startswith(KNOWN_INPUT))
    return replace(axis, columns=columns, injected=injected)


@guarded()
@dataclass(frozen=True, eq=False)
class Log(LogData):
    """What was recorded of a motion axis, in SI of its kind, on a uniform grid of time.

    Made by `read_log` from a file, by `Log.from_columns` from a data frame or a dictionary, which look at what they
    find; or from arrays that are taken as they are: ``Log(time=t, position=x, effort=u)``.

    Parameters
    ----------
    time : Channel or array_like, shape (sample_count,)
        Time [s]. Uniform within a segment. Here and below numbers without a channel are in SI.
    position : Channel or array_like
        Position [m or rad].
    velocity : Channel or None
        Velocity [m/s or rad/s]; None where not recorded, as those below.
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
        Time between samples [s]; 0 stands for that of `time`.
    segments : tuple of slice
        Stretches without a gap; a derivative or a filter must not reach over their ends. All in one where not given.
    source : Path
        The file.
    origin : Origin
        Name and SHA-256 of the file, and the table in it.
    notes : tuple of str
        What was resampled, left out or assumed.
    kind : {"translational", "rotational"}
        Kind of axis.
    findings : tuple of Diagnostic
        What was resampled, and the error that makes; what names and units of columns say against each other.
    regressors : tuple of Channel
        Columns that an identified coefficient makes efforts of, in their own units.
    further : mapping of str to Channel
        Further channels, for slots of your own, by name.
    """

    @classmethod
    def from_columns(cls, columns: Any, *, axis: Axis | None = None, kind: str | None = None, sample_time: Any = None) -> Log:
        """Return the log in a data frame, a data set or a dictionary of arrays.

        What is found is looked at as `read_log` looks at a file: a log is refused for samples that are missing or
        saturated, small jitter of the time is resampled away, gaps split it.

        Parameters
        ----------
        columns : mapping, or a table of pandas, polars, xarray, pyarrow or numpy
            Columns called ``time``, ``position`` and ``effort``, and where there are any ``velocity``, ``reference``,
            ``load``, ``temperature`` and ``injected.NAME``, in SI; others are left alone. Without a position it is the
            integral of the velocity. Time may be the index of a frame, and be dates. A unit that a column says itself
            (``attrs["units"]``) is converted from.
        axis : Axis, optional
            Which columns are which, in what units and signs, where they are called otherwise.
        kind : {"translational", "rotational"}, optional
            Kind of axis; told from the axis or the unit of the position where not given, else translational.
        sample_time : float or str, optional
            Time between samples [s], where there is no column of time.

        Returns
        -------
        Log
            All channels, each with unit and source column.

        Raises
        ------
        InputError
            If a column is missing, holds no numbers, is of the wrong unit, not finite, constant or saturated, or time
            is not even; it names the column and the sample.

        Examples
        --------
        >>> import numpy as np
        >>> t = np.arange(200) * 1e-3
        >>> log = Log.from_columns({"time": t, "position": 0.01 * np.sin(9 * t), "effort": 5 * np.cos(9 * t)})
        >>> len(log), log.position.unit, log.sample_time
        (200, 'm', 0.001)
        """
        return log_of(record_of_columns(columns, axis=axis, kind=kind, sample_time=sample_time))


def log_of(record: LogData) -> Log:
    """Return what was recorded as a log."""
    return Log(**{field.name: getattr(record, field.name) for field in fields(LogData)})
