"""FMUs for FMI 3.0."""

from __future__ import annotations

from bristle.exports.targets.fmu2 import target_of

__all__ = ["TARGET"]

TARGET = target_of(3)
