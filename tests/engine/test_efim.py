"""The solve of a step: how near it comes to the root of an equation that has one in closed form."""

from pathlib import Path

import numpy as np
import pytest

from bristle.engine import run_open_loop
from bristle.files.user_model import load_model_file
from bristle.plants import inertia

EXAMPLE = Path(__file__).parents[2] / "examples" / "quadratic_drag.py"


@pytest.mark.parametrize("v", [0.0, 0.3])
def test_the_force_of_a_step_is_found_to_a_billionth(v):
    # 2 M (w - v)/dt = u - F_C - F_q w^2 is a quadratic in the mean velocity w of the step.
    M, F_C, F_q, dt = 2.0, 1.5, 150.0, 0.05
    model = load_model_file(EXAMPLE)(F_C=F_C, F_q=F_q)
    for u in np.geomspace(4.0, 4000.0, 40):
        friction = run_open_loop(inertia(M=M), model, np.full(2, u), dt, v=v).friction[0]
        inert, drag = 2.0 * M / dt, F_q
        driven = inert * v + u - F_C
        w = 2.0 * driven / (inert + np.sqrt(inert**2 + 4.0 * drag * driven))
        assert friction == pytest.approx(driven + F_C - inert * w, rel=1e-9)
