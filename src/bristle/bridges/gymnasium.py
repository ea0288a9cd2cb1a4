r"""An axis with friction as an environment of Gymnasium: position tracking, with a model drawn anew at each reset.

The reference is :math:`r(t) = A \sin(2\pi f t + \varphi)`, with frequency and phase drawn at each reset. The reward of a sample is
:math:`-|r - x| / A`.
"""

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import numpy as np

from bristle.core import Amount, InputError, MissingExtraError, Model, Variable, amount
from bristle.engine import system_of

try:
    gymnasium: Any = import_module("gymnasium")  # without the library, a type checker takes this file for it
except ImportError as error:
    raise MissingExtraError.of("an environment of Gymnasium", "gymnasium") from error

FREQUENCY = amount(Variable("frequency", "largest frequency", min=0.0), exclusive=True)
DURATION = amount(Variable("time", "duration", min=0.0), exclusive=True)
LIMIT = 100.0  # of an observation


class AxisEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """An axis with friction that follows a sinusoid.

    The action is the effort divided by `effort`, from -1 to 1, constant over a sample. The observation has four numbers,
    each limited to 100: the position error :math:`r - x` and the reference over `amplitude`, and the velocities of axis
    and reference over the largest velocity of the reference. The episode is truncated after `duration`. The axis starts
    at rest at position 0, with a virgin contact.

    Parameters
    ----------
    friction, plant : Model
        Models of friction and plant, such as ``model`` and ``plant`` of an identification.
    draws : mapping of str to array_like, shape (draw,) or (draw, element), optional
        Values of parameters of friction and plant [SI], such as ``draws`` of an identification. Each reset uses one
        row (domain randomisation). Other parameters keep their values.
    dt : float or str
        Sample time [s].
    amplitude, effort : float or str
        Amplitude of the reference [m or rad], and the largest effort [N or N*m].
    frequency : float or str
        Largest frequency of the reference [Hz]; the smallest is a tenth of it.
    duration : float or str
        Duration of an episode [s].

    Raises
    ------
    InputError
        If an argument is invalid, or `draws` have different lengths or no parameter of the models.
    MissingExtraError
        If Gymnasium is not installed.

    Examples
    --------
    >>> from bristle import friction, plants
    >>> lugre = friction.lugre(F_C="20 N", F_S="28 N", v_S="2 mm/s", sigma_0="10 N/um", sigma_1="1 kN*s/m")
    >>> axis = AxisEnv(lugre, plants.inertia(M="28 kg"), draws={"F_C": [18.0, 22.0], "M": [27.0, 29.0]})
    >>> observation, info = axis.reset(seed=1)
    >>> info["parameters"]
    {'F_C': 18.0, 'M': 27.0}
    >>> observation, reward, terminated, truncated, info = axis.step(np.array([0.5], np.float32))
    >>> bool(-1.0 < reward <= 0.0)
    True
    """

    def __init__(
        self,
        friction: Model,
        plant: Model,
        draws: Mapping[str, Any] | None = None,
        *,
        dt: Amount = "1 ms",
        amplitude: Amount = 0.01,
        effort: Amount = 100.0,
        frequency: Amount = 2.0,
        duration: Amount = 2.0,
    ) -> None:
        self._models = friction, plant
        kind = friction.kind
        self._dt = system_of(friction, plant, dt, 1, None, asked_by="AxisEnv").dt
        self._amplitude = _positive("amplitude", "length", amplitude, kind)
        self._effort = _positive("effort", "force", effort, kind)
        self._frequency = FREQUENCY(frequency, "frequency", None)
        self._samples = max(1, round(DURATION(duration, "duration", None) / self._dt))
        values = {**friction.values, **plant.values}
        self._draws = {name: np.asarray(rows, dtype=float) for name, rows in (draws or {}).items() if name in values}
        if draws is not None and len({len(rows) for rows in self._draws.values()}) != 1:
            allowed = f"values of {', '.join(values)}, of equal length"
            raise InputError("must have as many values of each parameter", path="draws", value=list(draws), allowed=allowed)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float32)
        self.observation_space = gymnasium.spaces.Box(-LIMIT, LIMIT, (4,), np.float64)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode with a drawn model and a drawn reference."""
        super().reset(seed=seed)
        drawn: dict[str, Any] = {}
        if self._draws:
            row = self.np_random.integers(len(next(iter(self._draws.values()))))
            drawn = {name: rows[row].tolist() for name, rows in self._draws.items()}
        friction, plant = (
            model.with_values(**{name: value for name, value in drawn.items() if name in model.values}) for model in self._models
        )
        self._axis = system_of(friction, plant, self._dt, 1, None, asked_by="AxisEnv")
        self._state, self._sample = np.zeros(len(self._axis.states)), 0
        self._omega = 2.0 * np.pi * self._frequency * self.np_random.uniform(0.1, 1.0)
        self._phase = self.np_random.uniform(0.0, 2.0 * np.pi)
        return self._observation(), {"parameters": drawn}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Advance the axis by one sample under an effort."""
        u = (self._effort * float(np.clip(action[0], -1.0, 1.0)),)
        force = float(self._axis.output(0.0, self._state, u, None)[-1])
        self._state, self._sample = self._axis.following(0.0, self._state, u, None), self._sample + 1
        observation = self._observation()
        return observation, -abs(float(observation[0])), False, self._sample >= self._samples, {"friction": force}

    def _observation(self) -> np.ndarray:
        angle = self._omega * self._sample * self._dt + self._phase
        x, v = self._state[:2]
        reference, fastest = np.sin(angle), self._amplitude * self._omega
        return np.clip([reference - x / self._amplitude, reference, v / fastest, np.cos(angle)], -LIMIT, LIMIT)


def _positive(name: str, quantity: str, value: Amount, kind: str) -> float:
    """Return a positive amount in SI."""
    return amount(Variable(quantity, name, min=0.0), exclusive=True)(value, name, kind)
