"""An axis with friction as an environment of Gymnasium: it tracks sinusoids, with a drawn model.

Needs Gymnasium and python-control. An identification has a model, a plant and draws for AxisEnv.
"""

import gymnasium
import numpy as np

from bristle.apps.targets import to_control

DT, AMPLITUDE, EFFORT = 1e-3, 0.01, 100.0  # sample time [s], reference [m], largest effort [N]


class AxisEnv(gymnasium.Env):
    """Takes effort / EFFORT; shows error, reference, and velocities of axis and reference."""

    action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float32)
    observation_space = gymnasium.spaces.Box(-100.0, 100.0, (4,), np.float64)

    def __init__(self, friction, plant, draws):
        self.models, self.draws = (friction, plant), draws

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        row = self.np_random.integers(min(map(len, self.draws.values())))
        drawn = {name: rows[row] for name, rows in self.draws.items()}
        axis = (m.with_values(**{k: drawn[k] for k in drawn if k in m.values}) for m in self.models)
        self.axis = to_control(*axis, dt=DT)
        self.state, self.time = np.zeros(self.axis.nstates), 0.0
        self.omega = self.np_random.uniform(1.0, 12.0)  # of the reference [rad/s]
        return self.seen(), {"parameters": drawn}

    def step(self, action):
        self.state = self.axis.dynamics(0.0, self.state, EFFORT * action.astype(float))
        self.time += DT
        return self.seen(), -abs(self.seen()[0]), False, False, {}

    def seen(self):
        angle, (x, v) = self.omega * self.time, self.state[:2] / AMPLITUDE
        return np.clip([np.sin(angle) - x, np.sin(angle), v / self.omega, np.cos(angle)], -100, 100)
