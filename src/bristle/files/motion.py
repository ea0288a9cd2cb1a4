"""A motion to run on an axis, as comma-separated values."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.variable import Kind, unit_of

__all__ = ["write_motion"]


def write_motion(path: str | os.PathLike[str], motion: Any, kind: Kind) -> None:
    """Write time, position, velocity and acceleration in SI, one sample a line, the units in the head.

    Parameters
    ----------
    path : path-like
        The file.
    motion : Motion
        The motion.
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    quantities = {name: "length" + per for name, per in (("position", ""), ("velocity", "/time"))}
    quantities["acceleration"] = "length/time^2"
    heads = ["time [s]", *(f"{name} [{unit_of(one, kind)}]" for name, one in quantities.items())]
    columns = np.column_stack([motion.time, *(getattr(motion, name) for name in quantities)])
    with Path(path).open("w", encoding="utf-8") as file:
        np.savetxt(file, columns, fmt="%.10g", delimiter=",", header=",".join(heads), comments="")
