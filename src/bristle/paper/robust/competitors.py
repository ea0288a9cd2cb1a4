"""The compensators: families of models, each identified from the same log of a truth as a stranger to it would."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.errors import BristleError, told_by
from bristle.files.experiment import read_experiment
from bristle.identification import identify
from bristle.logs.log import Log
from bristle.paper.bench import axis_of, logged
from bristle.paper.experiment_files import EXPERIMENTS
from bristle.paper.robust.truths import Truth

__all__ = ["CHOSEN", "FAMILIES", "LOG", "PRINTED", "Fitted", "fitted", "log_of"]

PRINTED, GATED = "printed", "preisach_lugre"
"""Equations (5) to (7) of the paper as printed, and the same with a gate: below nine tenths of break-away z is x."""
FAMILIES = ("coulomb_viscous", "dahl", "reformed_dahl", "bouc_wen", "lugre", "maxwell_slip", "gms", GATED, PRINTED)
CHOSEN = "maxwell_slip"
"""The family of the compensator of the bench: it is taken for every truth and under every condition."""
LOG = EXPERIMENTS / "set_a_log.toml"
SEED = 501  # of the scatter in that log


class Fitted(NamedTuple):
    """A model of a family, or why there is none."""

    friction: Model | None
    reason: str = ""


def log_of(truth: Truth) -> tuple[Log, Axis]:
    """Return what compensators are identified from, and how it is to be read.

    It is the log of the bench: a minute of triangles in the loop of set A without compensation, encoder and effort
    command alone. Of a measured truth it is one half of its record, whose other half is the truth.
    """
    if truth.record is not None and truth.axis is not None:
        return truth.record, truth.axis
    described = read_experiment(LOG)
    variant = replace(described.variants[0], friction=truth.friction.with_values(seed=SEED))
    described = replace(described, variants=(variant,))
    return logged(described), axis_of(described)


def fitted(family: str, log: Log, axis: Axis) -> Fitted:
    """Return a model of a family, identified from a log; where it cannot be, why.

    As in the paper, the operator of the printed equations is fitted over the position, and then driven by z: they are
    identified with the gate, which is then left out.

    Parameters
    ----------
    family : str
        Name of the models.
    log, axis
        What `log_of` returns.
    """
    try:
        name = GATED if family == PRINTED else family
        friction = identify(log, name, axis=axis, blocks=0, draws=0).best.friction
        return Fitted(friction.with_values(transition="paper") if family == PRINTED else friction)
    except BristleError as error:
        return Fitted(None, told_by(error))
