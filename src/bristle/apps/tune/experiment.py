"""An experiment file as a machine: for rehearsals and tests, faster than the axis."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from bristle.apps.tune.machine import (
    FrictionFeedforward,
    Limits,
    MachineStoppedError,
    Recording,
    State,
)
from bristle.core import Experiment, Run as Simulated
from bristle.files import read_experiment
from bristle.models.references import recorded
from bristle.simulation import simulate

SLEW = 2.0  # of the gain [1/s]


class ExperimentMachine:
    """The first loop of an experiment file, with a guard behind its controller.

    Each record begins at rest. The guard ends a record at the first sample beyond a limit.
    """

    REQUIRED: ClassVar = {"file": ("", "rig.toml")}

    def __init__(self, *, file: str, sample_time: float) -> None:
        experiment = read_experiment(file)
        self._kind: Any = experiment.kind
        self._variant, self.sample_time, self._source = (
            experiment.variants[0],
            sample_time,
            Path(file).name,
        )
        self._limits: Limits | None = None
        self._feedforward: FrictionFeedforward | None = None
        self._gain = self._offset = 0.0

    def identity(self) -> Mapping[str, str]:
        """Return the file."""
        return {"machine": "experiment", "file": self._source}

    def writes(self) -> list[str]:
        """Return the names of the simulated guard."""
        return ["guard", "feedforward", "gain"]

    def state(self) -> State:
        """Return whether guard and feedforward are inserted, and the gain."""
        name = None if self._feedforward is None else self._feedforward.name
        return {"guard": self._limits is not None, "feedforward": name, "gain": self._gain}

    def arm(self, limits: Limits) -> None:
        """Set the limits of the guard."""
        self._limits = limits
        self._gain = self._offset = 0.0

    def load(self, feedforward: FrictionFeedforward) -> None:
        """Replace the feedforward at gain 0."""
        self._feedforward, self._gain = feedforward, 0.0

    def set(self, *, gain: float = 0.0, offset: float = 0.0) -> None:
        """Set gain and test effort."""
        self._gain, self._offset = gain, offset

    def record(self, reference: np.ndarray, alive: Callable[[], None]) -> Recording:
        """Simulate the loop along a reference."""
        alive()
        injected = np.full(reference.size, self._offset)
        if self._feedforward is not None and self._gain:
            # At rest before the motion, the gain rises in a ramp.
            ramp = np.minimum(SLEW * self.sample_time * np.arange(reference.size), self._gain)
            injected += ramp * self._feedforward.along(reference, self.sample_time)
        given = recorded(kind=self._kind, position=reference, sample_time=self.sample_time)
        run: Simulated = replace(
            self._variant.run, duration=self.sample_time * reference.size, settle=0.0
        )
        variant = replace(self._variant, reference=given, injected=injected, run=run)
        result = simulate(
            Experiment(name="machine", kind=self._kind, variants=(variant,))
        ).variants[variant.name]
        recording = Recording(reference, result.measured, result.effort)
        self._guard(recording)
        return recording

    def _guard(self, recording: Recording) -> None:
        assert self._limits is not None
        limits = self._limits
        low, high = limits.travel
        for reason, beyond in (
            ("following_error", np.abs(recording.error) > limits.following_error),
            ("effort", np.abs(recording.effort) > limits.effort),
            ("travel", (recording.position < low) | (recording.position > high)),
        ):
            if beyond.any():
                self._gain = self._offset = 0.0
                raise MachineStoppedError(
                    reason, f"at {np.argmax(beyond) * self.sample_time:.3f} s"
                )

    def keep(self) -> None:
        """Keep the gain."""

    def restore(self, state: State) -> None:
        """Remove guard and feedforward."""
        self._limits = self._feedforward = None
        self._gain = self._offset = 0.0

    def close(self) -> None:
        """Do nothing."""
