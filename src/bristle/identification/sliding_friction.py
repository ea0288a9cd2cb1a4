"""Coulomb and viscous friction of a log, fitted first: it sets the scale of all."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from bristle.core.contracts import FrictionModel
from bristle.core.errors import InputError
from bristle.core.least_squares import unbounded
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.friction import find
from bristle.friction.variation import PITCH
from bristle.identification.dataset import Dataset
from bristle.identification.estimation import Context
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import Sliding, linear
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.scales import scales_of
from bristle.identification.settings import DEFAULT, Settings

__all__ = ["context_of", "sliding_problem", "with_pitch"]

LEAST_LEVEL = 0.01  # of the effort: a Coulomb force that says nothing of the magnitude of friction
TURNS_LEAST = 3.0  # over the range, for a pitch to be looked for
STEPS_A_TURN = 8.0  # of the scan, over one more turn in the whole range
SCAN_MOST = 20_000
REFINED = 40


def context_of(
    dataset: Dataset, prior: PriorKnowledge, *, everywhere: bool = False, settings: Settings = DEFAULT
) -> Context:  # fmt: skip
    """Return what the fits of all models to a log share; an effort of zero is refused."""
    effort = float(np.sqrt(np.mean(dataset.effort**2)))
    if effort == 0.0:
        raise InputError("is zero throughout", path="log.effort", mend="Check which column holds the effort")
    problem = sliding_problem(dataset, prior)
    values = problem.parameters.complete(linear(problem).values)
    coulomb, viscous = values.pop("F_C"), values.pop("F_v")
    if coulomb <= LEAST_LEVEL * effort:
        # Pre-sliding over much of the stroke looks viscous: its level is that of all friction.
        friction = viscous * dataset.velocity + coulomb * np.sign(dataset.velocity)
        coulomb = max(float(np.sqrt(np.mean(friction**2))), coulomb)
    scales = scales_of(dataset, max(coulomb, LEAST_LEVEL * effort))
    return Context(dataset, prior, Sliding(values, coulomb, viscous), scales, everywhere, settings)


def with_pitch(context: Context, component: FrictionModel) -> Context:
    """Return the context with the pitch of the screw, found in what sliding leaves, where a model asks for it."""
    if PITCH not in component.variables.values() or context.prior.pitch is not None:
        return context
    sliding = context.sliding
    values = {**sliding.values, "F_C": sliding.coulomb, "F_v": sliding.viscous}
    pitch = _pitch_in(sliding_problem(context.dataset, context.prior), values)
    return replace(context, prior=replace(context.prior, pitch=pitch))


def sliding_problem(dataset: Dataset, prior: PriorKnowledge) -> InverseDynamics:
    """Return the problem of Coulomb and viscous friction, with which a log is looked at first."""
    return InverseDynamics(dataset, parameters_of(find("coulomb_viscous"), prior, dataset))


def _pitch_in(problem: InverseDynamics, values: Mapping[str, float]) -> float:
    """Return the period over the position of what a simple model without the slot leaves of a log [m or rad].

    The wave that takes most of the residual is looked for, evenly in the number of turns over the range, and refined.
    """
    dataset = problem.dataset
    x, residual = dataset.position, dataset.effort - problem.predicted(values)
    stroke = float(np.ptp(x))
    # At half of the speeds the wave passes the filter.
    most = stroke * dataset.cutoff / float(np.median(np.abs(dataset.velocity)))
    if most <= TURNS_LEAST:
        raise InputError("does not resolve a pitch", path="log.position",
                         value=f"a range of {with_unit(stroke, unit_of('length', dataset.kind))}",
                         mend="Give the lead in [transmission] of the axis file")  # fmt: skip
    turns = np.linspace(TURNS_LEAST, most, int(min(STEPS_A_TURN * (most - TURNS_LEAST) + 2, SCAN_MOST)))
    step = turns[1] - turns[0]
    best = turns[int(np.argmax([_explained(x, residual, count / stroke) for count in turns.tolist()]))]
    near = np.linspace(best - step, best + step, REFINED)
    best = near[int(np.argmax([_explained(x, residual, count / stroke) for count in near.tolist()]))]
    return stroke / float(best)


def _explained(x: np.ndarray, residual: np.ndarray, frequency: float) -> float:
    """Return the sum of squares that a wave of this frequency [1/m or 1/rad] takes from a residual."""
    phase = 2.0 * np.pi * frequency * x
    waves = np.stack([np.cos(phase), np.sin(phase), np.ones_like(x)], axis=1)
    gram, right = waves.T @ waves, waves.T @ residual
    return float(right @ unbounded(gram, right))
