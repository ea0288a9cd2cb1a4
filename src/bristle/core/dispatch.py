"""Dispatch by the type of the parameters: how one driver serves every model, ours or a user's.

In plain Python each function looks the component up by ``type(p)``; for the compiler it has an overload on that type.
"""

import inspect
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from bristle.core.kernel import on_activation

_functions: dict[tuple[str, str, type], Callable[..., Any]] = {}
_by_fields: dict[Callable[..., Any], Callable[[tuple[str, ...]], Callable[..., Any]]] = {}


def register(family: str, parameters: type, functions: Mapping[str, Callable[..., Any]]) -> None:
    """Make the functions of a component known under the type of its parameters."""
    for name, function in functions.items():
        if _functions.setdefault((family, name, parameters), function) is not function:
            raise TypeError(
                f"{parameters.__module__}.{parameters.__qualname__} are the parameters of another {family} already: "
                "give each component a Parameters class of its own"
            )


def functions_of(parameters: Any) -> tuple[Callable[..., Any], ...]:
    """Return every function that is dispatched to by this type; none for any other type."""
    return tuple(function for (_, _, cls), function in _functions.items() if cls is parameters)


def operator_trial(state, memory, u, p):
    """Call ``trial`` of the hysteresis operator with parameters `p`."""
    return _functions["hysteresis", "trial", type(p)](state, memory, u, p)


def operator_commit(state, memory, move, p):
    """Call ``commit`` of the hysteresis operator with parameters `p`."""
    return _functions["hysteresis", "commit", type(p)](state, memory, move, p)


def operator_measure(p):
    """Return the measure of the hysteresis operator with parameters `p`, by its Everett function."""
    return _functions["hysteresis", "measure", type(p)](p)


def everett(alpha, beta, q):
    """Return the Everett function E(alpha, beta), alpha >= beta, of the measure `q`."""
    return _functions["everett", "value", type(q)](alpha, beta, q)


def everett_slope(alpha, beta, side, q):
    """Return the derivative of E to its moving end: by alpha for ``side > 0``, else by -beta."""
    return _functions["everett", "slope", type(q)](alpha, beta, side, q)


def virgin_curve(u, q):
    """Return the output that the demagnetised measure `q` has at the first input `u`."""
    return _functions["everett", "virgin", type(q)](u, q)


def virgin_slope(u, q):
    """Return the derivative of `virgin_curve`."""
    return _functions["everett", "virgin_slope", type(q)](u, q)


def friction_trial(state, memory, motion, dt, p):
    """Call ``trial`` of the friction model with parameters `p`."""
    return _functions["friction", "trial", type(p)](state, memory, motion, dt, p)


def friction_trial_sided(state, memory, motion, dt, backward, forward):
    """Call ``trial_sided`` of the friction model with parameters `forward` and, on the other side, `backward`."""
    return _functions["friction", "trial_sided", type(forward)](state, memory, motion, dt, backward, forward)


def friction_commit(state, memory, move, p):
    """Call ``commit`` of the friction model with parameters `p`."""
    return _functions["friction", "commit", type(p)](state, memory, move, p)


def friction_rate(state, motion, p):
    """Call ``rate`` of the friction model with parameters `p`."""
    return _functions["friction", "rate", type(p)](state, motion, p)


def friction_piece(state, memory, motion, p):
    """Call ``piece`` of the friction model with parameters `p`."""
    return _functions["friction", "piece", type(p)](state, memory, motion, p)


def friction_flow(contact, piece, motion, p):
    """Call ``flow`` of the friction model with parameters `p`."""
    return _functions["friction", "flow", type(p)](contact, piece, motion, p)


def friction_arrival(state, memory, contact, p):
    """Call ``arrival`` of the friction model with parameters `p`."""
    return _functions["friction", "arrival", type(p)](state, memory, contact, p)


def plant_port(state, effort, dt, p):
    """Call ``port`` of the plant with parameters `p`."""
    return _functions["plant", "port", type(p)](state, effort, dt, p)


def plant_step(state, effort, force, dt, p):
    """Call ``step`` of the plant with parameters `p`."""
    return _functions["plant", "step", type(p)](state, effort, force, dt, p)


def plant_rest(state, effort, dt, p):
    """Call ``rest`` of the plant with parameters `p`."""
    return _functions["plant", "rest", type(p)](state, effort, dt, p)


def plant_rate(state, effort, force, p):
    """Call ``rate`` of the plant with parameters `p`."""
    return _functions["plant", "rate", type(p)](state, effort, force, p)


def controller_step(state, reference, measured, dt, p):
    """Call ``step`` of the controller with parameters `p`."""
    return _functions["controller", "step", type(p)](state, reference, measured, dt, p)


def sensor_step(state, x, dt, p):
    """Call ``step`` of the sensor with parameters `p`."""
    return _functions["sensor", "step", type(p)](state, x, dt, p)


_DISPATCHERS = {
    operator_trial: ("hysteresis", "trial"),
    operator_commit: ("hysteresis", "commit"),
    operator_measure: ("hysteresis", "measure"),
    everett: ("everett", "value"),
    everett_slope: ("everett", "slope"),
    virgin_curve: ("everett", "virgin"),
    virgin_slope: ("everett", "virgin_slope"),
    friction_trial: ("friction", "trial"),
    friction_trial_sided: ("friction", "trial_sided"),
    friction_commit: ("friction", "commit"),
    friction_rate: ("friction", "rate"),
    friction_piece: ("friction", "piece"),
    friction_flow: ("friction", "flow"),
    friction_arrival: ("friction", "arrival"),
    plant_port: ("plant", "port"),
    plant_step: ("plant", "step"),
    plant_rest: ("plant", "rest"),
    plant_rate: ("plant", "rate"),
    controller_step: ("controller", "step"),
    sensor_step: ("sensor", "step"),
}


def chosen_by_fields(function: Callable[..., Any], choose: Callable[[tuple[str, ...]], Callable[..., Any]]) -> Callable[..., Any]:
    """Return a function of one NamedTuple, for which `choose` has a kernel by the names of the fields of that."""
    _by_fields[function] = choose
    on_activation(lambda: _overload(function, lambda types: choose(types[-1].fields)))
    return function


def is_dispatch(function: Callable[..., Any]) -> bool:
    """Return whether `function` is a dispatching function: one of this module, or one that fields choose."""
    return function in _DISPATCHERS or function in _by_fields


def implementation_of(function: Callable[..., Any], parameters: type) -> Callable[..., Any] | None:
    """Return what a dispatching function of this module calls for parameters of this type; None where nothing is."""
    if function in _by_fields:
        return _by_fields[function](getattr(parameters, "_fields", ()))
    return _functions.get((*_DISPATCHERS[function], parameters))


def overload_all() -> None:
    """Make every dispatching function of this module known to the compiler."""
    for function, key in _DISPATCHERS.items():
        _overload(function, partial(_by_type, key))


def _by_type(key: tuple[str, str], types: tuple[Any, ...]) -> Any:
    return _functions.get((*key, getattr(types[-1], "instance_class", type(None))))


def _overload(function: Callable[..., Any], choose: Callable[[tuple[Any, ...]], Any]) -> None:
    """Make what is chosen in place of a function known to the compiler, by the types of its arguments."""
    from numba.extending import overload

    options: Any = {"forceinline": True, "error_model": "numpy"}
    # The compiler matches arguments by name, so the implementation carries those of its dispatcher.
    names = ", ".join(inspect.signature(function).parameters)
    scope: dict[str, Any] = {"choose": lambda *types: choose(types)}
    exec(f"def chosen({names}): return choose({names})", scope)
    overload(function, jit_options=options, strict=False)(scope["chosen"])


on_activation(overload_all)
