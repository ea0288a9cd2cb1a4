"""What an estimator is: a signal that was measured, and what the free parameters leave of it.

A new estimator is one file with such a problem. The search, the bootstrap, the look at what can be identified, the
validation and the ranking do the rest with what is written here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from bristle.core.contracts import Model
from bristle.core.lazy import cached_property
from bristle.identification.contrast import Away
from bristle.identification.dataset import Dataset
from bristle.identification.disturbance import Disturbance
from bristle.identification.half_cycles import Groups
from bristle.identification.parameters import ParameterSet
from bristle.identification.settings import Settings

__all__ = ["Fold", "Problem", "Replicates", "Residual"]


class Residual(Protocol):
    """What is left over of a signal."""

    def residual(self, free: Mapping[str, float]) -> np.ndarray:
        """Return measured minus predicted signal, shape (row,), from the free parameters."""
        ...


class Fold(NamedTuple):
    """What is held out together: rows of the signal, those that may be fitted meanwhile, and rows of the data set.

    Each has shape (row,) of bool.
    """

    held_out: np.ndarray
    fitted: np.ndarray
    of_dataset: np.ndarray


class Replicates(Protocol):
    """What the same axis would have recorded, had the fitted model been the truth."""

    @property
    def doubt(self) -> float:
        """Share, as one standard error, by which fits to the log may be off otherwise than those to replicates are."""
        ...

    def draw(self, disturbance: Disturbance, rng: np.random.Generator, side: float = 1.0) -> Residual:
        """Return the same problem on a log drawn anew, or on its mirror image, all disturbances reversed (-1)."""
        ...

    def made_with(self, values: Mapping[str, float]) -> Replicates:
        """Return what draws logs of the same model with other parameters; what the fit left over stays what it is."""
        ...


class Problem(Residual, Protocol):
    """What least squares makes small, and what resampling needs to know of it.

    `is_effort` says whether the signal is an effort [N or N*m], as the bands around it are; `intervals_code` is the
    code of the diagnostic that tells how intervals were found.
    """

    @property
    def is_effort(self) -> bool: ...  # noqa: D102
    @property
    def intervals_code(self) -> str: ...  # noqa: D102

    @property
    def parameters(self) -> ParameterSet:
        """What is free and what is fixed."""
        ...

    @property
    def dataset(self) -> Dataset:
        """The log as rows of inverse dynamics."""
        ...

    @cached_property
    def measured(self) -> np.ndarray:
        """The signal, shape (row,)."""
        ...

    @property
    def row_time(self) -> float:
        """Time from row to row of the signal [s]."""
        ...

    @cached_property
    def half_cycles(self) -> Groups:
        """The rows of each half-cycle."""
        ...

    @cached_property
    def away(self) -> Away:
        """Where nothing of how friction turns disturbs the signal; nowhere, where that cannot be told."""
        ...

    def residuals(self, parameter_sets: Sequence[Mapping[str, float]]) -> Sequence[np.ndarray]:
        """Return what `residual` does, for each of several sets of free parameters, on all cores."""
        ...

    def near(self, free: Mapping[str, float]) -> Problem:
        """Return the problem around some parameters, what is found on the way held; itself where there is nothing."""
        ...

    def without_found(self, columns: np.ndarray, free: Mapping[str, float], rows: np.ndarray | slice) -> np.ndarray:
        """Return derivatives of the residual without what is made up for by what is found on the way."""
        ...

    def errors(self, free: Mapping[str, float]) -> dict[str, float]:
        """Return the errors of the signal, and what else of it a fit tells, by the names that `Fit` has for them."""
        ...

    def effort_residual(self, free: Mapping[str, float], residual: np.ndarray) -> np.ndarray:
        """Return measured minus predicted effort of each row of the data set [N or N*m], where that is the residual."""
        ...

    def friction_slope(self, values: Mapping[str, float]) -> np.ndarray:
        """Return by how much the signal of each row rises with the level of friction, from all parameters."""
        ...

    def replicates(self, values: Mapping[str, float], slope: np.ndarray, residual: np.ndarray) -> Replicates:
        """Return what draws logs of the fitted model; `slope` and `residual` are those at all parameters."""
        ...

    def refits_linearly(self, friction: Model) -> bool:
        """Return whether a fit to a replicate may be taken for linear around the solution."""
        ...

    def folds(self, count: int) -> tuple[str, list[Fold]]:
        """Return what parts of a log are called, and the parts, each of which is held out in turn."""
        ...

    def parts_of(self, blocks: int, settings: Settings) -> tuple[str, list[Fold]]:
        """Return the logs where there are several, else so many parts of one; one too short is refused."""
        ...
