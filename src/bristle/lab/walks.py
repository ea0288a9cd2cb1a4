"""Walks that a page repeats to show that it computes what Python does: hashes of blocks of them.

Two for each model: the forces of its contact along positions, and the positions of a mass on a spring that is pushed
about against it. The kernels run as they stand; nothing is compiled.
"""

import json
import math
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.engine.mechanism import Mechanism, mechanism
from bristle.exports.subject import FACTOR, SEED, TERM, Subject, Walk, forces_of, hash_of, presliding_distance, subject_of, walk_of
from bristle.lab.sliders import Scales

STEP = 5e-4  # of the walk of a contact [s]
BLOCK = 1000
LONG, SHORT = (20 * BLOCK, 4 * BLOCK)  # steps of a model of the package, and of one that is walked while a page is written
PUSHED = 500
STEPS_WITH_SLOTS, TOGETHER = 500, 16  # steps with each set of slots: all lengths of steps once; sets in a block


def walked(subject: Subject, plant: Model, scales: Scales, count: int) -> dict[str, Any]:
    """Return the walks of a model, each with the hashes of its blocks."""
    walk = walk_of(subject, STEP)
    forces = subject.forces(walk.positions(count), STEP)
    # At this step the largest push moves a free mass by about the distance of pre-sliding.
    dt = math.sqrt(presliding_distance(subject) * plant.values["M"] / scales.force)
    push = 2.0 * scales.force / 32768.0
    places = _pushed(subject, plant, push, dt)
    return {
        "contact": {"scales": list(walk.scales), "dt": STEP, "count": count, "hashes": _hashes(forces)},
        "mass": {"push": push, "dt": dt, "count": PUSHED, "hashes": _hashes(places)},
    }


def walked_together(models: Sequence[Model], around: Sequence[float], walks: Mapping[str, Any], plant: Model) -> dict[str, Any]:
    """Return the walks of one contact with several sets of slots, and of the mass with the last of them."""
    contact, mass = walks["contact"], walks["mass"]
    positions = Walk(tuple(contact["scales"]), STEP).positions(STEPS_WITH_SLOTS)
    forces = [forces_of(model, positions, STEP, *around) for model in models]
    places = _pushed(subject_of(models[-1]), plant, mass["push"], mass["dt"])
    return {
        "count": STEPS_WITH_SLOTS,
        "together": TOGETHER,
        "hashes": _hashes(np.concatenate(forces), STEPS_WITH_SLOTS * TOGETHER),
        "mass": _hashes(places),
    }


@cache
def stored() -> dict[str, Any]:
    """Return the walks of the models of the package, with their examples, as they were computed for it."""
    return json.loads(resources.files("bristle.lab").joinpath("walks.json").read_text(encoding="utf-8"))


def _hashes(values: np.ndarray, block: int = BLOCK) -> list[str]:
    return [f"{hash_of(values[k : k + block].tolist()):016x}" for k in range(0, len(values), block)]


def _pushed(subject: Subject, plant: Model, push: float, dt: float) -> np.ndarray:
    """Return the positions of a mass that is pushed another way in every step."""
    p, q = subject.model.parameters, plant.parameters
    body = plant.component.initial_state(q)
    now = Mechanism(body, subject.virgin, 0.0, 0.0, 0.0, 0.0, 0.0)
    memory = subject.model.component.new_memory(p)
    x = np.zeros(PUSHED)
    bits = SEED
    for k in range(PUSHED):
        bits = (bits * FACTOR + TERM) % 2**32
        effort = ((bits >> 16) - 32768.0) * push
        after = mechanism(now, memory, effort, effort, 0.0, 0.0, dt, 1, q, p)
        # As an export keeps it: the effort of the drive with what the solve begins from.
        now = Mechanism(after.plant, after.friction, after.effort, after.slope, after.acceleration, 0.0, 0.0)
        x[k] = after.plant.x
    return x
