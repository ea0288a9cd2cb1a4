"""What measuring more branches brings, on contacts of other kinds than the rig: as `bristle.paper.economy`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from bristle.paper.economy import WAYS, Economy, economy
from bristle.paper.experiment_files import EXPERIMENTS
from bristle.paper.robust.truths import AMPLITUDE, Truth
from bristle.paper.setting import read_setting

__all__ = ["COUNTS", "economy_on", "is_measurable", "means_of"]

COUNTS = (1, 10)
"""Branches measured: fewest, and as many as a patient person measures."""


def is_measurable(truth: Truth) -> bool:
    """Return whether the branches of the paper, which go through a few micrometres, can be measured on a truth."""
    return truth.amplitude == AMPLITUDE


def economy_on(truth: Truth, seeds: int, progress: Callable[[float, str], None] | None = None) -> Economy:
    """Return the errors of models made from few and more measured branches of a truth."""
    setting = read_setting(EXPERIMENTS / "fig_06.toml")
    measurement = dict(setting.numbers["measurement"]) | {"branches": list(COUNTS)}
    setting = replace(setting, numbers=dict(setting.numbers) | {"measurement": measurement})
    return economy(setting, truth.friction, seeds, progress)


def means_of(cost: Economy) -> dict[str, Any]:
    """Return the mean errors [%] by the way to the model, in the order of the branches; NaN where there is no model."""
    return {
        "branches": list(cost.counts),
        "scatter_percent": cost.floor,
        "error_percent": {name: cost.errors[name].mean(axis=1) for name in WAYS},
    }
