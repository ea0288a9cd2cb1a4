"""The trial: every truth under every condition in the loops of both sets, with compensators identified beforehand."""

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count
from typing import NamedTuple

import numpy as np

from bristle.apps.paper.robust.loops import (
    CHOSEN,
    FAMILIES,
    SETS,
    VARIANTS,
    Fitted,
    fitted,
    log_of,
    loop,
    peak_to_peak,
    setting,
)
from bristle.apps.paper.robust.truths import CONDITIONS, NOMINAL, Truth, under
from bristle.core import abreast, cores_for_simulations


class Cell(NamedTuple):
    """Runs of one loop."""

    set: str
    truth: str
    condition: str
    variant: str
    family: str


@dataclass(frozen=True)
class Plan:
    """The cases of the trial."""

    truths: tuple[Truth, ...]
    seeds: int
    conditions: tuple[str, ...] = tuple(CONDITIONS)
    sets: tuple[str, ...] = tuple(SETS)
    families: tuple[str, ...] = FAMILIES

    @property
    def compensators(self) -> tuple[str, ...]:
        """All families to identify, always with the chosen family."""
        return tuple(dict.fromkeys((*self.families, CHOSEN)))

    @property
    def cells(self) -> list[Cell]:
        """All simulated cells."""
        chosen = [
            Cell(name, truth.name, condition, variant, CHOSEN if "feedforward" in variant else "")
            for truth in self.truths
            for name in self.sets
            for condition in self.conditions
            for variant in VARIANTS
        ]
        # With feedforward only, each family is simulated.
        return chosen + [
            Cell(name, truth.name, NOMINAL, "feedforward", family)
            for truth in self.truths
            for name in self.sets
            for family in self.families
            if family != CHOSEN
        ]


@dataclass
class Trial:
    """The results."""

    plan: Plan
    fits: dict[tuple[str, str], Fitted] = field(default_factory=dict)
    errors: dict[Cell, np.ndarray] = field(default_factory=dict)


def run_trial(
    plan: Plan, progress: Callable[[float, str], None] = lambda share, text: None
) -> Trial:
    """Identify the compensators of each truth, and simulate every loop with them."""
    settings = {name: setting(name) for name in plan.sets}
    truths = {truth.name: truth for truth in plan.truths}
    cells = plan.cells
    done = count(1)

    def fit(truth: Truth) -> dict[tuple[str, str], Fitted]:
        log, axis = log_of(truth)
        fits = {}
        for family in plan.compensators:
            progress(0.0, f"{truth.name}: identifying {family}")
            fits[truth.name, family] = fitted(family, log, axis)
        return fits

    with cores_for_simulations():
        trial = Trial(
            plan, {key: model for fits in abreast(fit)(plan.truths) for key, model in fits.items()}
        )

        def simulate(cell: Cell) -> np.ndarray:
            friction = None
            if cell.family:
                friction = trial.fits[cell.truth, cell.family].friction
                if friction is None:
                    return np.empty(0)
            variant = loop(
                settings[cell.set][cell.variant],
                under(cell.condition, truths[cell.truth]),
                friction,
            )
            errors = np.array([peak_to_peak(variant, number) for number in range(plan.seeds)])
            progress(next(done) / len(cells), f"{cell.truth}, {cell.condition}, {cell.variant}")
            return errors

        trial.errors.update(zip(cells, abreast(simulate)(cells), strict=True))
    return trial
