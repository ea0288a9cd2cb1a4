"""What the slots of a model need to know of a log: range of positions, pitch of the screw, load, temperature."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bristle.core.contracts import FrictionModel
from bristle.core.errors import InputError
from bristle.core.least_squares import unbounded
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.friction.variation import HALF_RANGE, MIDDLE, PITCH, SIGNALS
from bristle.identification.dataset import Dataset
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameters import Fixed

__all__ = ["pitch_in", "places_of"]

TURNS_LEAST = 3.0  # over the range, for a pitch to be looked for
STEPS_A_TURN = 8.0  # of the scan, over one more turn in the whole range
SCAN_MOST = 20_000
REFINED = 40


def places_of(component: FrictionModel, dataset: Dataset, pitch: float | None) -> dict[str, Fixed]:
    """Return the parameters of slots that are not identified but read off the log or the axis.

    Parameters
    ----------
    component : FrictionModel
        The friction model.
    dataset : Dataset
        The log.
    pitch : float or None
        Travel for one turn of the screw [m or rad].

    Raises
    ------
    InputError
        If the log lacks the load or the temperature that a slot asks for, or is too short for a pitch to be found.
    """
    asked = {variable.excitation for variable in component.variables.values()}
    for signal in SIGNALS:
        if signal in asked and any(signal not in one.surroundings for one in dataset.segments):
            raise InputError(
                f"has no {signal}, which +{signal} needs", path="log",
                mend=f"Name its column under [columns] of the axis file: {signal} = ..., or drop +{signal}",
            )  # fmt: skip
    low = min(float(np.min(one.position)) for one in dataset.segments)
    high = max(float(np.max(one.position)) for one in dataset.segments)
    fixed = {
        MIDDLE: Fixed(0.5 * (low + high), "held-middle"),
        HALF_RANGE: Fixed(0.5 * (high - low), "held-half-range"),
    }
    if pitch is not None:
        fixed[PITCH] = Fixed(pitch, "held-pitch")
    return {name: fixed[variable] for name, variable in component.variables.items() if variable in fixed}


def pitch_in(problem: InverseDynamics, values: Mapping[str, float]) -> float:
    """Return the period over the position of what a model leaves of a log [m or rad].

    The wave that takes most of the residual is looked for, evenly in the number of turns over the range, and refined.

    Parameters
    ----------
    problem : InverseDynamics
        A simple model, without the slot.
    values : mapping of str to float
        All of its parameters [SI].

    Raises
    ------
    InputError
        If the log goes through less than three turns of any pitch that passes its filter.
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
    best = turns[int(np.argmax([_explained(x, residual, one / stroke) for one in turns.tolist()]))]
    near = np.linspace(best - step, best + step, REFINED)
    best = near[int(np.argmax([_explained(x, residual, one / stroke) for one in near.tolist()]))]
    return stroke / float(best)


def _explained(x: np.ndarray, residual: np.ndarray, frequency: float) -> float:
    """Return the sum of squares that a wave of this frequency [1/m or 1/rad] takes from a residual."""
    phase = 2.0 * np.pi * frequency * x
    waves = np.stack([np.cos(phase), np.sin(phase), np.ones_like(x)], axis=1)
    gram, right = waves.T @ waves, waves.T @ residual
    return float(right @ unbounded(gram, right))
