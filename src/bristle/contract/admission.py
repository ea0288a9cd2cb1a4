"""The quick demands of the contract, tested before a user's model runs."""

import warnings
from collections.abc import Sequence
from typing import Any

from bristle.contract.contract import CHECKS, COMPILED, FORM, OF_SLOT, SLOT_FORM, check_model
from bristle.core import Experiment, FrictionModel, InputError, InputWarning, Model
from bristle.core.documented import Documented
from bristle.engine import interpreted
from bristle.models.friction import base_of, channel_slots_of


def _quick(checks: Sequence[Any]) -> tuple[Any, ...]:
    return tuple(check for check in checks if check.__name__.replace("_", " ") not in COMPILED)


NAMES_OF_FORM = ("example", *(check.__name__.replace("_", " ") for check in (*FORM, *SLOT_FORM)))


def admit(model: FrictionModel | Model) -> None:
    """Refuse a user's model or slot that lacks the required form; warn if it violates a law of physics.

    No code is compiled. Built-in models pass untested.

    Parameters
    ----------
    model : FrictionModel or Model
        A descriptor, tested with its example parameters, or a model with its own parameters.

    Raises
    ------
    InputError
        If a demand of the form is not met.
    """
    component = model.component if isinstance(model, Model) else model
    own = base_of(component)
    for slot in filter(_is_own, channel_slots_of(component)):
        _admit(slot, _file_of(slot.factor, slot), _quick(OF_SLOT), "slot")
    if _is_own(own):
        _admit(model, _file_of(own.trial, own), _quick(CHECKS), "friction model")


def _is_own(described: Documented) -> bool:
    return described.module.partition(".")[0] != "bristle"


def _admit(tried: Any, file: str, checks: Sequence[Any], word: str) -> None:
    with interpreted():
        unmet = [check for check in check_model(tried, checks=checks) if not check.passed]
    for check in unmet:
        if check.name in NAMES_OF_FORM:
            mend = f"Try: bristle check {file}"
            if check.advice:
                mend = f"{check.advice}. {mend}"
            raise InputError(
                f'cannot be used, because it fails the test "{check.name}": {check.detail.rstrip(".")}',
                path=file,
                mend=mend,
            )
    if unmet:
        names = ", ".join(check.name for check in unmet)
        warnings.warn(
            f"{file}: fails the contract of a {word}: {names}. See: bristle check {file}",
            InputWarning,
            stacklevel=3,
        )


def admit_friction_of(experiment: Experiment) -> None:
    """Apply `admit` once to every friction model of an experiment, those of its feedforward included."""
    used = [
        model
        for variant in experiment.variants
        for model in (variant.friction, variant.feedforward.friction)
    ]
    for friction in {model for model in used if model}:
        admit(friction)


def _file_of(function: Any, component: Any) -> str:
    code = getattr(function, "__code__", None)
    if code is not None:
        return code.co_filename
    return component.name
