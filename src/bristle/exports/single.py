"""Single precision: the constants of kernels that belong to double precision, and what stands there instead.

A kernel splits pi and ln 2 into parts short enough for exact products, rounds by adding a large number, and stops its
searches by tolerances; each is a property of the arithmetic. Everything else of a kernel stays.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bristle.core import mathematics
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.friction import deflection, slip_law
from bristle.friction.maxwell_stribeck import BEYOND
from bristle.hysteresis import everett

__all__ = ["CHECKPOINT", "CONSTANTS", "TOLERANCE", "checkpoints", "refuse_beyond_single", "refuse_parameters_beyond_single", "single_note"]

TOLERANCE = 1e-3
"""How far the output may be off that of double precision, over the largest one, in the self-test."""
CHECKPOINT = 25
"""Steps between two outputs that single precision is compared with."""

_OF_MATHEMATICS = {
    "EXP_MAX": 88.0,
    "EXP_OF_MAX": 1.6516362549940018e38,
    "EXP_MIN": -87.0,
    "ROUNDER": 12582912.0,
    # ln 2 and half pi in parts of a few bits, and what is left.
    "LN2_HIGH": 0.693359375,
    "LN2_LOW": -2.1219444005469057e-04,
    "HALF_PI_1": 1.5703125,
    "HALF_PI_2": 4.837512969970703e-04,
    "HALF_PI_3": 7.54978941586159635e-08,
    "HALF_PI_4": 5.390302529957764e-15,
    "NORMAL_MIN": 1.1754943508222875e-38,
    "LOG_OF_MIN": -87.33654475055310,
    "LARGEST": 3.4028234663852886e38,
    "ANGLE_MAX": 5e3,
    "ANGLE_WITHOUT_DIGITS": 1e6,
    "TANH_MAX": 10.0,
}

CONSTANTS: dict[tuple[str, float], float] = {
    **{(name, getattr(mathematics, name)): value for name, value in _OF_MATHEMATICS.items()},
    ("RELATIVE", deflection.RELATIVE): 1e-5,
    ("OF_SLIDING", deflection.OF_SLIDING): 1e-5,
    ("TOLERANCE", deflection.TOLERANCE): 1e-7,
    ("SHORTEST", deflection.SHORTEST): 1e-30,
    ("TOLERANCE", slip_law.TOLERANCE): 1e-5,
    ("BEYOND", BEYOND): 1e18,
    ("FAR", everett.FAR): 1e18,
}
"""By the name of a constant and its value in double precision."""


def single_note(output: str) -> str:
    """Return what is told of an export in single precision."""
    return f"single precision: not the bits of bristle; the self-test allows {TOLERANCE:g} of the largest {output}"


def refuse_beyond_single(model: Model) -> None:
    """Refuse a model with a finite value that single precision does not hold."""
    for name, value in model.values.items():
        _refuse_beyond(name, value)


def refuse_parameters_beyond_single(parameters: Any, path: str = "") -> None:
    """Refuse parameters of a control law, tuples in one another, with a finite number that single precision lacks."""
    for name, value in zip(parameters._fields, parameters, strict=True):
        if hasattr(value, "_fields"):
            refuse_parameters_beyond_single(value, f"{path}{name}.")
        else:
            _refuse_beyond(f"{path}{name}", value)


def _refuse_beyond(path: str, value: Any) -> None:
    largest = float(np.finfo(np.float32).max)
    numbers = np.abs(np.atleast_1d(value)).astype(float) if not isinstance(value, str) else np.zeros(1)
    if np.any(np.isfinite(numbers) & (numbers > largest)):
        raise InputError(
            "is larger than any number of single precision",
            path=path,
            value=float(np.max(numbers)),
            allowed=f"<= {largest:.3g}",
            mend="Leave float32 out",
        )


def checkpoints(outputs: np.ndarray, *, single: bool) -> dict[str, Any]:
    """Return what a self-test in single precision compares with; nothing of it for double precision."""
    return {
        "every": CHECKPOINT,
        "tolerance": repr(TOLERANCE) if single else "",
        "largest": repr(float(np.max(np.abs(outputs)))),
        "checkpoints": [repr(output) for output in outputs[::CHECKPOINT].tolist()],
    }
