r"""Output error: the parameters that make the simulated signal the measured one.

.. math:: \hat\theta = \arg\min_\theta \sum_k \left[y_k - \hat y_k(\theta)\right]^2

In open loop `y` is the position that the measured effort makes of the model. In closed loop it is the effort that the
controller asks for: the controller keeps the position near its reference whatever the model is, and what the model does
wrong shows in the effort that this takes. The measured position is nowhere differentiated, so its noise does not bias
the parameters as it does in inverse dynamics.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import FrictionModel
from bristle.core.diagnostic import Diagnostic
from bristle.core.errors import InputError
from bristle.core.variable import Variable
from bristle.friction import base_of, gms, maxwell_slip
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.outputs import LAG, Effort, Output, Position
from bristle.identification.parameters import ParameterSet
from bristle.logs.log import Log
from bristle.simulation.recorded.closed_loop import closed_loop_of
from bristle.simulation.recorded.open_loop import FINE, open_loop_of
from bristle.simulation.result import relative_error_percent

__all__ = ["COARSE", "OutputError", "one_period", "refuse_elements", "simulated_loop"]

COARSE = 4  # steps for one sample of an open loop, on the way
EXPLORED = 12_000  # samples of all logs, which are enough to see whether a place is worth a closer look
LAG_MOST = 20.0  # samples
SMALL = {"open": "output-error-open", "closed": "output-error-closed"}


@dataclass(frozen=True)
class OutputError:
    """The error of a simulation as a least-squares problem.

    Parameters
    ----------
    inverse : InverseDynamics
        The same model as inverse dynamics; it knows what is free and what is held.
    outputs : tuple of Output
        The segments of the logs.
    loop : {"open", "closed"}
        What is simulated.
    """

    inverse: InverseDynamics
    outputs: tuple[Output, ...]
    loop: str

    @classmethod
    def of(
        cls, inverse: InverseDynamics, logs: Sequence[Log], axes: Sequence[Axis | None], loop: str, steps: int = FINE
    ) -> OutputError:
        """Return the problem of several logs; an open loop is integrated with so many steps for one sample."""
        outputs: list[Output] = []
        for log, axis in zip(logs, axes, strict=True):
            its = axis or Axis(kind=log.kind)
            for part in log.segments or (slice(0, len(log)),):
                if loop == "open":
                    outputs.append(Position(open_loop_of(log, its, part, steps), log.position.values[part]))
                    continue
                assert log.effort is not None
                closed = closed_loop_of(
                    log, its, part, "to fit the closed loop", 'write loop = "open" under [identification]'
                )
                outputs.append(Effort(closed, log.effort.values[part], log.position.values[part], its.presliding))
        if loop == "closed" and any(axis is not None and axis.seeks_lag for axis in axes):
            inverse = replace(inverse, parameters=_with_lag(inverse.parameters, logs[0].sample_time))
        return cls(inverse, tuple(outputs), loop)

    @property
    def rough(self) -> OutputError:
        """The same on the first samples of each segment, an open loop with one step for a sample."""
        most = max(EXPLORED // len(self.outputs), 1)
        return replace(self, outputs=tuple(one.rough(most) for one in self.outputs))

    @property
    def parameters(self) -> ParameterSet:
        """What is free and what is held."""
        return self.inverse.parameters

    @property
    def measured(self) -> np.ndarray:
        """The signal of all segments, shape (sample,)."""
        return np.concatenate([one.measured for one in self.outputs])

    @property
    def phase(self) -> np.ndarray:
        """How far each sample is on its way through its period or its log, from 0 to 1."""
        return np.concatenate([one.phase for one in self.outputs])

    @property
    def segment_of_sample(self) -> np.ndarray:
        """Which segment each sample is from."""
        return np.repeat(np.arange(len(self.outputs)), [one.measured.size for one in self.outputs])

    @property
    def norm(self) -> float:
        """Root of the sum of squares of the signal."""
        return float(np.linalg.norm(self.measured))

    @property
    def magnitude(self) -> float:
        """Typical magnitude of the signal."""
        return float(np.std(self.measured))

    def near(self, free: Mapping[str, float]) -> OutputError:
        """Return the problem itself: its simulations begin where the log says."""
        return self

    def without_found(self, columns: np.ndarray, free: Mapping[str, float], rows: np.ndarray | slice) -> np.ndarray:
        """Return the derivatives as they are: nothing is found on the way."""
        return columns

    @property
    def diagnostic(self) -> Diagnostic:
        """What was made small."""
        return Diagnostic(SMALL[self.loop], severity="note")

    def told(self, free: Mapping[str, float]) -> dict[str, float]:
        """Return the errors of a fit that its solution made small, and the lag of the drive where that was sought."""
        residual, what = self.residual(free), "position" if self.loop == "open" else "loop"
        measured = self.measured
        found = {
            f"{what}_error_percent": relative_error_percent(measured, measured - residual),
            f"{what}_rmse": float(np.sqrt(np.mean(residual**2))),
        }
        return found | ({LAG: free[LAG]} if LAG in free else {})

    def residual(self, free: Mapping[str, float]) -> np.ndarray:
        """Return measured minus simulated signal of each sample, from the free parameters."""
        return self.measured - self.simulated(self.parameters.complete(free))

    def simulated(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the simulated signal of each sample, from all parameters."""
        plant, friction = self.inverse.plant(values), self.inverse.model(values)
        return np.concatenate([one.simulated(plant, friction, values) for one in self.outputs])


def _with_lag(parameters: ParameterSet, sample_time: float) -> ParameterSet:
    lag = Variable(
        "time", "lag of the drive behind its controller", min=0.0, max=LAG_MOST * sample_time, nominal=sample_time,
        excitation="drive",
    )  # fmt: skip
    return replace(parameters, free=(*parameters.free, LAG), loop={LAG: lag})


def simulated_loop(logs: Sequence[Log], axes: Sequence[Axis | None]) -> str:
    """Return which loop is simulated, ``"open"`` or ``"closed"``: as the axis says, else as it can be.

    Raises
    ------
    InputError
        If the axes of several logs disagree, or a lag is asked of an open loop.
    """
    asked = {axis.loop for axis in axes if axis is not None} or {None}
    if len(asked) > 1:
        raise InputError("differs from axis to axis", path="identification.loop", mend="Say the same in all of them")
    can = all(
        axis is not None and axis.controller is not None and log.reference is not None
        for log, axis in zip(logs, axes, strict=True)
    )
    loop = asked.pop() or ("closed" if can else "open")
    if loop == "open" and any(axis is not None and axis.seeks_lag for axis in axes):
        raise InputError("shows in a closed loop only", path="effort.lag", value="identify",
                         mend="Describe the [controller] and name the column of the reference")  # fmt: skip
    return loop


def refuse_elements(component: FrictionModel) -> None:
    """Refuse a model whose elements inverse dynamics lays out: its error could not be compared with others.

    Raises
    ------
    InputError
        If it is one.
    """
    if base_of(component) in (maxwell_slip, gms):
        raise InputError("is identified by inverse dynamics only", path="model", value=component.name,
                         mend="Write --method inverse_dynamics, or ask for dahl or lugre")  # fmt: skip


def one_period(log: Log, axis: Axis | None) -> Log:
    """Return a log without what only repeats its first period, for a start."""
    whole = log.segments or (slice(0, len(log)),)
    loops = [open_loop_of(log, axis or Axis(kind=log.kind), part, 1) for part in whole]
    cut = [
        slice(part.start or 0, (part.start or 0) + loop.effort.size) if loop.periodic else part
        for part, loop in zip(whole, loops, strict=True)
    ]
    return replace(log, segments=tuple(cut))
