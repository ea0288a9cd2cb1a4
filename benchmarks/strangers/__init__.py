"""Servo axes made by a stranger: true values, the loop that moves them, and what its drive records. See `draw.make`."""

from __future__ import annotations

from benchmarks.strangers.draw import draw, make
from benchmarks.strangers.habits import HABITS
from benchmarks.strangers.lies import LIES, Lied
from benchmarks.strangers.recording import Run, make_record, record_of, simulate
from benchmarks.strangers.truth import FAMILIES, MOTIONS, Record, Truth

__all__ = [
    "FAMILIES",
    "HABITS",
    "LIES",
    "MOTIONS",
    "Lied",
    "Record",
    "Run",
    "Truth",
    "draw",
    "make",
    "make_record",
    "record_of",
    "simulate",
]
