"""`read_log`: from a file and an axis to a log that can be used, or the reason why it cannot."""

from __future__ import annotations

from bristle.core.axis import Axis
from bristle.core.content import SIZE_LIMIT, Readable
from bristle.logs.assembly import record_of
from bristle.logs.choice import columns_of
from bristle.logs.gather import axis_of
from bristle.logs.log import Log, log_of
from bristle.logs.readers import read_table

__all__ = ["read_log"]


def read_log(given: Readable, axis: Axis | None = None, *, size_limit: int = SIZE_LIMIT) -> Log:
    """Return the log in a file, in SI of the axis, on a uniform grid of time.

    Parameters
    ----------
    given : path-like, bytes, file object or Content
        A file of any format that ``bristle log --help`` names; ``FILE::TABLE`` names a table in it.
    axis : Axis, optional
        Which columns are which, in what units and signs. Without it columns called as usual (``t``,
        ``position``, ``force``) are taken, in the units that the file says.
    size_limit : int
        Largest file, and largest content that a file announces [byte].

    Raises
    ------
    InputError
        If the file is truncated, a column is missing, of the wrong unit, not finite, constant or saturated,
        or time makes no order; it names the column and the sample.
    """
    table = read_table(given, axis and axis.table, choice=columns_of(axis), size_limit=size_limit)
    return log_of(record_of(table, axis or axis_of(table)))
