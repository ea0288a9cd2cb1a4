"""`Log`: what was recorded of a motion axis, each channel with its unit and the column it came from."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from bristle.core.axis import Axis
from bristle.core.edge import guarded
from bristle.logs.channel import CHANNELS, Channel, LogData  # noqa: F401  (asked for here)
from bristle.logs.columns import record_of_columns


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
