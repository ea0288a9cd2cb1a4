"""Friction models, each in a file. Call one with parameters to get a model with values.

Examples
--------
>>> from bristle import friction
>>> friction.coulomb_viscous(F_C="20 N", F_v="200 N*s/m")
coulomb_viscous(F_v=200 N*s/m, F_C=20 N)
"""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

from bristle.core.contracts import FrictionModel
from bristle.core.edge import NAMES, TEXT, component, guarded
from bristle.core.errors import InputError, did_you_mean
from bristle.core.loading import loaded_from
from bristle.core.slot import Slot
from bristle.models.family import Family
from bristle.models.friction.channel_slot import channel_slots_of, with_channel_slot
from bristle.models.friction.channels import CHANNEL_SLOTS
from bristle.models.friction.level import risen
from bristle.models.friction.presliding import is_static, with_presliding, without_presliding
from bristle.models.friction.slots import (
    OPERATOR_SLOTS,
    SLOTS,
    SlottedModel,
    base_of,
    slotted,
    unvaried,
)
from bristle.models.friction.variation import varied
from bristle.models.hysteresis import OPERATORS

if TYPE_CHECKING:
    # Every model of bristle, in the order of the lists.
    # isort: off
    from bristle.models.friction.coulomb import coulomb as coulomb
    from bristle.models.friction.viscous import viscous as viscous
    from bristle.models.friction.coulomb_viscous import coulomb_viscous as coulomb_viscous
    from bristle.models.friction.stribeck import stribeck as stribeck
    from bristle.models.friction.stribeck_free import stribeck_free as stribeck_free
    from bristle.models.friction.dahl import dahl as dahl
    from bristle.models.friction.reformed_dahl import reformed_dahl as reformed_dahl
    from bristle.models.friction.bouc_wen import bouc_wen as bouc_wen
    from bristle.models.friction.bouc_wen_classic import bouc_wen_classic as bouc_wen_classic
    from bristle.models.friction.lugre import lugre as lugre
    from bristle.models.friction.elastoplastic import elastoplastic as elastoplastic
    from bristle.models.friction.maxwell_slip import maxwell_slip as maxwell_slip
    from bristle.models.friction.maxwell_stribeck import maxwell_stribeck as maxwell_stribeck
    from bristle.models.friction.gms import gms as gms
    from bristle.models.friction.gap_slider import gap_slider as gap_slider
    from bristle.models.friction.preisach_contact import preisach_contact as preisach_contact
    from bristle.models.friction.preisach_lugre import preisach_lugre as preisach_lugre
    from bristle.models.friction.leuven import leuven as leuven
    from bristle.models.friction.efficiency import efficiency as efficiency

    # isort: on
    from bristle.models.friction.irregular import spectrum
    from bristle.models.friction.slots import PARAMETERS_OF_SLOTS, WHAT_SLOTS_DO
    from bristle.models.friction.uneven import uneven

__getattr__ = loaded_from(__name__)

MODELS: Mapping[str, FrictionModel] = Family(__name__, "uneven")
"""Every friction model, by name."""

DEFAULT_MODELS = "coulomb_viscous,stribeck+asymmetry,lugre+asymmetry"
"""Models that `identify` fits and compares by default: two static models, and one model with pre-sliding."""

__all__ = [
    "CHANNEL_SLOTS",
    "DEFAULT_MODELS",
    "MODELS",
    "base_of",
    "channel_slots_of",
    "find",
    "is_static",
    "slotted",
    "unvaried",
    "with_presliding",
    "with_slots",
    "without_presliding",
]


def __dir__() -> list[str]:
    """Return the names for completion: the models, and the functions that return a model."""
    return [*MODELS, "find", "with_presliding", "with_slots"]


def find(name: str, path: str = "friction.model") -> SlottedModel:
    """Return the model with this name and slots, such as ``"lugre+asymmetry"``; the result also takes an ``offset``.

    Raises
    ------
    InputError
        If there is no such model or slot.
    """
    if not isinstance(name, str):
        raise InputError(
            "must be the name of a friction model", path=path, value=name, allowed=", ".join(MODELS)
        )
    return _named(name, path)


@cache
def _named(name: str, path: str) -> SlottedModel:
    base, *slots = name.split("+")
    if base not in MODELS:
        raise InputError(
            "no such friction model",
            path=path,
            value=base,
            allowed=", ".join(MODELS),
            mend=did_you_mean(base, MODELS),
        )
    return with_slots(MODELS[base], slots, path)


def _slots(value: Any, path: str, kind: Any) -> tuple[str | Slot, ...]:
    """Take slots by name, or slots of the user."""
    if isinstance(value, (tuple, list)):
        return tuple(slot if isinstance(slot, Slot) else TEXT(slot, path, kind) for slot in value)
    return (value,) if isinstance(value, Slot) else NAMES(value, path, kind)


@guarded(model=component("friction"), slots=_slots)
def with_slots(
    model: FrictionModel, slots: Sequence[str | Slot], path: str = "friction.model"
) -> SlottedModel:
    """Return `model` with these slots: names, or user-defined slots.

    Raises
    ------
    InputError
        If there is no such slot, a slot is given twice, or a user-defined slot does not fit the model.
    """
    own = [slot for slot in slots if isinstance(slot, Slot)]
    names = [slot for slot in slots if isinstance(slot, str)]
    written = [*names, *(slot.name for slot in own)]
    if len(set(written)) < len(written):
        raise InputError(
            "has a slot twice",
            path=path,
            value="+".join(["", *written]),
            mend="Write each slot once",
        )
    operators = [slot for slot in names if slot in OPERATOR_SLOTS]
    if operators:
        model, names = (
            _over(model, operators, path),
            [slot for slot in names if slot not in OPERATOR_SLOTS],
        )
    for slot in names:
        if slot not in SLOTS:
            raise InputError(
                "no such slot",
                path=path,
                value=f"+{slot}",
                allowed=f"{', '.join(f'+{known_slot}' for known_slot in SLOTS)}, or a file of yours, such as +my_slot.py",
            )
    model = varied(risen(model, names), names)
    for slot in (*(slot for name, slot in CHANNEL_SLOTS.items() if name in names), *own):
        model = with_channel_slot(model, slot)
    return slotted(model, asymmetry="asymmetry" in names)


def _over(model: FrictionModel, names: Sequence[str], path: str) -> FrictionModel:
    """Return a friction model over the named operator."""
    from bristle.models.friction.operator_kernel import TakesOperator, over_operator

    if not isinstance(model, TakesOperator) or len(names) > 1:
        raise InputError(
            "has too many operators: preisach_lugre and preisach_contact take one operator, other models take no operator",
            path=path,
            value="+".join([model.name, *names]),
        )
    return over_operator(model, OPERATORS[names[0]])
