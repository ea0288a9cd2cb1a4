"""Friction by load and speed: numbers of a geared arm (Menagerie pull request 317), with `stribeck+transmitted`."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from bristle.engine.motion import along
from bristle.friction import find

SPEEDS = (0.06, 0.115, 0.275)  # [rad/s], in the middle of 0.04 to 0.08, 0.08 to 0.15, 0.15 to 0.4
LOAD = 9.5  # [N*m]: "more than 9"
PUBLISHED = np.array([2.85, 2.1, 1.4, 0.7, 0.65])  # [N*m]: break-away (2.4 to 3.3), sliding at these speeds, sliding without load


def numbers(logarithms):
    level, fall, v_S, damping, per_load = np.exp(logarithms)
    values = {"F_C": level, "F_S": level + fall, "v_S": v_S, "F_v": damping, "c_T": per_load}
    model = find("stribeck+transmitted")(kind="rotational", offset=0.0, **values)

    def force(speed, load):
        v = np.full(2, speed)
        return float(along(model, dt=1e-3, v=v, x=np.zeros(2), transmitted=load)[-1])

    return np.array([force(1e-6, LOAD), *(force(speed, LOAD) for speed in SPEEDS), force(SPEEDS[0], 0.0)])


def test_load_and_speed_together_give_the_published_numbers():
    start = np.log([0.2, 0.6, 0.1, 0.01, 0.05])
    found = least_squares(lambda p: numbers(p) / PUBLISHED - 1.0, start, bounds=(-9.0, 3.0)).x
    break_away, slow, middle, fast, unloaded = numbers(found)
    assert 2.4 <= break_away <= 3.3
    assert break_away / slow == pytest.approx(2.85 / 2.1, rel=0.2)
    assert (middle / slow, fast / slow) == pytest.approx((1.4 / 2.1, 0.7 / 2.1), rel=0.2)
    assert unloaded == pytest.approx(0.65, rel=0.2)
