r"""The describing function of friction: the first harmonic of its force over a position that moves as a sine, memory included."""

from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.edge import TEXT, amount, guarded, optional
from bristle.core.errors import InputError
from bristle.core.units import factor
from bristle.core.variable import Variable, unit_of
from bristle.engine.checks import FRICTION
from bristle.engine.equations import contact_step
from bristle.engine.motion import response

SAMPLES = 2000  # in a cycle; with 4 as a factor, the turns of the path are samples
CYCLES, MOST_CYCLES = 4, 512
SETTLED = 1e-6  # relative change of the harmonic from cycle to cycle
FREQUENCY = amount(Variable("frequency", "frequency", min=0.0), exclusive=True)


@guarded(friction=FRICTION, frequency=FREQUENCY, unit=optional(TEXT))
class FirstHarmonic:
    """The first harmonic of a friction model that moves as a sine at a frequency [Hz]; positions are in `unit`, SI where None."""

    friction: Model
    frequency: float
    unit: str

    def __init__(self, friction: Model, frequency: Any, unit: str | None) -> None:
        self.friction, self.frequency = friction, frequency
        length = unit_of("length", friction.kind)
        self.unit = unit or length
        self._scale = factor(self.unit, length, path="unit")
        self._dt = 1.0 / (SAMPLES * frequency)
        self._step = contact_step(friction, self._dt)
        p, component = friction.parameters, friction.component
        self._state = np.zeros(1 + len(component.State._fields) + component.memory_size(p))

    def over(self, A: float) -> complex:
        """Return the first harmonic of the force of the settled loop over the amplitude."""
        amplitude, cycles = float(A) * self._scale, CYCLES
        if not 0.0 < amplitude < np.inf:
            raise InputError("must be positive", path="A", value=A, allowed=f"> 0 {self.unit}")
        # Phases of one cycle, used again for each: to the bit the same path every time.
        phase = 2.0 * np.pi * np.arange(SAMPLES + 1) / SAMPLES
        # Each force is the mean of a step: what it is multiplied with is integrated over that step.
        weight = -np.diff(np.cos(phase)) + 1j * np.diff(np.sin(phase))
        while cycles <= MOST_CYCLES:
            path = amplitude * np.concatenate((np.tile(np.sin(phase[:-1]), cycles), [0.0]))
            force = response(self.friction, path, self._dt)[1:].reshape(cycles, SAMPLES)
            before, last = (force @ weight / (np.pi * amplitude))[-2:] * self._scale
            if abs(last - before) <= SETTLED * abs(last):
                return complex(last)
            cycles *= 4
        raise InputError(
            f"the loop of {self.friction.name} still changes after {MOST_CYCLES} cycles",
            path="A",
            value=A,
            mend="Look at bristle.check(model): it may drift",
        )

    def moved_to(self, A: float) -> float:
        """Return the mean force [N or N*m] while the contact moves on to a position in a sample of a cycle."""
        force, self._state = self._step(self._state, (float(A) * self._scale - self._state[0]) / self._dt)
        return force
