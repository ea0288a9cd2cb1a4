r"""How often in a turn an effort comes back, where nobody has said it: found in what sliding leaves of a log.

All whole numbers of times in a turn are tried, one pair of waves after the other, the one first that takes most of the
residual. What lies between two whole numbers is no cogging: waves half a turn off tell how much of a residual any wave
takes by chance, and a harmonic must take several times as much. A wave that passes faster than it is sampled looks like
a slow one, and is none there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bristle.core.axis import Axis, Cogging
from bristle.core.contracts import Plant
from bristle.core.errors import InputError
from bristle.core.least_squares import unbounded
from bristle.identification.dataset import Dataset
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameters import PriorKnowledge
from bristle.identification.sliding_friction import sliding_problem
from bristle.plants.terms import TURNS, TermedPlant, with_terms

__all__ = ["FEWEST_TURNS", "harmonics_in", "told_by", "with_harmonics"]

MOST_ORDER, MOST = 200, 24  # times in a turn that are tried, harmonics that are taken
FEWEST_TURNS = 1.5  # that a log goes through, to tell the turns of anything
FEWEST_WAVES = 3.0  # over the range of the log
PASSING = 0.5  # of the amplitude of a wave, behind the filters
SAMPLED = 0.5  # of a wave from sample to sample: a faster one is not told from a slower one
CHANCE, ABOVE = 0.9, 3.0  # quantile of waves that are none, and times by which a harmonic takes more
SHARE = 0.004  # of the first residual, that a harmonic takes at least


def with_harmonics(prior: PriorKnowledge, axis: Axis | None, dataset: Dataset) -> PriorKnowledge:
    """Return what is known beforehand with the harmonics that an axis leaves to its log.

    Raises
    ------
    InputError
        If the log does not turn far enough to tell them, or shows none.
    """
    for place, cogging in enumerate(axis.cogging if axis is not None else ()):
        if cogging.harmonics is None:
            problem = sliding_problem(dataset, prior)
            prior = _with(prior, cogging, harmonics_in(problem, cogging, f"cogging[{place}].harmonics"))
    return prior


def _with(prior: PriorKnowledge, cogging: Cogging, harmonics: Sequence[int]) -> PriorKnowledge:
    plant, gravity, columns, orders = prior.plant, False, (), dict[str, list[int]]()
    if isinstance(plant, TermedPlant):
        gravity, columns = plant.gravity, plant.columns
        orders = {turner: [n for counted, n in plant.orders if counted == turner] for turner in TURNS}
        plant = plant.inner
    orders[cogging.turner] = list(harmonics)
    plant = with_terms(plant, gravity=gravity, cogging=orders, columns=columns)
    return replace(prior, plant=plant, values={**prior.values, TURNS[cogging.turner]: cogging.turn})


def told_by(plant: Plant, axis: Axis) -> Axis:
    """Return an axis with the harmonics that a plant has."""
    orders = plant.orders if isinstance(plant, TermedPlant) else ()
    harmonics = [tuple(n for turner, n in orders if turner == cogging.turner) for cogging in axis.cogging]
    pairs = zip(axis.cogging, harmonics, strict=True)
    return replace(axis, cogging=tuple(replace(cogging, harmonics=numbers) for cogging, numbers in pairs))


def harmonics_in(problem: InverseDynamics, cogging: Cogging, path: str) -> list[int]:
    """Return how often in a turn the effort comes back beside what a simple `problem` explains."""
    dataset = problem.dataset
    turns = float(np.ptp(dataset.position)) / cogging.turn
    if turns < FEWEST_TURNS:
        raise InputError(
            f"cannot be told from a log that goes through {turns:.2g} turns of the {cogging.turner}", path=path,
            value="identify", mend="Write which ones, such as harmonics = [6, 12], or record more turns",
        )  # fmt: skip
    basis = np.linalg.qr(_scaled(np.column_stack([problem.columns, _along(dataset)])))[0]
    residual = _without(dataset.effort[:, None], basis)[:, 0]
    first, orders = max(int(np.ceil(FEWEST_WAVES / turns)), 1), list[int]()
    tried = np.arange(2 * first, 2 * MOST_ORDER + 1) / 2.0
    waves = {order: _waves(dataset, cogging.turn, order) for order in tried.tolist()}
    waves = {order: _without(pair, basis) for order, pair in waves.items() if np.mean(pair**2) > 0.5 * PASSING**2}
    least = SHARE * float(residual @ residual)
    while len(orders) < MOST:
        energies = {order: _energy_in(pair, residual) for order, pair in waves.items()}
        of_turns = {int(order): energy for order, energy in energies.items() if order.is_integer()}
        chance = float(
            np.quantile([energy for order, energy in energies.items() if not order.is_integer()] or [0], CHANCE)
        )
        best = max(of_turns, key=lambda order: of_turns[order], default=0)
        if not best or of_turns[best] < max(ABOVE * chance, least):
            break
        orders.append(best)
        pair = np.linalg.qr(waves.pop(float(best)))[0]
        residual = _without(residual[:, None], pair)[:, 0]
        waves = {order: _without(columns, pair) for order, columns in waves.items()}
    if not orders:
        raise InputError(
            f"are not seen in this log: no effort comes back with the turns of the {cogging.turner}", path=path,
            value="identify", mend="Leave [[cogging]] out, or write harmonics = [6]",
        )  # fmt: skip
    return sorted(orders)


def _along(dataset: Dataset) -> np.ndarray:
    """Return what changes along the whole axis, alike in both directions and not, as a cable or a guide does."""
    x = dataset.position
    place = 2.0 * (x - x.mean())[:, None] / float(np.ptp(x))
    powers = np.hstack([place, place**2])
    return np.hstack([powers, np.sign(dataset.velocity)[:, None] * powers])


def _waves(dataset: Dataset, turn: float, order: float) -> np.ndarray:
    """Return cosine and sine over the turn in each row, behind the filters, shape (row, 2)."""
    turns = [segment.position * (order / turn) for segment in dataset.segments]
    sampled = [np.abs(np.gradient(phase)) < SAMPLED for phase in turns]
    waves = [
        dataset.rows_of([
            dataset.filtered(np.where(slow, bend(2.0 * np.pi * phase), 0.0))
            for phase, slow in zip(turns, sampled, strict=True)
        ])
        for bend in (np.cos, np.sin)
    ]  # fmt: skip
    return np.stack(waves, axis=1)


def _scaled(columns: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(columns, axis=0)
    return columns[:, size > 0.0] / size[size > 0.0]


def _without(columns: np.ndarray, basis: np.ndarray) -> np.ndarray:
    return columns - basis @ (basis.T @ columns)


def _energy_in(pair: np.ndarray, residual: np.ndarray) -> float:
    """Return the sum of squares that a pair of waves takes from a residual."""
    gram, right = pair.T @ pair, pair.T @ residual
    return float(right @ unbounded(gram, right, rcond=1e-9))
