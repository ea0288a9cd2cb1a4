"""Numbers for a page: deflated, in base 64, and few bytes of each where neighbours are alike."""

import base64
import json
import math
import zlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def packed(content: bytes, before: bytes = b"") -> str:
    """Return bytes as text: deflated, without a head, and in base 64; they may repeat what went before them."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -zlib.MAX_WBITS, zdict=before)
    return base64.b64encode(packer.compress(content) + packer.flush()).decode("ascii")


def unpacked(code: str) -> bytes:
    """Return the bytes of a text that nothing went before."""
    return zlib.decompress(base64.b64decode(code), -zlib.MAX_WBITS)


def differences(numbers: np.ndarray, times: int) -> np.ndarray:
    """Return whole numbers as what they differ by from the one before, so many times over."""
    for _ in range(times):
        numbers = np.diff(numbers, prepend=0.0)
    return numbers


def packed_numbers(parts: Sequence[np.ndarray]) -> dict[str, Any]:
    """Return whole numbers, one part after the other, as text: small ones of either sign take few bytes."""
    numbers = np.concatenate([*parts, np.zeros(0)]).astype("<i8")
    folded = ((numbers << 1) ^ (numbers >> 63)).astype("<u4")
    planes = folded.view(np.uint8).reshape(-1, 4).T
    return {"code": packed(planes.tobytes()), "count": numbers.size}


def as_json(value: Any) -> str:
    """Return data for a page; no text of it can end the element that it stands in."""
    return json.dumps(plain(value), allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def plain(value: Any) -> Any:
    """Return data in which numbers without an end are words that a script reads as such."""
    if isinstance(value, Mapping):
        return {key: plain(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(part) for part in value]
    if isinstance(value, float) and not math.isfinite(value):
        return "Infinity" if value > 0.0 else "-Infinity"
    return value
