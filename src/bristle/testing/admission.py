"""Whether a model of a person's own may be used: the demands of the contract that are quick to try."""

from __future__ import annotations

import warnings
from typing import Any

from bristle.core.contracts import FrictionModel, Model
from bristle.core.errors import InputError, InputWarning
from bristle.engine import interpreted
from bristle.friction import base_of
from bristle.testing.contract import CHECKS, FORM, check_model, drives_a_mass, same_bits_compiled

__all__ = ["admit"]

QUICK = tuple(check for check in CHECKS if check not in (same_bits_compiled, drives_a_mass))
NAMES_OF_FORM = ("example", *(check.__name__.replace("_", " ") for check in FORM))


def admit(model: FrictionModel | Model) -> None:
    """Refuse a model of a person's own that has not the form of one, and warn of demands of physics that it misses.

    Nothing is compiled. Models of bristle itself pass untried.

    Parameters
    ----------
    model : FrictionModel or Model
        A descriptor, tried with its example parameters, or a model with parameters of its own.

    Raises
    ------
    InputError
        If a demand of the form is not met.
    """
    own = base_of(model.component if isinstance(model, Model) else model)
    if own.module.partition(".")[0] == "bristle":
        return
    file = _file_of(own)
    with interpreted():
        unmet = [one for one in check_model(model, checks=QUICK) if not one.passed]
    for one in unmet:
        if one.name in NAMES_OF_FORM:
            raise InputError(
                f"is not fit to be used ({one.name}): {one.detail.rstrip('.')}", path=file,
                mend=f"{one.advice}. Try: bristle check {file}" if one.advice else f"Try: bristle check {file}",
            )  # fmt: skip
    if unmet:
        names = ", ".join(one.name for one in unmet)
        warnings.warn(
            f"{file}: does not meet the contract of a friction model: {names}. See: bristle check {file}",
            InputWarning,
            stacklevel=2,
        )


def _file_of(component: Any) -> str:
    code = getattr(component.trial, "__code__", None)
    return code.co_filename if code is not None else component.name
