"""Numbers for a page: compressed with deflate, in base 64, with few bytes for slowly changing values."""

import base64
import json
import math
import zlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def packed(content: bytes, before: bytes = b"") -> str:
    """Return bytes as text: raw deflate in base 64, with `before` as its dictionary."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -zlib.MAX_WBITS, zdict=before)
    return base64.b64encode(packer.compress(content) + packer.flush()).decode("ascii")


def unpacked(code: str) -> bytes:
    """Return the bytes of a text that was packed without a dictionary."""
    return zlib.decompress(base64.b64decode(code), -zlib.MAX_WBITS)


def differences(numbers: np.ndarray, times: int) -> np.ndarray:
    """Return the differences of whole numbers, of order `times`."""
    for _ in range(times):
        numbers = np.diff(numbers, prepend=0.0)
    return numbers


def packed_numbers(parts: Sequence[np.ndarray]) -> dict[str, Any]:
    """Return the whole numbers of all parts as text; numbers of small magnitude take few bytes."""
    numbers = np.concatenate([*parts, np.zeros(0)]).astype("<i8")
    folded = ((numbers << 1) ^ (numbers >> 63)).astype("<u4")
    planes = folded.view(np.uint8).reshape(-1, 4).T
    return {"code": packed(planes.tobytes()), "count": numbers.size}


def as_json(value: Any) -> str:
    """Return data for a page as JSON that cannot end the surrounding element."""
    return json.dumps(plain(value), allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def plain(value: Any) -> Any:
    """Return data with infinite numbers replaced by words that a script understands."""
    if isinstance(value, Mapping):
        return {key: plain(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(part) for part in value]
    if isinstance(value, float) and not math.isfinite(value):
        if value > 0.0:
            return "Infinity"
        return "-Infinity"
    return value
