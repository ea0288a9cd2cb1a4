"""`read_log` for people: a log and the axis file that explains it."""

from __future__ import annotations

from typing import Any

from bristle.core.axis import Axis
from bristle.core.content import SIZE_LIMIT, Readable, size_of
from bristle.logs import readers
from bristle.logs.log import Log

__all__ = ["read_log"]


def read_log(path: Readable, axis: Axis | Readable | dict[str, Any] | None = None, *, size_limit: int | str = SIZE_LIMIT) -> Log:
    """Return the log in a file, in SI of the axis, on a uniform grid of time.

    Parameters
    ----------
    path : path-like, bytes or file object
        A file of any format that ``bristle log --help`` names; ``FILE::TABLE`` names a table in it.
    axis : Axis, path-like or dict, optional
        The axis, or the file that describes it, or the tables that one would hold. Without it columns called as usual
        are taken, in the units that the log says.
    size_limit : int or str
        Largest file, and largest content that a file announces [byte], or text such as ``"2 GB"``.

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
    return readers.read_log(path, axis, size_limit=size_of(size_limit))
