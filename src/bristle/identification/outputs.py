"""The signals of a log that a model simulates: the position of an open loop, the effort of a closed one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np

from bristle.core.contracts import Model
from bristle.friction import is_static, with_presliding
from bristle.identification.roles import offset_of
from bristle.sensors import encoder
from bristle.simulation.recorded.closed_loop import ClosedLoop
from bristle.simulation.recorded.open_loop import OpenLoop

__all__ = ["LAG", "Effort", "Output", "Position", "Reading"]

LAG = "lag"
SEEDS = 2**31


class Reading(NamedTuple):
    """How a position is read: step of the encoder, standard deviation of the noise before it [m or rad]."""

    resolution: float
    noise: float


class Output(Protocol):
    """A segment of a log that a model simulates: what was measured of it, and what the model says."""

    @property
    def measured(self) -> np.ndarray:
        """The signal, shape (sample,)."""
        ...

    @property
    def period(self) -> int:
        """Samples of its period, or of its log."""
        ...

    @property
    def phase(self) -> np.ndarray:
        """How far each sample is on its way through its period or its log, from 0 to 1."""
        ...

    @property
    def position(self) -> np.ndarray:
        """The position that was measured [m or rad], shape (sample,)."""
        ...

    def simulated(self, plant: Model, friction: Model, values: Mapping[str, float]) -> np.ndarray:
        """Return the signal of the model, NaN from where it left the finite numbers, shape (sample,)."""
        ...

    def rough(self, most: int) -> Output:
        """Return at most so many samples of it, as quickly simulated as can be."""
        ...

    def read(
        self, plant: Model, friction: Model, values: Mapping[str, float], pure: np.ndarray, push: np.ndarray,
        reading: Reading, rng: np.random.Generator,
    ) -> np.ndarray:  # fmt: skip
        """Return what a force that pushes against the motion and an encoder add to the `pure` signal.

        Nobody knows where the steps of the encoder lie.
        """
        ...

    def leaning(self, plant: Model, friction: Model, values: Mapping[str, float], slope: np.ndarray) -> np.ndarray:
        """Return what `read` takes for a push where friction is twice what it is, shape (sample,).

        `slope` is by how much the signal rises with the level of friction.
        """
        ...


@dataclass(frozen=True)
class Position:
    """The position [m or rad] that the recorded effort makes."""

    loop: OpenLoop
    measured: np.ndarray

    @property
    def position(self) -> np.ndarray:
        """The position that was measured [m or rad]."""
        return self.measured

    @property
    def period(self) -> int:
        """Samples until the effort is what it was."""
        return self.loop.effort.size // self.loop.steps

    @property
    def phase(self) -> np.ndarray:
        """How far each sample is on its way through its period."""
        return np.arange(self.loop.count) % self.period / self.period

    def simulated(self, plant: Model, friction: Model, values: Mapping[str, float]) -> np.ndarray:
        """Return the position of the model [m or rad]."""
        return self.loop.position(plant, friction)[0]

    def rough(self, most: int) -> Position:
        """Return the first period of a record that repeats itself, else so many samples, with one step for each."""
        loop = self.loop.rough(most)
        return Position(loop, self.measured[: loop.count])

    def read(
        self, plant: Model, friction: Model, values: Mapping[str, float], pure: np.ndarray, push: np.ndarray,
        reading: Reading, rng: np.random.Generator,
    ) -> np.ndarray:  # fmt: skip
        """Return what an encoder adds to that position, and the push, which is a change of the position [m or rad]."""
        change = push + reading.noise * rng.standard_normal(self.measured.size)
        if reading.resolution <= 0.0:
            return change
        phase = rng.uniform(0.0, reading.resolution)
        return reading.resolution * np.round((pure + change + phase) / reading.resolution) - phase - pure

    def leaning(self, plant: Model, friction: Model, values: Mapping[str, float], slope: np.ndarray) -> np.ndarray:
        """Return the change of the position [m or rad]: no force is simulated again."""
        return slope


@dataclass(frozen=True)
class Effort:
    """The effort [N or N*m] that the controller asks for.

    The encoder of the simulation is a perfect one: steps of its own would be noise of another kind beside those of
    the log, and would leave no derivative.
    """

    loop: ClosedLoop
    measured: np.ndarray
    position: np.ndarray
    presliding: float | None = None

    @property
    def period(self) -> int:
        """All of its samples: a log in closed loop counts as one."""
        return self.loop.count

    @property
    def phase(self) -> np.ndarray:
        """How far each sample is on its way through its log."""
        return np.arange(self.loop.count) / self.loop.count

    def simulated(self, plant: Model, friction: Model, values: Mapping[str, float]) -> np.ndarray:
        """Return the effort that the controller asks of the model [N or N*m]."""
        return self._asked(self.loop, plant, friction, values, encoder(kind=plant.kind, resolution=0.0))

    def rough(self, most: int) -> Effort:
        """Return so many samples."""
        return replace(self, loop=self.loop.first(most), measured=self.measured[:most], position=self.position[:most])

    def read(
        self, plant: Model, friction: Model, values: Mapping[str, float], pure: np.ndarray, push: np.ndarray,
        reading: Reading, rng: np.random.Generator,
    ) -> np.ndarray:  # fmt: skip
        """Return what both add to that effort [N or N*m]; the controller sees the position through the encoder."""
        moved = self.loop.moved_by(rng.uniform(0.0, reading.resolution))
        seed = int(rng.integers(SEEDS))
        sensor = encoder(kind=plant.kind, resolution=reading.resolution, noise=reading.noise, seed=seed)
        return self._asked(moved, plant, friction, values, sensor, push) - pure

    def leaning(self, plant: Model, friction: Model, values: Mapping[str, float], slope: np.ndarray) -> np.ndarray:
        """Return the friction force in the loop [N or N*m], its constant part left out.

        Where the body sticks, it is what friction holds against: a higher level breaks away later.
        """
        perfect = encoder(kind=plant.kind, resolution=0.0)
        force = self.loop.run(plant, self._dressed(friction), perfect, lag=values.get(LAG)).friction
        force = force - offset_of(friction.component.variables, values)
        return np.concatenate([force, np.full(self.loop.count - force.size, np.nan)])

    def _asked(
        self, loop: ClosedLoop, plant: Model, friction: Model, values: Mapping[str, float], sensor: Model,
        disturbance: np.ndarray | None = None,
    ) -> np.ndarray:  # fmt: skip
        dressed = self._dressed(friction)
        command = loop.run(plant, dressed, sensor, lag=values.get(LAG), disturbance=disturbance).command
        return np.concatenate([command, np.full(loop.count - command.size, np.nan)])

    def _dressed(self, friction: Model) -> Model:
        """Return a friction model as it is simulated: over a distance, where a static one turns at once."""
        return with_presliding(friction, self.presliding) if self.presliding and is_static(friction) else friction
