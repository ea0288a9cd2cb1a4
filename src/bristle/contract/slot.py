"""The contract of control laws, sensors and user slots; the first sentence of the docstring of a check states the demand."""

import math
from dataclasses import replace
from functools import wraps
from typing import Any

import numpy as np

from bristle.contract.check import Demand, Fact, UnmetError, compiled_as_plain, judged
from bristle.core import InputError, Model, unit_of
from bristle.core.motion import Reference
from bristle.core.slot import Slot, refuse_unfit
from bristle.engine import force_along, interpreted, run_closed_loop
from bristle.engine.translation.build import Builder
from bristle.engine.translation.scope import NotExportableError, is_kernel
from bristle.engine.translation.tree import REAL, struct_of, type_of
from bristle.exports.c import compiler, proved
from bristle.models.controllers import cascade
from bristle.models.friction import coulomb, coulomb_viscous, lugre, with_slots
from bristle.models.friction.variation import SMALLEST_FACTOR
from bristle.models.plants import inertia
from bristle.models.sensors import encoder

SEED = 20260
COUNT = 41
WIDTH = 0.2  # of the usual value, if a channel has no range
ROUNDING = 1e-12


def range_of(slot: Slot) -> tuple[float, float]:
    """Return the range of a channel for tests: its own, or a range around its usual value."""
    variable = slot.channel.variable
    usual = slot.channel.usual
    beside = WIDTH * max(abs(usual), variable.nominal)
    low = variable.min
    high = variable.max
    if not math.isfinite(low):
        low = usual - beside
    if not math.isfinite(high):
        high = usual + beside
    return low, high


def model_with(slot: Slot, base: Any = lugre) -> Model:
    """Return a built-in model with a slot, with the example parameters of both."""
    component = with_slots(base, [slot])
    return component(kind="translational", **component.example)


def _factors(slot: Slot, parameters: Any) -> np.ndarray:
    with interpreted():
        return np.array(
            [slot.factor(float(value), parameters) for value in np.linspace(*range_of(slot), COUNT)]
        )


def described_parameters(slot: Slot) -> Fact:
    """Every parameter has a Variable and a default, and at least one is identified from a log."""
    try:
        refuse_unfit(slot)
    except InputError as error:
        raise UnmetError(f"{error.path} {error.message}", error.mend or error.allowed) from None
    unknown = [name for name in slot.example if name not in slot.variables]
    if unknown:
        raise UnmetError(f"the example gives {unknown[0]}", f"It has {', '.join(slot.variables)}")
    return Fact(f"{len(slot.variables)} parameters, {len(slot.identified)} to be identified")


def neutral_defaults(slot: Slot) -> Fact:
    """With its defaults a slot has no effect: the factor is 1 for every value of the channel."""
    apart = float(np.max(np.abs(_factors(slot, slot.neutral) - 1.0)))
    return judged(
        Fact(f"largest difference from 1: {apart:.3g}", apart, "1", ROUNDING),
        "Give other defaults, such as 0 for a coefficient: with the defaults friction must not vary",
        unmet=not apart <= ROUNDING,
    )


def factor_above_zero(slot: Slot) -> Fact:
    """Over the range of its channel the factor of the example is finite and positive, and varies."""
    factors = _factors(slot, slot.assemble(slot.defaults | dict(slot.example)))
    low, high = range_of(slot)
    ends = f"{slot.channel.name} from {low:g} to {high:g} {slot.channel.variable.unit().removesuffix('1')}".rstrip()
    fact = Fact(
        f"{np.min(factors):.4g} to {np.max(factors):.4g} for {ends}",
        float(np.min(factors)),
        "1",
        SMALLEST_FACTOR,
    )
    if not np.all(np.isfinite(factors)) or np.min(factors) <= SMALLEST_FACTOR:
        raise UnmetError(
            fact, "Friction must not change its sign: change the equation, the example or the range"
        )
    if np.ptp(factors) <= ROUNDING:
        raise UnmetError(fact, "Give the slot example={...} with values that make friction vary")
    return fact


def on_a_model(check: Demand) -> Demand:
    """Turn a demand on friction models into a demand on slots: a built-in model with the slot meets it."""

    @wraps(check)
    def demand(slot: Any) -> Any:
        return check(model_with(slot))

    return demand


def same_bits_along_its_channel(slot: Slot) -> Fact:
    """Plain Python and compiled code agree to the bit with a changing channel."""
    model = model_with(slot)
    generator = np.random.default_rng(SEED)
    x = np.cumsum(generator.standard_normal(400)) * 1e-6
    v = np.diff(x) / 1e-3
    signals = {}
    if slot.channel.field != "x":
        signals[slot.channel.name] = np.linspace(*range_of(slot), v.size)
    return compiled_as_plain(lambda: force_along(model, v, 1e-3, x[1:], **signals), model.kind)


def same_bits_exported(slot: Slot) -> Fact:
    """Give the bits of plain Python when exported to C, at both ends of the channel, if there is a C compiler."""
    command = compiler()
    if command is None:
        return Fact("no C compiler here", applies=False)
    total = 0
    values = range_of(slot)
    if slot.channel.field == "x":
        values = (slot.channel.usual,)
    for usual in values:
        steps, message = proved(model_with(_with_usual(slot, usual), coulomb_viscous), command)
        total += steps
        if message:
            raise UnmetError(message, "Use bristle.core.mathematics, not math or **")
    return Fact(f"{total} steps compiled by {command}")


def _with_usual(slot: Slot, usual: float) -> Slot:
    """Return a slot with another usual value of its own channel: the self-test of an export runs with this value."""
    if not slot.channel.is_own or usual == slot.channel.usual:
        # Equal slots share one model; a model made here would belong to no module.
        return slot
    return replace(slot, channel=replace(slot.channel, usual=usual))


DT = 1e-3
SAMPLES = 400
AMPLITUDE = 1e-3  # [m]
FREQUENCY = 5.0  # [Hz]


def law_kernels(model: Model) -> Fact:
    """Keep the functions of a law in the subset of Python that can be compiled and exported."""
    reference = struct_of(Reference, [REAL] * len(Reference._fields))
    state = type_of(_begun(model))
    p = type_of(model.parameters)
    built = [
        _built(model.component.start, [REAL, REAL, REAL, REAL, p]),
        _built(model.component.step, [state, reference, REAL, REAL, p]),
    ]
    if model.component.resume is not None:
        built.append(_built(model.component.resume, [state, reference, REAL, REAL, REAL, p]))
    return Fact(f"{sum(built)} kernels", 0.0, "1", 0.0)


def sensor_kernels(model: Model) -> Fact:
    """Keep the functions of a sensor in the subset of Python that can be compiled and exported."""
    state, p = (type_of(value) for value in (model.component.State(), model.parameters))
    return Fact(f"{_built(model.component.step, [state, REAL, REAL, p])} kernels", 0.0, "1", 0.0)


def law_results(model: Model) -> Fact:
    """Return a finite effort and a state from a step, and a state from a start; the same call gives the same result."""
    reference = Reference(2e-6, 1e-3, 0.0, 0.5)
    p = model.parameters
    state = _begun(model)
    if type(state) is not model.component.State:
        raise UnmetError(f"start returned a {type(state).__name__}", "Return a State from start")
    return _sampled(
        model, "effort", lambda: model.component.step(state, reference, 1e-6, DT, p), "force"
    )


def sensor_results(model: Model) -> Fact:
    """Return a finite position and a state from a step; the same call gives the same result."""
    state = model.component.State()
    return _sampled(
        model, "position", lambda: model.component.step(state, 1e-6, DT, model.parameters), "length"
    )


def same_bits_in_a_loop(model: Model) -> Fact:
    """Plain Python and compiled code agree to the bit, in a loop around a mass with friction."""
    law = model if model.component.family == "controller" else cascade(k_p=50.0, k_v=100.0)
    sensor = model if model.component.family == "sensor" else encoder(resolution=1e-7)
    return compiled_as_plain(lambda: _effort_of_loop(law, sensor), law.kind)


FORM_OF_SAMPLED = (law_kernels, sensor_kernels, law_results, sensor_results)
LAW_CHECKS = (law_kernels, law_results, same_bits_in_a_loop)
SENSOR_CHECKS = (sensor_kernels, sensor_results, same_bits_in_a_loop)


def _begun(model: Model) -> Any:
    return model.component.start(0.0, 0.0, 0.0, DT, model.parameters)


def _built(function: Any, types: list[Any]) -> int:
    """Return the number of functions in the tree of a kernel."""
    if not is_kernel(function):
        raise UnmetError(
            f"{function.__name__} is not a kernel", "Decorate it with @kernel from bristle.core"
        )
    builder = Builder()
    try:
        builder.function(function, types)
    except NotExportableError as error:
        raise UnmetError(Fact(str(error), 1, "1", 0.0)) from None
    return len(builder.unit.functions)


def _sampled(model: Model, output: str, step: Any, quantity: str) -> Fact:
    value, after = step()
    if not isinstance(value, (float, int)) or not math.isfinite(value):
        raise UnmetError(
            f"the {output} is {type(value).__name__} {value!r:.40}",
            f"Return ({output}, state) with finite numbers",
        )
    if type(after) is not model.component.State:
        raise UnmetError(
            f"step returned a {type(after).__name__} as its state", f"Return ({output}, State(...))"
        )
    if step() != (value, after):
        raise UnmetError(
            "the same step later gave a different result", "Keep no state outside State"
        )
    return Fact(value=float(value), unit=unit_of(quantity, model.kind))


def _effort_of_loop(law: Model, sensor: Model) -> np.ndarray:
    turn = 2.0 * np.pi * FREQUENCY
    angle = turn * DT * np.arange(SAMPLES)
    reference = AMPLITUDE * np.array(
        [1.0 - np.cos(angle), turn * np.sin(angle), turn**2 * np.cos(angle), 0.0 * angle]
    )
    return np.asarray(
        run_closed_loop(inertia(M=1.0), coulomb(F_C=0.1), law, sensor, reference, DT).effort
    )
