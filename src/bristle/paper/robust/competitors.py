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

__all__ = ["CHOSEN", "FAMILIES", "LOG", "Fitted", "fitted", "log_of"]

FAMILIES = ("coulomb_viscous", "dahl", "reformed_dahl", "bouc_wen", "lugre", "maxwell_slip", "gms", "preisach_lugre")
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

    Parameters
    ----------
    truth : Truth
        The friction.
    """
    if truth.record is not None and truth.axis is not None:
        return truth.record, truth.axis
    described = read_experiment(LOG)
    variant = replace(described.variants[0], friction=truth.friction.with_values(seed=SEED))
    described = replace(described, variants=(variant,))
    return logged(described), axis_of(described)


def fitted(family: str, log: Log, axis: Axis) -> Fitted:
    """Return a model of a family, identified from a log; where it cannot be, why.

    Parameters
    ----------
    family : str
        Name of the models.
    log, axis
        What `log_of` returns.
    """
    try:
        return Fitted(identify(log, family, axis=axis, blocks=0, draws=0).best.friction)
    except BristleError as error:
        return Fitted(None, told_by(error))
