"""What is demanded of a slot of a person's own: a factor that is one, and friction that stays friction with it.

Each check runs the slot itself, around models of bristle; the first sentence of its docstring says what is demanded.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import wraps
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.slot import Slot, refuse_unfit
from bristle.engine import force_along, interpreted
from bristle.exports.proof import compiler, proved
from bristle.friction import coulomb_viscous, lugre, with_slots
from bristle.friction.variation import SMALLEST_FACTOR
from bristle.testing.bits import compiled_as_plain
from bristle.testing.check import Demand, Fact, UnmetError

__all__ = [
    "described_parameters",
    "factor_above_zero",
    "model_with",
    "neutral_defaults",
    "on_a_model",
    "same_bits_along_its_channel",
    "same_bits_exported",
]

SEED, COUNT = 20260, 41
WIDTH = 0.2  # of the usual value, where a channel has no range
ROUNDING = 1e-12


def range_of(slot: Slot) -> tuple[float, float]:
    """Return between which values a channel is tried: its range, else around its usual value."""
    variable, usual = slot.channel.variable, slot.channel.usual
    beside = WIDTH * max(abs(usual), variable.nominal)
    low, high = variable.min, variable.max
    return low if math.isfinite(low) else usual - beside, high if math.isfinite(high) else usual + beside


def model_with(slot: Slot, base: Any = lugre) -> Model:
    """Return a model of bristle with a slot, with the example parameters of both."""
    component = with_slots(base, [slot])
    return component(kind="translational", **component.example)


def _factors(slot: Slot, parameters: Any) -> np.ndarray:
    with interpreted():
        return np.array([slot.factor(float(value), parameters) for value in np.linspace(*range_of(slot), COUNT)])


def described_parameters(slot: Slot) -> Fact:
    """Every parameter carries a Variable and a default, and one at least is told by a log."""
    try:
        refuse_unfit(slot)
    except InputError as error:
        raise UnmetError(f"{error.path} {error.message}", error.mend or error.allowed) from None
    unknown = [name for name in slot.example if name not in slot.variables]
    if unknown:
        raise UnmetError(f"the example gives {unknown[0]}", f"It has {', '.join(slot.variables)}")
    return Fact(f"{len(slot.variables)} parameters, {len(slot.identified)} to be identified")


def neutral_defaults(slot: Slot) -> Fact:
    """With its defaults a slot changes nothing: the factor is 1, whatever the channel."""
    apart = float(np.max(np.abs(_factors(slot, slot.neutral) - 1.0)))
    fact = Fact(f"largest difference from 1: {apart:.3g}", apart, "1", ROUNDING)
    if not apart <= ROUNDING:
        raise UnmetError(fact, "Take other defaults, such as 0 for a coefficient: with them friction must not vary")
    return fact


def factor_above_zero(slot: Slot) -> Fact:
    """Over the range of its channel the factor of the example is finite, above zero, and not everywhere the same."""
    factors = _factors(slot, slot.assemble(slot.defaults | dict(slot.example)))
    low, high = range_of(slot)
    ends = f"{slot.channel.name} from {low:g} to {high:g} {slot.channel.variable.unit().removesuffix('1')}".rstrip()
    detail = f"{np.min(factors):.4g} to {np.max(factors):.4g} for {ends}"
    fact = Fact(detail, float(np.min(factors)), "1", SMALLEST_FACTOR)
    if not np.all(np.isfinite(factors)) or np.min(factors) <= SMALLEST_FACTOR:
        raise UnmetError(fact, "Friction must not change its sign: take another equation, example or range")
    if np.ptp(factors) <= ROUNDING:
        raise UnmetError(fact, "Give the slot example={...} with values by which friction varies")
    return fact


def on_a_model(check: Demand) -> Demand:
    """Return a demand on friction models as one on a slot: a model of bristle with the slot meets it."""

    @wraps(check)
    def demand(slot: Any) -> Any:
        return check(model_with(slot))

    return demand


def same_bits_along_its_channel(slot: Slot) -> Fact:
    """Plain Python and compiled code agree to the bit while the channel changes."""
    model, generator = model_with(slot), np.random.default_rng(SEED)
    x = np.cumsum(generator.standard_normal(400)) * 1e-6
    v, name = np.diff(x) / 1e-3, slot.channel.name
    signals = {} if slot.channel.field == "x" else {name: np.linspace(*range_of(slot), v.size)}
    return compiled_as_plain(lambda: force_along(model, v, 1e-3, x[1:], **signals), model.kind)


def same_bits_exported(slot: Slot) -> Fact:
    """Give the bits of plain Python when exported to C, at both ends of the channel, where there is a C compiler."""
    command = compiler()
    if command is None:
        return Fact("no C compiler here", applies=False)
    total = 0
    for usual in (slot.channel.usual,) if slot.channel.field == "x" else range_of(slot):
        # What is the usual value of a channel is what the self-test of an export runs with.
        channel = replace(slot.channel, usual=usual) if slot.channel.is_own else slot.channel
        # There is one model for slots that are equal, and one that was made here would stand in no module.
        tried = slot if channel == slot.channel else replace(slot, channel=channel)
        steps, message = proved(model_with(tried, coulomb_viscous), command)
        total += steps
        if message:
            raise UnmetError(message, "Use bristle.core.mathematics, not math or **")
    return Fact(f"{total} steps compiled by {command}")
