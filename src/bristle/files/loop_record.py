"""The loop of a log as a table beside an experiment file: its reference, and the force that the model leaves.

.. code-block:: text

    time [s],reference [m],unexplained [N]
    0,0.0125,-1.83

Where known inputs join the output of the controller, a column ``injected [N]`` follows.
"""

from __future__ import annotations

import io
from typing import NamedTuple

import numpy as np

from bristle.core.content import Content
from bristle.core.errors import InputError
from bristle.core.variable import Kind, unit_of

__all__ = ["LoopRecord", "holds_loop", "loop_text", "read_loop"]

FORMAT = "%.12g"
COLUMNS = 3
INJECTED = ",injected"
EVEN = 1e-6  # of a sample time: how far a step may be off


class LoopRecord(NamedTuple):
    """By sample: the desired motion of a log [m or rad], the force that no model explains, known inputs [N or N*m]."""

    kind: Kind
    sample_time: float
    reference: np.ndarray
    unexplained: np.ndarray
    injected: np.ndarray | None = None


def loop_text(record: LoopRecord) -> str:
    """Return the table as text."""
    out, time = io.StringIO(), record.sample_time * np.arange(record.reference.size)
    columns, header = [time, record.reference, record.unexplained], _header(record.kind)
    if record.injected is not None:
        columns, header = [*columns, record.injected], f"{header}{INJECTED} [{unit_of('force', record.kind)}]"
    np.savetxt(out, np.column_stack(columns), fmt=FORMAT, delimiter=",", header=header, comments="")
    return out.getvalue()


def holds_loop(content: Content) -> bool:
    """Return whether a file is such a table."""
    return _kind_of(content) is not None


def read_loop(content: Content) -> LoopRecord:
    """Return the table in a file."""
    kind = _kind_of(content)
    if kind is None:
        raise InputError(
            "is no loop of a log",
            value=content.source.name,
            allowed=_header("translational"),
            mend="Name the loop.csv that bristle identify wrote",
        )
    try:
        rows = np.loadtxt(io.BytesIO(content.data), delimiter=",", skiprows=1, ndmin=2)
    except ValueError as error:
        raise InputError(f"cannot be read: {error}", value=content.source.name) from None
    columns = COLUMNS + (INJECTED.encode() in content.data.partition(b"\n")[0])
    if rows.shape[0] < COLUMNS or rows.shape[1] != columns or not np.all(np.isfinite(rows)):
        raise InputError("needs a finite number in each column, and three rows", value=content.source.name)
    steps = np.diff(rows[:, 0])
    dt = float(np.mean(steps))
    if not dt > 0.0 or np.max(np.abs(steps - dt)) > EVEN * dt + 1e-11 * abs(rows[-1, 0]):
        raise InputError("has samples that are not evenly spaced", value=content.source.name)
    return LoopRecord(kind, dt, rows[:, 1], rows[:, 2], rows[:, COLUMNS] if columns > COLUMNS else None)


def _kind_of(content: Content) -> Kind | None:
    kinds: tuple[Kind, ...] = ("translational", "rotational")
    return next((kind for kind in kinds if content.data.startswith(_header(kind).encode())), None)


def _header(kind: Kind) -> str:
    return f"time [s],reference [{unit_of('length', kind)}],unexplained [{unit_of('force', kind)}]"
