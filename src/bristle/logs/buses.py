"""Lines of frames of a bus, as ``candump`` writes them: bytes by address, in which no signal has a name."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from bristle.core.errors import InputError

__all__ = ["refuse_frames"]

_STAMP = r"(?:\((?:\d{4}-\d\d-\d\d[ T])?[\d:.]+\)\s+)?"
# ``(1436509052.249713) vcan0 044#2A366C2BBA``, as -L writes it, and ``vcan0  123   [8]  11 22 ...`` for the eye.
_FRAME = re.compile(
    rf"\s*{_STAMP}\w+\s+(?:(?:RX|TX)\s+(?:[-\w]+\s+)*)?"
    r"[0-9A-Fa-f]{3,8}(?:#[0-9A-Fa-fR]*|##[0-9A-Fa-f]+|\s+\[\d+\](?:\s+[0-9A-Fa-f]{2})*.*)(?:\s+[RT])?\s*"
)
LOOKED_AT = 20
ENOUGH = 0.8  # of the lines looked at


def refuse_frames(lines: Sequence[str], source: Path) -> None:
    """Refuse a log of a CAN bus: what its bytes mean stands in another file."""
    filled = [line for line in lines if line.strip()][:LOOKED_AT]
    if filled and sum(bool(_FRAME.fullmatch(line)) for line in filled) >= ENOUGH * len(filled):
        raise InputError(
            "is a log of a CAN bus (candump): frames of bytes, and no signals",
            path=str(source),
            mend="Decode it with the DBC file of the bus, and export position and effort as CSV or MF4, as cantools or asammdf do",
        )
