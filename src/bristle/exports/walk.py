"""The walk of the self-test: positions that every target makes itself, and a hash of the forces along it.

A few lines of whole numbers give the steps: small ones and large ones, of both signs, and some of length 0. The sum of
the steps has a product in each, so that a compiler which contracts ``a + b * c`` shows itself at once.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from bristle.core.contracts import Motion
from bristle.exports.subject import Subject

__all__ = [
    "COUNT",
    "FACTOR",
    "FNV_OFFSET",
    "FNV_PRIME",
    "RESTS",
    "SCALES",
    "SEED",
    "TERM",
    "Walk",
    "digest_of",
    "hash_of",
    "presliding_distance",
    "walk_of",
]

COUNT, SEED, FACTOR, TERM = 2000, 20260, 1664525, 1013904223
SCALES = (0.05, 0.5, 5.0, 50.0)
"""The longest steps of each part of the walk, over the distance at which pre-sliding ends."""
PART, RESTS = 125, 16  # steps of one scale on end; one step in so many has length 0
FNV_OFFSET, FNV_PRIME = 0xCBF29CE484222325, 0x100000001B3
FARTHEST = {False: 1.0, True: 1e6}  # input of an operator: a force of an inverse, a field of a magnet
USUAL, SLOW = 1e-6, 1e6  # distance of a model without pre-sliding [m or rad]; duration of a step without viscosity [s]


@dataclass(frozen=True)
class Walk:
    """Positions at equal time steps."""

    scales: tuple[float, ...]
    dt: float

    def positions(self, count: int = COUNT) -> np.ndarray:
        """Return the position at each sample [m or rad]; the first one is 0."""
        x = np.zeros(count)
        bits, at = SEED, 0.0
        for k in range(1, count):
            bits = (bits * FACTOR + TERM) % 2**32
            if (bits >> 8) % RESTS:
                at = at + ((bits >> 16) - 32768.0) * self.scales[(k // PART) % len(self.scales)]
            x[k] = at
        return x


def walk_of(subject: Subject, dt: float) -> Walk:
    """Return the walk that leads a model through its pre-sliding and far beyond."""
    reach = presliding_distance(subject)
    return Walk(tuple(scale * reach / 32768.0 for scale in SCALES), dt)


def hash_of(forces: Iterable[float]) -> int:
    """Return the hash of the bytes of some numbers, lowest byte first."""
    return digest_of(b"".join(struct.pack("<d", force) for force in forces))


def digest_of(content: bytes) -> int:
    """Return the 64-bit hash of Fowler, Noll and Vo (1a) of some bytes."""
    digest = FNV_OFFSET
    for byte in content:
        digest = ((digest ^ byte) * FNV_PRIME) % 2**64
    return digest


def presliding_distance(subject: Subject) -> float:
    """Return over which distance a virgin contact, moved slowly, reaches half of its largest force [m or rad]."""
    component, p, state = subject.model.component, subject.model.parameters, subject.virgin
    memory, forces, at = component.new_memory(p), [], 0.0
    farther = np.geomspace(1e-12, FARTHEST[subject.is_operator], 120)
    for x in farther.tolist():
        inputs = (x,) if subject.is_operator else (Motion((x - at) / SLOW, x), SLOW)
        force, move = component.trial(state, memory, *inputs, p)
        if not math.isfinite(force):
            break
        state, at = component.commit(state, memory, move, p), x
        forces.append(abs(force))
    reached = np.array(forces) >= 0.5 * max(forces)
    return float(farther[np.argmax(reached)]) if max(forces) > 0.0 and not reached[0] else USUAL
