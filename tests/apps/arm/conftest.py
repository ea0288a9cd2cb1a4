"""Arms with known bodies: a double pendulum in closed form, and chains of Pinocchio where it is installed."""

from __future__ import annotations

import numpy as np
import pytest

from bristle.apps.arm.motion import Motion
from bristle.apps.arm.robot import OF_BODY

GRAVITY = 9.81
DT = 0.005


class Pendulum:
    """A link that turns about a horizontal axis: the effort is I_zz a + g (mc_x sin q + mc_y cos q)."""

    names = ("hinge",)

    def __init__(self, mass=5.0):
        self.prior = np.array([[mass, 0.0, 0.0, 0.0, 0.5, 0.0, 0.5, 0.0, 0.0, 0.5]])

    def regressor(self, q, v, a):
        columns = np.zeros((len(q), 1, 10))
        columns[:, 0, OF_BODY.index("I_zz")] = a[:, 0]
        columns[:, 0, OF_BODY.index("mc_x")] = GRAVITY * np.sin(q[:, 0])
        columns[:, 0, OF_BODY.index("mc_y")] = GRAVITY * np.cos(q[:, 0])
        return columns


def swing(count, seconds, seed=0, amplitude=0.8):
    """Return time and smooth random motions of some joints, (sample, joint) each, with exact derivatives."""
    rng, t = np.random.default_rng(seed), np.arange(0.0, seconds, DT)
    q, v, a = np.zeros((3, t.size, count))
    for joint in range(count):
        for frequency in rng.uniform(0.1, 0.8, 5):
            phase, size, w = (
                rng.uniform(0.0, 2 * np.pi),
                amplitude * rng.uniform(0.1, 0.5),
                2 * np.pi * frequency,
            )
            q[:, joint] += size * np.sin(w * t + phase)
            v[:, joint] += size * w * np.cos(w * t + phase)
            a[:, joint] -= size * w**2 * np.sin(w * t + phase)
    return t, q, v, a


def motion_with(effort, t, q, v, a, step=4):
    return Motion(t, q, v, a, effort, step)


@pytest.fixture
def pin():
    return pytest.importorskip(
        "pinocchio", reason="the dynamics of an arm need pip install bristle[arm]"
    )
