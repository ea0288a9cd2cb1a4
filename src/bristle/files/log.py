"""`read_log` for people: a log and the axis file that explains it."""

from __future__ import annotations

import os

from bristle.core.axis import Axis
from bristle.logs import read
from bristle.logs.log import Log

__all__ = ["read_log"]


def read_log(path: str | os.PathLike[str], axis: Axis | str | os.PathLike[str] | None = None) -> Log:
    """Return the log in a file, in SI of the axis, on a uniform grid of time.

    Parameters
    ----------
    path : path-like
        CSV and other text, MAT, TDMS, Parquet, HDF5, or NPZ; ``FILE::TABLE`` names a table in it.
    axis : Axis or path-like, optional
        The axis, or the file that describes it. Without it columns called as usual are taken, in the units that
        the log says.

    Returns
    -------
    Log
        All channels, each with unit and source column.

    Raises
    ------
    InputError
        If the axis file or the log cannot be used; the message names file, key or column, and the mend.
    """
    if axis is not None and not isinstance(axis, Axis):
        from bristle.files.axis import read_axis

        axis = read_axis(axis)
    return read.read_log(path, axis)
