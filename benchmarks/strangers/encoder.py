"""The counter on the motor: the same function in the loop and in the record."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from benchmarks.strangers.truth import Encoder, Floats

__all__ = ["Scale", "counted", "read_out", "scale_of"]


class Scale(NamedTuple):
    """An encoder for compiled code. A resolution of zero stands for a perfect one."""

    resolution: float
    wave: float  # [rad per m or rad]: 2 pi / period
    a1: float  # [counts]
    a2: float
    a16: float
    p1: float
    p2: float
    p16: float


def scale_of(encoder: Encoder) -> Scale:
    return Scale(
        encoder.resolution, 2.0 * np.pi / encoder.period, *encoder.amplitudes, *encoder.phases
    )


@njit(cache=True)
def counted(q: float, s: Scale) -> float:
    """Return the position that the counter shows for a true one [m or rad]."""
    if s.resolution <= 0.0:
        return q
    x = s.wave * q
    off = s.a1 * np.sin(x + s.p1) + s.a2 * np.sin(2.0 * x + s.p2) + s.a16 * np.sin(16.0 * x + s.p16)
    return s.resolution * np.floor(q / s.resolution + off + 0.5)


@njit(cache=True)
def read_out(q: Floats, s: Scale) -> Floats:
    """Return what the counter shows for a row of true positions."""
    out = np.empty_like(q)
    for i in range(q.size):
        out[i] = counted(q[i], s)
    return out
