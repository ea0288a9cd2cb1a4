"""Where nothing moves, a contact stays as it was: the one-sided limits differ in force, and in nothing that lasts."""

import numpy as np
import pytest

from bristle.engine import Contact
from bristle.engine.motion import compensation_along, follow
from bristle.models.controllers.feedforward import Shape
from bristle.models.friction import MODELS, find

pytestmark = pytest.mark.usefixtures("in_plain_python")

DT = 1e-3
NAMES = [
    *MODELS,
    "gms+asymmetry",
    "maxwell_stribeck+asymmetry",
    "maxwell_slip+asymmetry",
    "preisach_lugre+asymmetry",
]


def model_of(name):
    base, _, slot = name.partition("+")
    model = MODELS[base](**MODELS[base].example)
    if not slot:
        return model
    values = {}
    directional = {key for key, item in find(base).variables.items() if item.directional}
    for key, value in MODELS[base].example.items():
        if key in directional:
            values |= {f"{key}_pos": 1.1 * value, f"{key}_neg": 0.8 * value}
        else:
            values[key] = value
    return find(name)(**values)


def strokes(seed, speed=3.5):
    """Return velocities of strokes to and fro, the last one backward, from micrometres a second to millimetres."""
    generator = np.random.default_rng(seed)
    result = []
    for side in (1.0, -1.0) * 12:
        result += [side * 10.0 ** generator.uniform(-6.0, speed - 6.0)] * int(
            generator.integers(3, 25)
        )
    return np.array(result)


FAST = ("stribeck", "lugre", "maxwell_slip", "preisach_lugre", "gms+asymmetry")


@pytest.mark.parametrize("turned", [1.0, -1.0])
@pytest.mark.parametrize(
    "name", [name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in NAMES]
)
def test_both_limits_of_a_step_at_rest_leave_the_same_contact(name, turned):
    moving = Contact(model_of(name))
    for v in turned * strokes(1):
        largest = abs(moving.move(v * DT, abs(v))[0])
        item, other = moving.copy(), moving.copy()
        for contact, zero in ((item, 0.0), (other, -0.0)):
            follow(contact._part, contact._memory, np.full(2, zero), np.full(2, contact.x), DT)
        np.testing.assert_allclose(item.state, other.state, rtol=1e-14, atol=1e-14)
        np.testing.assert_allclose(item._memory, other._memory, rtol=1e-14, atol=1e-14 * largest)


@pytest.mark.parametrize(
    "name", [name for name in NAMES if "scatter" not in name and "+" not in name]
)
def test_feedforward_at_rest_is_mirrored_for_a_mirrored_motion(name):
    model = model_of(name)
    if "scatter" in model.values:
        model = model.with_values(scatter=0.0)
    v = np.concatenate([strokes(5), np.zeros(30), strokes(6), np.zeros(30)])
    x = DT * np.cumsum(v)
    fed, mirrored = (
        compensation_along(model, Shape(), side * v, DT, side * x) for side in (1.0, -1.0)
    )
    np.testing.assert_allclose(mirrored, -fed, atol=1e-11 * np.max(np.abs(fed)))
