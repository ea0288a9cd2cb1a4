"""Friction whose level is another one in each half-cycle: the same contact, a little rougher or smoother."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.contracts import FrictionModel, Model
from bristle.core.lazy import cached_property
from bristle.core.packing import pack
from bristle.core.variable import Kind
from bristle.engine.motion import in_turns
from bristle.identification.dataset import Segment

__all__ = ["FrictionScale", "forces_of", "scaled"]

LEAST = 0.05  # friction does not vanish on any half-cycle


def forces_of(component: FrictionModel) -> tuple[str, ...]:
    """Return the parameters of a model that set the level of its friction force, the constant offset left out."""
    return tuple(
        name
        for name, one in component.variables.items()
        if one.quantity == "force" and one.excitation and name != "offset"
    )


def scaled(component: FrictionModel, values: Mapping[str, float], level: float) -> dict[str, float]:
    """Return the values of a model with its forces scaled."""
    return dict(values) | {name: level * values[name] for name in forces_of(component)}


@dataclass(frozen=True)
class FrictionScale:
    """A friction model whose level is drawn anew at each reversal.

    Parameters
    ----------
    component : FrictionModel
        The model.
    values : mapping
        Its parameters, as kernels receive them.
    kind : {"translational", "rotational"}
        The kind of axis.
    """

    component: FrictionModel
    values: Mapping[str, Any]
    kind: Kind

    def force(
        self, segment: Segment, starts: Sequence[int], dt: float, scatter: float, rng: np.random.Generator
    ) -> np.ndarray:
        """Return the friction force along a segment [N or N*m], shape (sample,), not filtered.

        Parameters
        ----------
        segment : Segment
            The motion.
        starts : sequence of int
            First sample of each half-cycle.
        dt : float
            Time between samples [s].
        scatter : float
            Standard deviation of the level, as a share of it.
        rng : Generator
            Draws the levels.
        """
        levels = np.maximum(1.0 + scatter * rng.standard_normal(len(starts)), LEAST)
        model, once, more = self._models
        first = segment.first_cycle
        signals = segment.signals(dt)
        turns = [0, *(first + start for start in starts[1:])]
        return in_turns(model, once + (levels[:, None] - 1.0) * more, dt=dt, starts=turns, **signals)[first:]

    @cached_property
    def _models(self) -> tuple[Model, np.ndarray, np.ndarray]:
        """The model, its parameters as numbers, and by how much these rise where its forces are doubled."""
        model, twice = (self._model(scaled(self.component, self.values, level)) for level in (1.0, 2.0))
        once, doubled = pack(model.parameters), pack(twice.parameters)
        return model, once, np.subtract(doubled, once, out=np.zeros_like(once), where=doubled != once)

    def _model(self, values: Mapping[str, float]) -> Model:
        parameters = self.component.assemble({name: values[name] for name in self.component.variables})
        return Model(self.component, parameters, self.kind)
