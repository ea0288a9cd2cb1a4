"""Inverse dynamics as a least-squares problem: measured effort against plant and friction, on regression rows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from bristle.core.contracts import Model
from bristle.core.lazy import cached_property
from bristle.identification.dataset import Dataset, mechanical
from bristle.identification.parameters import ParameterSet

__all__ = ["InverseDynamics", "Residual", "Sought"]

NUDGE = 1e-4  # of where a contact stood, from -1 to 1


class Residual(Protocol):
    """What a fit makes small."""

    def residual(self, free: Mapping[str, float]) -> np.ndarray:
        """Return what is left over, shape (row,)."""
        ...


class Sought(Residual, Protocol):
    """What a search makes small."""

    @property
    def parameters(self) -> ParameterSet:
        """What is free and what is held."""
        ...

    @property
    def norm(self) -> float:
        """Root of the sum of squares of what was measured."""
        ...

    def near(self, free: Mapping[str, float]) -> Sought:
        """Return the problem around some parameters, what is found on the way held; itself where there is nothing."""
        ...

    def without_found(self, columns: np.ndarray, free: Mapping[str, float], rows: np.ndarray | slice) -> np.ndarray:
        """Return derivatives of the residual without what is made up for by what is found on the way."""
        ...


@dataclass(frozen=True)
class InverseDynamics:
    """Rows ``effort = M acceleration + ... + F(motion)`` for one plant and one friction model.

    Parameters
    ----------
    dataset : Dataset
        The rows.
    unknowns : ParameterSet
        The model, what is free and what is held.
    places : tuple of float or None, optional
        Where the contact stood before each segment; found from the effort where not given.
    """

    dataset: Dataset
    parameters: ParameterSet
    places: tuple[float | None, ...] | None = None

    def friction(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the friction force of each row [N or N*m], of the model run along the recorded motion."""
        plant = self.plant(values) if self.parameters.component.start is not None else None
        return self.dataset.rows_of(self.dataset.friction_along(self.model(values), plant, self.places))

    def near(self, free: Mapping[str, float]) -> InverseDynamics:
        """Return the problem around some parameters: where the contact stood before each segment does not change."""
        if self.parameters.component.start is None or self.places is not None:
            return self
        values = self.parameters.complete(free)
        return replace(self, places=self.dataset.places(self.model(values), self.plant(values)))

    def without_found(self, columns: np.ndarray, free: Mapping[str, float], rows: np.ndarray | slice) -> np.ndarray:
        """Return derivatives of the residual, shape (row, free), without what the start of the contact makes up for.

        Where the contact stood follows the parameters: what of a derivative it can explain is none (variable
        projection [1]_). At an end of its range it does not follow.

        References
        ----------
        .. [1] L. Kaufman, "A variable projection method for solving separable nonlinear least squares problems", BIT
           15(1), 1975. doi:10.1007/BF01932995
        """
        if self.places is None or self.parameters.component.start is None:
            return columns
        moved = tuple(one - math.copysign(NUDGE, one) if one is not None else None for one in self.places)
        change = (self.residual(free) - replace(self, places=moved).residual(free))[rows]
        segment = self.dataset.segment_of_row[rows]
        found = columns.copy()
        for number, place in enumerate(self.places):
            there = segment == number
            direction = change[there]
            length = float(direction @ direction)
            if place is not None and abs(place) < 1.0 and length > 0.0:
                found[there] -= np.outer(direction, direction @ columns[there]) / length
        return found

    def model(self, values: Mapping[str, float]) -> Model:
        """Return the friction model with these values, whether or not it allows them."""
        component = self.parameters.component
        parameters = component.assemble({name: values[name] for name in component.variables})
        return Model(component, parameters, self.dataset.kind)

    def predicted(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the effort of each row [N or N*m] from all parameters, held ones included."""
        one = self.dataset
        return one.rows_of(one.explained(self.plant(values), self.model(values), self.places))

    def mechanical(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the effort that the plant takes in each row, friction apart [N or N*m]."""
        one = self.dataset
        return mechanical(self.plant(values), one.position, one.velocity, one.acceleration)

    def plant(self, values: Mapping[str, float]) -> Model:
        """Return the plant with these values, whether or not it allows them."""
        component = self.parameters.plant
        parameters = component.assemble({name: values[name] for name in component.variables})
        return Model(component, parameters, self.dataset.kind)

    def residual(self, free: Mapping[str, float]) -> np.ndarray:
        """Return measured minus predicted effort of each row [N or N*m], from the free parameters."""
        return self.dataset.effort - self.predicted(self.parameters.complete(free))

    @property
    def norm(self) -> float:
        """Root of the sum of squares of the effort [N or N*m]."""
        return float(np.linalg.norm(self.dataset.effort))

    @cached_property
    def columns(self) -> np.ndarray:
        """Regressor of a model that is linear in its parameters, shape (row, free), by its own trial.

        Each column is what the model answers to one parameter of 1 with all others 0.
        """
        names, held = self.parameters.component.variables, self.parameters.fixed
        # What a force does not depend on linearly keeps its value.
        shapes = {name: held[name].value for name in ("pitch",) if name in names}
        found = []
        for name in self.parameters.free:
            if name in self.parameters.plant.variables:
                found.append(self.mechanical({one: float(one == name) for one in self.parameters.plant.variables}))
            else:
                found.append(self.friction({one: float(one == name) for one in names} | shapes))
        return np.stack(found, axis=1) if found else np.empty((self.dataset.effort.size, 0))

    @cached_property
    def fixed_effort(self) -> np.ndarray:
        """Effort of each row [N or N*m] due to the held parameters alone, for a linear model."""
        return self.predicted(self.parameters.complete(dict.fromkeys(self.parameters.free, 0.0)))
