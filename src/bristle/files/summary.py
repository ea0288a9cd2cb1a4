"""Results as JSON: one object, in which what is not a number is null."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from bristle.core.typography import escaped

__all__ = ["as_json", "plain"]


def as_json(data: Mapping[str, Any]) -> str:
    r"""Return data as the text of one JSON object, in ASCII, with a line end.

    Examples
    --------
    >>> print(as_json({"rms": float("nan"), "unit": "µm"}), end="")
    {
      "rms": null,
      "unit": "\u00b5m"
    }
    """
    return json.dumps(plain(data), indent=2, allow_nan=False) + "\n"


def plain(value: Any) -> Any:
    """Return a value as what JSON knows: text, finite numbers, lists, tables; None for what is no finite number."""
    if isinstance(value, Mapping):
        return {escaped(str(key)): plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):  # arrays and numbers of numpy
        return plain(value.tolist())
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value if isinstance(value, (int, bool)) or value is None else escaped(str(value))
