"""`Machine`: the small interface between `bristle tune` and a controller that runs an axis."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np

from bristle.core import (
    BristleError,
    Feedforward,
    InputError,
    Kind,
    Model,
    Variable,
    amount,
    array,
    guarded,
)
from bristle.simulation import feedforward_effort

STOPS = (
    "following_error",
    "effort",
    "travel",
    "dead_man",
    "feedforward",
    "lost_samples",
    "operator",
)
"""Reasons why a machine ends a motion; `bristle tune` reports them by name."""
State = Mapping[str, Any]
"""Everything that a run writes on a machine, as plain data (JSON)."""


class MachineStoppedError(BristleError):
    """A watchdog of the machine, a lost sample or the operator ended a motion.

    Parameters
    ----------
    reason : str
        A name of `STOPS`.
    detail : str
        Value and limit.
    """

    exit_code = 1

    def __init__(self, reason: str, detail: str = "") -> None:
        super().__init__(f"{reason.replace('_', ' ')}{': ' if detail else ''}{detail}")
        self.reason, self.detail = reason, detail


class MachineRefusedError(BristleError):
    """A machine cannot be tuned, with the name of the cause and the remedy."""

    exit_code = 1

    def __init__(self, code: str, message: str, mend: str = "") -> None:
        super().__init__(f"{message}. {mend}" if mend else message)
        self.code = code


def _travel(value: object, path: str, kind: Kind | None) -> tuple[float, ...]:
    """Return the ends of the travel, the smaller one first."""
    ends = array(least=2)(value, path, kind).tolist()
    if len(ends) > 2 or not ends[0] < ends[1]:
        raise InputError("must be a smaller position, then a larger one", path=path, value=ends)
    return tuple(ends)


@guarded(
    travel=_travel,
    following_error=amount(Variable("length", "largest following error", min=0.0), exclusive=True),
    effort=amount(Variable("force", "largest effort", min=0.0), exclusive=True),
)
@dataclass(frozen=True)
class Limits:
    """Limits that the guard of a machine enforces during a run, in SI units of the axis.

    Parameters
    ----------
    following_error : float
        Largest magnitude of reference minus position [m or rad].
    effort : float
        Largest magnitude of the effort at the motor [N or N*m].
    travel : tuple of float
        Smallest and largest position [m or rad].
    """

    following_error: float
    effort: float
    travel: tuple[float, float]


@dataclass(frozen=True)
class Recording:
    """A recorded motion, one row per sample, without lost samples; arrays of shape (sample,) in SI units of the axis.

    Parameters
    ----------
    reference, position : ndarray
        Set point and measured position [m or rad].
    effort : ndarray
        Effort at the motor: loop and feedforward [N or N*m].
    """

    reference: np.ndarray
    position: np.ndarray
    effort: np.ndarray

    def __post_init__(self) -> None:
        rows = len(self.reference)
        for name in ("position", "effort"):
            if len(getattr(self, name)) != rows:
                raise InputError(
                    "has more or fewer rows than reference",
                    path=name,
                    value=len(getattr(self, name)),
                    allowed=f"{rows} rows",
                )

    @property
    def error(self) -> np.ndarray:
        """Following error [m or rad]."""
        return self.reference - self.position


@guarded(
    lead=amount(Variable("time", "lead", min=0.0)),
    limit=amount(Variable("force", "limit", min=0.0), endless=True),
)
@dataclass(frozen=True)
class FrictionFeedforward:
    """The feedforward that a run loads into a machine: friction, offset, gravity and cogging along the reference.

    Parameters
    ----------
    folder : Path
        Folder of the identification, with ``model.toml``.
    name : str
        Name with the hash of the model.
    plant, friction : Model
        The identified axis.
    lead : float
        How much earlier than the position the effort has to be applied [s].
    """

    folder: Path
    name: str
    plant: Model
    friction: Model
    lead: float
    limit: float = np.inf
    _terms: Feedforward = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_terms", Feedforward(friction=self.friction, plant=self.plant))

    def along(self, reference: np.ndarray, sample_time: float) -> np.ndarray:
        """Return the effort for each sample of a reference, without its inertia [N or N*m].

        The reference is extrapolated by `lead` from its last three samples, as in the exported code:
        :math:`x + v t + a t^2 / 2`.
        """
        velocity = np.diff(reference, prepend=reference[0]) / sample_time
        acceleration = np.diff(velocity, prepend=0.0) / sample_time
        ahead = reference + velocity * self.lead + 0.5 * acceleration * self.lead**2
        effort = feedforward_effort(self._terms, ahead, np.zeros_like(ahead), sample_time)
        return np.clip(effort, -self.limit, self.limit)


@runtime_checkable
class Machine(Protocol):
    """A controller that runs one axis: the interface between `bristle tune` and the machine.

    A machine has a guard: it adds the feedforward, multiplied by a gain, to the effort of the loop, changes the gain in a ramp, and
    sets it to zero if a limit is exceeded or if the program that set it no longer answers. `bristle check MACHINE.py` tests a
    machine against this contract.
    """

    sample_time: float
    """Time between two samples [s]."""

    def identity(self) -> Mapping[str, str]:
        """Return what identifies controller, axis and firmware, and must not change during a run."""
        ...

    def writes(self) -> list[str]:
        """Return the names of everything that a run may write: the allow list."""
        ...

    def state(self) -> State:
        """Return the present content of everything on the allow list; a restored machine returns the content of before."""
        ...

    def arm(self, limits: Limits) -> None:
        """Insert the guard with these limits, at gain 0; replace the limits if it is inserted already."""
        ...

    def load(self, feedforward: FrictionFeedforward) -> None:
        """Load a feedforward at gain 0, in place of an earlier one."""
        ...

    def set(self, *, gain: float = 0.0, offset: float = 0.0) -> None:
        """Set the gain of the feedforward, from 0 to 1, and a constant test effort [N or N*m]."""
        ...

    def record(self, reference: np.ndarray, alive: Callable[[], None]) -> Recording:
        """Play a reference [m or rad] and return all of its samples; call `alive` while waiting.

        Raises
        ------
        MachineStoppedError
            If a watchdog trips, or if samples were lost.
        """
        ...

    def keep(self) -> None:
        """Keep the feedforward at its gain when the program ends."""
        ...

    def restore(self, state: State) -> None:
        """Remove everything that the run wrote, from any condition in which a killed run may leave it."""
        ...

    def close(self) -> None:
        """Disconnect."""
        ...


@runtime_checkable
class SavingMachine(Machine, Protocol):
    """A machine with non-volatile memory, in which `bristle tune --save` keeps a feedforward over a restart of its controller.

    Its attribute `loads`, if it exists, is a sentence: what the user does so that the controller loads the feedforward at its start.
    """

    def saved(self) -> Mapping[str, str]:
        """Return value or hash of each place in the memory; an empty text where nothing is saved."""
        ...

    def save(self, folder: Path) -> Mapping[str, str]:
        """Save the present feedforward, whose model is in a folder of results; return what `saved` has to return from now on."""
        ...

    def unsave(self) -> None:
        """Remove what `save` wrote, also if it was interrupted."""
        ...
