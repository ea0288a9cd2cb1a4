"""The contract of what runs once a sample, ours or a user's: control laws and sensors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from bristle.controllers import cascade
from bristle.core.contracts import Model
from bristle.core.motion import Reference
from bristle.core.variable import unit_of
from bristle.engine import interpreted, run_closed_loop
from bristle.exports.build import Builder
from bristle.exports.scope import NotExportableError, is_kernel
from bristle.exports.tree import REAL, struct_of, type_of
from bristle.friction import coulomb
from bristle.plants import inertia
from bristle.sensors import encoder
from bristle.testing.check import Fact, UnmetError

__all__ = ["FORM_OF_SAMPLED", "LAW_CHECKS", "SENSOR_CHECKS"]

DT, SAMPLES = 1e-3, 400
AMPLITUDE, FREQUENCY = 1e-3, 5.0  # [m] [Hz]


def law_kernels(model: Model) -> Fact:
    """Keep the functions of a law in the part of Python that can be compiled and exported."""
    reference = struct_of(Reference, [REAL] * len(Reference._fields))
    state, p = type_of(_begun(model)), type_of(model.parameters)
    built = [_built(model.component.start, [REAL, REAL, REAL, REAL, p]), _built(model.component.step, [state, reference, REAL, REAL, p])]
    if model.component.resume is not None:
        built.append(_built(model.component.resume, [state, reference, REAL, REAL, REAL, p]))
    return Fact(f"{sum(built)} kernels", 0.0, "1", 0.0)


def sensor_kernels(model: Model) -> Fact:
    """Keep the functions of a sensor in the part of Python that can be compiled and exported."""
    state, p = (type_of(value) for value in (model.component.State(), model.parameters))
    return Fact(f"{_built(model.component.step, [state, REAL, REAL, p])} kernels", 0.0, "1", 0.0)


def law_results(model: Model) -> Fact:
    """Return a finite effort and a state from a step, a state from a start; the same call gives the same twice."""
    reference, p = Reference(2e-6, 1e-3, 0.0, 0.5), model.parameters
    state = _begun(model)
    if type(state) is not model.component.State:
        raise UnmetError(f"start returned a {type(state).__name__}", "start returns a State")
    return _sampled(model, "effort", lambda: model.component.step(state, reference, 1e-6, DT, p), "force")


def sensor_results(model: Model) -> Fact:
    """Return a finite position and a state from a step; the same call gives the same twice."""
    state = model.component.State()
    return _sampled(model, "position", lambda: model.component.step(state, 1e-6, DT, model.parameters), "length")


def same_bits_in_a_loop(model: Model) -> Fact:
    """Plain Python and compiled code agree to the bit, in a loop around a mass with friction."""
    law = model if model.component.family == "controller" else cascade(k_p=50.0, k_v=100.0)
    sensor = model if model.component.family == "sensor" else encoder(resolution=1e-7)
    fast = _effort_of_loop(law, sensor)
    with interpreted():
        slow = _effort_of_loop(law, sensor)
    if fast.tobytes() != slow.tobytes():
        worst = float(np.max(np.abs(fast - slow)))
        fact = Fact(f"largest difference {worst:.3g} in {fast.size} samples", worst, unit_of("force", law.kind), 0.0)
        raise UnmetError(fact, "Use bristle.core.mathematics, not math or **")
    return Fact(f"{fast.size} samples", 0.0, unit_of("force", law.kind), 0.0)


FORM_OF_SAMPLED = (law_kernels, sensor_kernels, law_results, sensor_results)
LAW_CHECKS = (law_kernels, law_results, same_bits_in_a_loop)
SENSOR_CHECKS = (sensor_kernels, sensor_results, same_bits_in_a_loop)


def _begun(model: Model) -> Any:
    return model.component.start(0.0, 0.0, 0.0, DT, model.parameters)


def _built(function: Any, types: list[Any]) -> int:
    """Return how many functions of the tree a kernel becomes."""
    if not is_kernel(function):
        raise UnmetError(f"{function.__name__} is not a kernel", "Decorate it with @kernel from bristle.core")
    builder = Builder()
    try:
        builder.function(function, types)
    except NotExportableError as error:
        raise UnmetError(Fact(str(error), 1, "1", 0.0)) from None
    return len(builder.unit.functions)


def _sampled(model: Model, output: str, step: Any, quantity: str) -> Fact:
    value, after = step()
    if not isinstance(value, (float, int)) or not math.isfinite(value):
        raise UnmetError(f"the {output} is {type(value).__name__} {value!r:.40}", f"Return ({output}, state), both finite")
    if type(after) is not model.component.State:
        raise UnmetError(f"step returned a {type(after).__name__} as its state", f"Return ({output}, State(...))")
    if step() != (value, after):
        raise UnmetError("the same step gave another result later", "Keep no state outside State")
    return Fact(value=float(value), unit=unit_of(quantity, model.kind))


def _effort_of_loop(law: Model, sensor: Model) -> np.ndarray:
    turn = 2.0 * np.pi * FREQUENCY
    angle = turn * DT * np.arange(SAMPLES)
    reference = AMPLITUDE * np.array([1.0 - np.cos(angle), turn * np.sin(angle), turn**2 * np.cos(angle), 0.0 * angle])
    return np.asarray(run_closed_loop(inertia(M=1.0), coulomb(F_C=0.1), law, sensor, reference, DT).effort)
