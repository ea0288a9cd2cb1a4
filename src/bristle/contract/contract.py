"""The contract suite of friction models; the first sentence of the docstring of a check states the demand."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from bristle.contract import slot
from bristle.contract.check import (
    Check,
    Demand,
    Fact,
    UnmetError,
    compiled_as_plain,
    judged,
    outcomes,
)
from bristle.contract.dimensions import one_dimension
from bristle.contract.slot import FORM_OF_SAMPLED, LAW_CHECKS, SENSOR_CHECKS
from bristle.core import (
    Controller,
    FrictionModel,
    InputError,
    Model,
    Motion,
    Sensor,
    Slot,
    Status,
    error_text,
    example_of,
    number,
    unit_of,
    variables_of,
)
from bristle.core.documented import Documented
from bristle.core.kernel import kernels
from bristle.core.packing import pack, structure_of, unpacker
from bristle.engine import force_along, interpreted, run_open_loop, settled
from bristle.engine.derivatives import force_with_derivatives
from bristle.engine.motion import along
from bristle.engine.translation.scope import NotExportableError
from bristle.exports.c import compiler, proved
from bristle.exports.subject import kernels_of
from bristle.models.friction import find
from bristle.models.plants import inertia

SEED = 20260
BESIDE = 1.003  # times a parameter: a point near the example
NUDGE = 1e-6  # of a parameter: step of a difference
LIKE_DIFFERENCES = 1e-4  # of the largest derivative: allowed deviation from differences


def check_model(
    model: FrictionModel | Slot | Controller | Sensor | Model | str,
    *,
    checks: Sequence[Demand] | None = None,
) -> list[Check]:
    """Run the contract suite on a friction model, a slot, a control law or a sensor.

    Parameters
    ----------
    model : FrictionModel, Slot, Controller, Sensor, Model or str
        A descriptor or the name of a friction model, checked with its example parameters, or a model with its own
        parameters.
    checks : sequence of callable, optional
        Some of `CHECKS`; by default all demands for this kind.

    Returns
    -------
    list of Check
        One for each demand, in order; if a demand of the form is not met, those of the physics are skipped.
    """
    resolved = find(model, "model") if isinstance(model, str) else model
    demands = next(
        (
            checks_of
            for family, checks_of in DEMANDS.items()
            if isinstance(getattr(resolved, "component", resolved), family)
        ),
        None,
    )
    if demands is None:
        raise InputError(
            "is not a friction model, slot, control law or sensor",
            path="model",
            value=model,
            mend="Give a model, its descriptor or its name",
        )
    try:
        bound: Any = resolved if isinstance(resolved, (Model, Slot)) else example_of(resolved)
    except Exception as error:  # noqa: BLE001  (a user's descriptor may have any content)
        return [
            Check(
                "example",
                False,
                error_text(error),
                "Give the descriptor example={...} with typical values",
            )
        ]
    if checks is None:
        checks = demands
    return outcomes(checks, bound, FORM_OF_ALL)


# --- the form ---------------------------------------------------------------------------------------------------


def described_variables(model: Model) -> Fact:
    """Every parameter and every state variable has a Variable; states are scalars with a default."""
    component = model.component
    if not component.variables and component.Parameters._fields:
        raise UnmetError("no parameter is described", "Annotate each field with Variable(...)")
    variables_of(component.State)
    try:
        state = component.State()
    except TypeError as error:
        raise UnmetError(
            f"State() has no defaults ({error})", "Give every field of State a virgin value"
        ) from None
    for name, value in state._asdict().items():
        if not isinstance(value, (int, float)):
            raise UnmetError(
                f"State.{name} is not a scalar", "Put arrays into the memory, not into the state"
            )
    return Fact(f"{len(component.variables)} parameters, {len(state)} states")


def exportable_kernels(model: Model) -> Fact:
    """Keep the functions in the subset of Python that can be compiled and exported; each is built for other targets."""
    component = model.component
    optional = component.rate, component.piece, component.flow, component.arrival
    functions = [
        component.trial,
        component.commit,
        *(function for function in optional if function),
    ]
    for function in functions:
        if function not in kernels():
            raise UnmetError(
                f"{function.__name__} is not a kernel", "Decorate it with @kernel from bristle.core"
            )
    try:
        built = kernels_of(model)
    except NotExportableError as error:
        raise UnmetError(Fact(str(error), 1, "1", 0.0)) from None
    return Fact(f"{len(built)} kernels", 0.0, "1", 0.0)


def scalar_results(model: Model) -> Fact:
    """Return a finite force and a NamedTuple of scalars from a trial, and a state from a commit."""
    state, memory = _virgin(model)
    force, move = model.component.trial(state, memory, Motion(1e-3, 1e-6), 1e-3, model.parameters)
    if not isinstance(force, (float, int)) or not np.isfinite(force):
        raise UnmetError(
            f"the force is {type(force).__name__} {force!r:.40}",
            "Return (force, move) with finite numbers",
        )
    if not hasattr(move, "_fields"):
        raise UnmetError(
            f"the move is a {type(move).__name__}",
            "Return (force, move), where move is a NamedTuple of scalars",
        )
    after = model.component.commit(state, memory, move, model.parameters)
    if type(after) is not type(state):
        raise UnmetError(f"commit returned a {type(after).__name__}", "Return a State from commit")
    return Fact(value=float(force), unit=unit_of("force", model.kind))


# --- what a trial may do ----------------------------------------------------------------------------------------


def pure_trial(model: Model) -> Fact:
    """Change no state in a trial: the same call gives the same bits, and 1000 random trials leave the memory unchanged."""
    state, memory = _used(model)
    before = _bytes_of(memory)
    p = model.parameters
    trial = model.component.trial
    first = trial(state, memory, Motion(1e-3, 0.0), 1e-3, p)
    for motion, dt in _motions(1000):
        trial(state, memory, motion, dt, p)
        if _bytes_of(memory) != before:
            raise UnmetError(
                f"a trial at v = {motion.v:g} wrote into the memory", "Write in commit only"
            )
    again = trial(state, memory, Motion(1e-3, 0.0), 1e-3, p)
    if first != again:
        raise UnmetError(
            "the same trial later gave a different result", "Keep no state outside State and memory"
        )
    return Fact("1000 trials")


def finite_everywhere(model: Model) -> Fact:
    """Give a finite force for every velocity and step: zero of both signs, tiny, huge, and a step of zero length."""
    state, memory = _used(model)
    speeds = (0.0, -0.0, 1e-300, -1e-300, 1e-12, 1e-3, -1e-3, 1.0, -1e3, 1e6)
    tried = [(v, dt) for v in speeds for dt in (0.0, 1e-9, 1e-3, 1.0)]
    forces = [
        model.component.trial(state, memory, Motion(v, 0.0), dt, model.parameters)[0]
        for v, dt in tried
    ]
    bad = [
        f"the force is {force} at v = {v:g}, dt = {dt:g}"
        for force, (v, dt) in zip(forces, tried, strict=True)
        if not np.isfinite(force)
    ]
    if bad:
        raise UnmetError(Fact(bad[0], len(bad), "1", 0.0), "Guard divisions and exponents")
    return Fact(f"{len(tried)} pairs of velocity and step", 0.0, "1", 0.0)


# --- what friction does -----------------------------------------------------------------------------------------


def one_sided_limits(model: Model) -> Fact:
    """At rest the limit from forward motion is not below that from backward motion: friction opposes both."""
    state, memory = _used(model)
    forward, _ = model.component.trial(state, memory, Motion(0.0, 0.0), 1e-3, model.parameters)
    backward, _ = model.component.trial(state, memory, Motion(-0.0, 0.0), 1e-3, model.parameters)
    least = -1e-12 * abs(backward)
    advice = "Use direction(v), which distinguishes +0 and -0, instead of a comparison with zero"
    if forward == -backward:
        advice = "Check signs"
    return judged(
        Fact(
            f"F(+0) = {forward:g}, F(-0) = {backward:g}",
            forward - backward,
            unit_of("force", model.kind),
            least,
        ),
        advice,
        unmet=forward - backward < least,
    )


def opposes_sliding(model: Model) -> Fact:
    """In steady sliding the force, less its mean over both directions, opposes the motion."""
    steady = [
        (_steady(model, speed), _steady(model, -speed), speed) for speed in (1e-4, 1e-3, 1e-2, 1e-1)
    ]
    forward, backward, speed = min(steady, key=lambda entry: entry[0] - entry[1])
    return judged(
        Fact(
            f"smallest force at {speed:g} {unit_of('length/time', model.kind)}: {forward:g} forward, {backward:g} backward",
            forward - backward,
            unit_of("force", model.kind),
            0.0,
        ),
        "Check signs",
        unmet=forward < backward,
    )


def dissipates(model: Model) -> Fact:
    """Over closed cycles of random amplitude, the force dissipates energy after the first cycle."""
    generator = np.random.default_rng(SEED)
    least = np.inf
    for _ in range(20):
        amplitude = 10 ** generator.uniform(-7, -2)
        count = 400
        x = amplitude * np.sin(2 * np.pi * np.arange(3 * count + 1) / count)
        v = np.diff(x) / 1e-3
        force = force_along(model, v, 1e-3, x[1:])[count:]
        step = v[count:] * 1e-3
        scale = float(np.sum(np.abs(force * step))) or 1.0
        least = min(least, float(np.sum(force * step)) / scale)
    if least < -1e-9:
        detail = f"a closed cycle returned {number(-100.0 * least, digits=2)} % of the work"
        raise UnmetError(Fact(detail, least, "1", -1e-9), "Friction cannot produce energy")
    return Fact(f"smallest dissipated share {least:.3f}", least, "1", -1e-9)


def refines(model: Model) -> Fact:
    """Halving the step reduces the change of the mean force: the step has an order of convergence."""
    errors = []
    for division in (1, 2, 4, 8):
        count = 200 * division
        x = 2e-5 * np.sin(2 * np.pi * np.arange(count + 1) / count) + 5e-6 * np.sin(
            14 * np.pi * np.arange(count + 1) / count
        )
        v = np.diff(x) / (1.0 / count)
        force = force_along(model, v, 1.0 / count, x[1:])
        errors.append(force.reshape(200, division).mean(axis=1))
    scale = float(np.max(np.abs(errors[-1]))) or 1.0
    steps = [float(np.sqrt(np.mean((a - b) ** 2))) / scale for a, b in pairwise(errors)]
    most = 0.8 * steps[0] + 1e-9
    return judged(
        Fact(
            f"relative changes {', '.join(f'{change:.1e}' for change in steps)}",
            steps[-1],
            "1",
            most,
        ),
        "Return the mean force over the step",
        unmet=steps[-1] > most,
    )


def rate_agrees(model: Model) -> Fact:
    """If the model has a rate, small steps of trial and commit follow it."""
    component = model.component
    p = model.parameters
    if component.rate is None:
        return Fact("no rate", applies=False)
    dt = 1e-7
    worst = 0.0
    for v in (1e-3, -2e-3, 5e-3):
        state, memory = _used(model)
        for _ in range(20):
            motion = Motion(v, 0.0)
            force, slope = component.rate(state, motion, p)
            mean, move = component.trial(state, memory, motion, dt, p)
            after = component.commit(state, memory, move, p)
            expected = np.array(state, dtype=float) + dt * np.array(slope, dtype=float)
            error = np.max(np.abs(np.array(after) - expected)) / (np.max(np.abs(expected)) + 1e-300)
            worst = max(worst, float(error), abs(mean - force) / (abs(force) + 1e-9))
            state = after
    return judged(
        Fact(f"largest relative difference {worst:.1e}", worst, "1", 1e-3),
        "Use the same equations in rate and trial",
        unmet=worst > 1e-3,
    )


def flow_agrees(model: Model) -> Fact:
    """If the model has a flow, small steps of trial and commit follow it from event to event."""
    component = model.component
    p = model.parameters
    parts = component.piece, component.flow, component.arrival
    if not any(parts):
        return Fact("no flow", applies=False)
    if not all(parts):
        raise UnmetError(
            "piece, flow and arrival are not all given",
            "These three functions work together: give all three, or omit all three",
        )
    dt = 1e-7
    worst = 0.0
    for v in (1e-3, -2e-3, 5e-3, -1e-4):
        state, memory = _used(model)
        for _ in range(20):
            motion = Motion(v, 0.0)
            contact, piece = component.piece(state, memory, motion, p)
            force, slope, margin = component.flow(contact, piece, motion, p)
            if margin < 0.0:
                raise UnmetError(
                    f"a piece begins {-margin:.1e} past its end",
                    "Use the same event in piece and flow",
                )
            mean, move = component.trial(state, memory, motion, dt, p)
            state = component.commit(state, memory, move, p)
            for name, before, change in zip(contact._fields, contact, slope, strict=True):
                expected = before + dt * change
                worst = max(worst, abs(getattr(state, name) - expected) / (abs(expected) + 1e-300))
            worst = max(worst, abs(mean - force) / (abs(force) + 1e-9))
    return judged(
        Fact(f"largest relative difference {worst:.1e}", worst, "1", 1e-3),
        "Use the same equations in flow and trial",
        unmet=worst > 1e-3,
    )


# --- how it runs ------------------------------------------------------------------------------------------------


def same_bits_compiled(model: Model) -> Fact:
    """Plain Python and compiled code agree to the bit."""
    x = np.cumsum(np.random.default_rng(SEED).standard_normal(400)) * 1e-6
    v = np.diff(x) / 1e-3
    return compiled_as_plain(lambda: force_along(model, v, 1e-3, x[1:]), model.kind)


def derivatives_agree(model: Model) -> Fact:
    """Have finite derivatives along a motion that agree with one-sided differences."""
    x = np.cumsum(np.random.default_rng(SEED).standard_normal(150)) * 1e-6
    unpack = unpacker(structure_of(model.parameters))
    # A little off the example: a law may have a special form for one value of an exponent.
    numbers = pack(model.parameters)
    reals = np.array(_reals(model.parameters), dtype=bool)
    numbers[reals] *= BESIDE
    directions = np.diag(np.where(np.isfinite(numbers) & reals, numbers, 0.0))[
        :, np.isfinite(numbers) & reals & (numbers != 0.0)
    ]

    def force(numbers: np.ndarray) -> np.ndarray:
        return along(
            Model(model.component, unpack(numbers), model.kind), np.diff(x) / 1e-3, 1e-3, x[1:]
        )

    worst = 0.0
    with interpreted(), np.errstate(all="ignore"):
        beside = Model(model.component, unpack(numbers), model.kind)
        here, derivatives = force_with_derivatives(
            beside, directions, np.diff(x) / 1e-3, 1e-3, x[1:]
        )
        for derivative, direction in zip(derivatives.T, directions.T, strict=True):
            differences = np.array(
                [(force(numbers + nudge * direction) - here) / nudge for nudge in (NUDGE, -NUDGE)]
            )
            error = np.median(np.min(np.abs(derivative - differences), axis=0)) / max(
                float(np.max(np.abs(differences))), 1e-300
            )
            if not np.all(np.isfinite(derivative)):
                error = np.inf
            worst = max(worst, float(error))
    if not worst <= LIKE_DIFFERENCES:
        raise UnmetError(
            f"derivatives and differences differ by {worst:.2g} of the largest",
            "Report this failure: it is a fault of bristle",
        )
    return Fact(f"{directions.shape[1]} derivatives", worst, "1", LIKE_DIFFERENCES)


def same_bits_exported(model: Model) -> Fact:
    """Give the bits of plain Python when exported to C and compiled, if there is a C compiler."""
    command = compiler()
    if command is None:
        return Fact("no C compiler here", applies=False)
    steps, message = proved(model, command)
    if message:
        raise UnmetError(message, "Use bristle.core.mathematics, not math or **")
    return Fact(f"{steps} steps compiled by {command}")


def drives_a_mass(model: Model) -> Fact:
    """Drive a mass by a sine: it moves and stays finite, and every implicit step converges."""
    t = np.arange(2000) * 1e-3
    level = max(abs(_steady(model, 1e-3)), abs(_steady(model, -1e-3)), 1e-6)
    trace = run_open_loop(inertia(M=1.0), model, 2.0 * level * np.sin(8.0 * t), 1e-3, steps=4)
    if trace.status != Status.OK:
        raise UnmetError(trace.status.sentence)
    travel = float(np.ptp(trace.position))
    unit = unit_of("length", model.kind)
    return Fact(f"travel {travel:.3g} {unit}", travel, unit)


FORM = (described_variables, exportable_kernels, scalar_results)
SLOT_FORM = (
    slot.described_parameters,
    slot.on_a_model(exportable_kernels),
    slot.on_a_model(scalar_results),
)
FORM_OF_ALL = (*FORM, *FORM_OF_SAMPLED, *SLOT_FORM)
CHECKS = (
    *FORM,
    pure_trial,
    finite_everywhere,
    one_dimension,
    one_sided_limits,
    opposes_sliding,
    dissipates,
    refines,
    rate_agrees,
    flow_agrees,
    derivatives_agree,
    same_bits_compiled,
    same_bits_exported,
    drives_a_mass,
)
OF_SLOT = (
    *SLOT_FORM,
    slot.neutral_defaults,
    slot.factor_above_zero,
    *(
        slot.on_a_model(check)
        for check in (one_sided_limits, opposes_sliding, dissipates, refines, rate_agrees)
    ),
    slot.same_bits_along_its_channel,
    slot.same_bits_exported,
    slot.on_a_model(drives_a_mass),
)
DEMANDS: dict[type[Documented], tuple[Demand, ...]] = {
    FrictionModel: CHECKS,
    Controller: (described_variables, *LAW_CHECKS),
    Sensor: (described_variables, *SENSOR_CHECKS),
    Slot: OF_SLOT,
}
COMPILED = (
    "same bits compiled",
    "same bits along its channel",
    "same bits exported",
    "drives a mass",
)
"""Names of the demands that compile code."""


def _virgin(model: Model) -> tuple[Any, np.ndarray]:
    return model.component.initial_state(model.parameters), model.component.new_memory(
        model.parameters
    )


def _used(model: Model) -> tuple[Any, np.ndarray]:
    """Return state and memory after some random motion."""
    state, memory = _virgin(model)
    for motion, dt in _motions(50):
        _, move = model.component.trial(state, memory, motion, dt, model.parameters)
        state = model.component.commit(state, memory, move, model.parameters)
    return state, memory


def _motions(count: int) -> Iterator[tuple[Motion, float]]:
    generator = np.random.default_rng(SEED)
    for _ in range(count):
        v = float(generator.choice((-1.0, 1.0)) * 10 ** generator.uniform(-6, -1))
        yield (
            Motion(v, float(generator.uniform(-1e-3, 1e-3))),
            float(10 ** generator.uniform(-6, -2)),
        )


def _steady(model: Model, v: float) -> float:
    state, memory = settled(model, v)
    return float(force_along(model, np.array([v]), 1e-3, state=state, memory=memory)[0])


def _bytes_of(memory: Any) -> bytes:
    if isinstance(memory, np.ndarray):
        return memory.tobytes()
    return b""


def _reals(value: Any) -> list[bool]:
    """Return which packed numbers are reals, not integers or lengths of arrays."""
    if hasattr(value, "_fields"):
        return [real for part in value for real in _reals(part)]
    if isinstance(value, np.ndarray):
        return [False, *[True] * value.size]
    return [isinstance(value, float)]
