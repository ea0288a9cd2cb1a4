"""A model of a user's own with a quantity that no other model has is identified like any other."""

from pathlib import Path

import numpy as np
import pytest
from tests.identification.known_logs import Motion, log_of, sines

from bristle.files import load_model_file
from bristle.identification import identify

OWN = load_model_file(Path(__file__).parents[2] / "examples" / "quadratic_drag.py")
TRUTH = {"M": 12.0, "F_C": 8.0, "F_q": 40.0}


@pytest.mark.parametrize(("length", "force", "kind"), [(1.0, 1.0, "translational"), (2.0**-20, 2.0**9, "translational"),
                                                       (2.0**11, 2.0**-12, "rotational")])  # fmt: skip
def test_the_coefficient_of_a_drag_is_found_whatever_its_magnitude(length, force, kind):
    moved = sines()
    drag = TRUTH["F_q"] * moved.velocity * np.abs(moved.velocity)
    effort = TRUTH["M"] * moved.acceleration + TRUTH["F_C"] * np.sign(moved.velocity) + drag
    effort += np.random.default_rng(3).normal(0.0, 0.1, effort.size)
    motion = Motion(moved.time, length * moved.position, length * moved.velocity, length * moved.acceleration)
    best = identify(log_of(motion, force * effort, kind=kind), OWN, blocks=0, draws=0).best
    found = best.parameters["F_q"]
    assert found.status == "identified"
    assert found.value == pytest.approx(TRUTH["F_q"] * force / length**2, rel=0.02)
    assert found.unit == {"translational": "N*s^2/m^2", "rotational": "N*m*s^2/rad^2"}[kind]
