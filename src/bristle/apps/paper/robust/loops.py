"""The loops of sets A and C with other friction, and the compensators: families identified from a log of that friction."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bristle.apps.paper.rig import axis_of, logged
from bristle.apps.paper.robust.truths import Truth
from bristle.apps.paper.setting import EXPERIMENTS
from bristle.core import Axis, BristleError, Experiment, Model, Status, Variant, error_text
from bristle.files import read_experiment
from bristle.identification import identify
from bristle.logs import Log
from bristle.simulation import simulate

SETS = {"set_a": EXPERIMENTS / "set_a.toml", "set_c": EXPERIMENTS / "set_c.toml"}
VARIANTS = {
    "none": "none",
    "feedforward": "identified",
    "observer": "observer",
    "observer_feedforward": "observer_feedforward",
}
"""Variants of both sets by their names here."""
SUBSTEPS = 4  # Steps of the integration in a sample; means over runs agree with those of the 25 of the sets


def setting(name: str) -> dict[str, Variant]:
    """Return the loops of a set by their names here."""
    variants = {variant.name: variant for variant in read_experiment(SETS[name]).variants}
    return {name: variants[source] for name, source in VARIANTS.items()}


def loop(variant: Variant, friction: Model, compensator: Model | None) -> Variant:
    """Return a loop on the rig with another friction."""
    fed = variant.feedforward
    if fed.friction is not None:
        fed = replace(fed, friction=compensator, fitted_to="")
    return replace(
        variant,
        friction=friction,
        feedforward=fed,
        run=replace(variant.run, substeps=SUBSTEPS, seeds=1),
    )


def peak_to_peak(variant: Variant, number: int) -> float:
    """Return the peak-to-peak following error of one run of a loop [m]; infinite after divergence."""
    seeded = {
        name: model.with_values(seed=model.values["seed"] + number)
        for name, model in (("friction", variant.friction), ("sensor", variant.sensor))
        if number and "seed" in model.values
    }
    single = replace(variant, **seeded)
    result = simulate(Experiment("robust", "translational", (single,))).variants[single.name]
    if result.status is Status.NOT_FINITE:
        return np.inf
    return result.following_error.peak_to_peak


PRINTED = "printed"  # equations (5) to (7) of the paper as printed
GATED = "preisach_lugre"  # the same with a gate: below nine tenths of break-away z is x
FAMILIES = (
    "coulomb_viscous",
    "dahl",
    "reformed_dahl",
    "bouc_wen",
    "lugre",
    "maxwell_slip",
    "gms",
    GATED,
    PRINTED,
)
# As in the paper, the operator is fitted over the position, then driven by z: the gate of the identification is removed.
IDENTIFIED_AS = {PRINTED: GATED}
CHOSEN = "maxwell_slip"  # The family of the compensator of the bench: used for every truth and every condition
LOG = EXPERIMENTS / "set_a_log.toml"
SEED = 501  # of the scatter in that log


class Fitted(NamedTuple):
    """A model of a family, or the reason of a failed fit."""

    friction: Model | None
    reason: str = ""


def log_of(truth: Truth) -> tuple[Log, Axis]:
    """Return the log for the identification of compensators, a minute of triangles in the loop of set A, and its axis."""
    described = read_experiment(LOG)
    variant = replace(described.variants[0], friction=truth.friction.with_values(seed=SEED))
    described = replace(described, variants=(variant,))
    return logged(described), axis_of(described)


def fitted(family: str, log: Log, axis: Axis) -> Fitted:
    """Return a model of a family, identified from the log and the axis of `log_of`, or the reason of a failure."""
    identified = IDENTIFIED_AS.get(family, family)
    try:
        friction = identify(log, identified, axis=axis, blocks=0, draws=0).finished.best.friction
    except BristleError as error:
        return Fitted(None, error_text(error))
    if family == PRINTED:
        return Fitted(friction.with_values(transition="paper"))
    return Fitted(friction)
