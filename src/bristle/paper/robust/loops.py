"""The loops of sets A and C with another friction, and what they follow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bristle.core.contracts import Model
from bristle.core.experiment import Experiment, Variant
from bristle.core.status import Status
from bristle.files.experiment import read_experiment
from bristle.paper.experiment_files import EXPERIMENTS
from bristle.paper.robust.truths import AMPLITUDE, Truth
from bristle.simulation import simulate

__all__ = ["SETS", "VARIANTS", "loop", "peak_to_peak", "setting"]

SETS = {"set_a": EXPERIMENTS / "set_a.toml", "set_c": EXPERIMENTS / "set_c.toml"}
VARIANTS = {"none": "none", "feedforward": "identified", "observer": "observer", "observer_feedforward": "observer_feedforward"}
"""Variants of both sets by what they are called here."""
SUBSTEPS = 4
"""Steps of the integration in a sample; with the 25 of the sets means over runs stay within their intervals."""


def setting(name: str) -> dict[str, Variant]:
    """Return the loops of a set by what they are called here."""
    variants = {variant.name: variant for variant in read_experiment(SETS[name]).variants}
    return {name: variants[source] for name, source in VARIANTS.items()}


def loop(variant: Variant, truth: Truth, friction: Model, compensator: Model | None) -> Variant:
    """Return a loop on the rig with another friction."""
    fed = variant.feedforward
    if fed.friction is not None:
        fed = replace(fed, friction=compensator, fitted_to="")
    return replace(
        variant,
        friction=friction,
        feedforward=fed,
        reference=_motion(variant.reference, truth),
        run=replace(variant.run, substeps=SUBSTEPS, seeds=1),
    )


def _motion(reference: Model, truth: Truth) -> Model:
    amplitudes = np.array(reference.values["amplitudes"])
    if not truth.is_varied:
        amplitudes = np.where(amplitudes > 0.0, np.max(amplitudes), 0.0)
    return reference.with_values(amplitudes=amplitudes * (truth.amplitude / AMPLITUDE))


def peak_to_peak(variant: Variant, number: int) -> float:
    """Return the following error peak to peak of one run of a loop [m]; infinite for one that diverged."""
    seeded = {
        name: model.with_values(seed=model.values["seed"] + number)
        for name, model in (("friction", variant.friction), ("sensor", variant.sensor))
        if number and "seed" in model.values
    }
    single = replace(variant, **seeded)
    result = simulate(Experiment("robust", "translational", (single,))).variants[single.name]
    return np.inf if result.status is Status.NOT_FINITE else result.following_error.peak_to_peak
