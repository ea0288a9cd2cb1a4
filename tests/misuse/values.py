"""What people and strangers hand in by mistake."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np


def _refuse(*_: Any, **__: Any) -> Any:
    raise RuntimeError("hands off\nsaid the object")


class Hostile:
    """An object that raises whatever is asked of it."""

    __float__ = __int__ = __index__ = __array__ = __len__ = __iter__ = __bool__ = __eq__ = (
        __lt__
    ) = __le__ = _refuse
    __gt__ = __ge__ = __getitem__ = __repr__ = __str__ = _refuse
    __hash__ = None


class Evasive(Hostile):
    """One whose attributes raise, too."""

    def __getattr__(self, name: str) -> Any:
        raise RuntimeError("no such thing")


class Column:
    """What pandas and its like hand out: no array, but it can be made one."""

    def __init__(self, values: Any) -> None:
        self.values = np.asarray(values)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return self.values if dtype is None else self.values.astype(dtype)

    def __len__(self) -> int:
        return len(self.values)


# Wrong wherever they stand.
NEVER = {
    "object": object(),
    "hostile": Hostile(),
    "evasive": Evasive(),
    "complex": 1 + 1j,
    "set": {1, 2},
    "a class": int,
    "complex array": np.array([1j, 2j]),
    "list of hostile": [Hostile()],
    "three dimensions": np.ones((2, 2, 2)),
    "mixed array": np.array([None, 1], dtype=object),
    "decimal": Decimal("nan"),
}
# Wrong in most places, and right in some.
MOSTLY = {
    "None": None,
    "text": "x",
    "empty text": "",
    "another unit": "5 kg",
    "bytes": b"x",
    "NUL": "a\0b",
    "control characters": "a\nb\x1b[31m",
    "a path": Path("/nowhere/x"),
    "list": [],
    "dict": {},
    "list of text": ["a"],
    "ragged": [[1.0], [1.0, 2.0]],
    "list of a huge number": [10**5000],
    "list of infinity": [float("inf")],
    "array of text": np.array(["a", "b"]),
    "array with NaN": np.array([1.0, np.nan]),
    "matrix": np.ones((2, 2)),
    "array without dimensions": np.array(3.0),
    "NaN": float("nan"),
    "NaN of numpy": np.float64("nan"),
    "infinity": float("inf"),
    "minus infinity": float("-inf"),
    "beyond any range": 1e300,
    "5000 digits": 10**5000,
    "minus 5000 digits": -(10**5000),
    "a trillion million": 10**18,
    "the same": 1e18,
    "boolean": True,
    "zero": 0,
    "minus one": -1,
    "a half too much": 1.5,
    "five": 5,
}
