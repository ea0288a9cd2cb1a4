"""Dispatch by the type of the parameters, so that a driver works with every model of bristle or of the user.

In plain Python each function finds the component by ``type(p)``; for the compiler it has an overload on this type.
"""

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from bristle.core.kernel import on_activation

_functions: dict[tuple[str, str, type], Callable[..., Any]] = {}
_DISPATCHERS: dict[Callable[..., Any], tuple[str, str, str]] = {}
"""Dispatching function -> family and name of the called function, and its arguments."""
_by_fields: dict[Callable[..., Any], Callable[[tuple[str, ...]], Callable[..., Any]]] = {}


def register(family: str, parameters: type, functions: Mapping[str, Callable[..., Any]]) -> None:
    """Register the functions of a component under the type of its parameters."""
    for name, function in functions.items():
        if _functions.setdefault((family, name, parameters), function) is not function:
            raise TypeError(
                f"{parameters.__module__}.{parameters.__qualname__} are already the parameters of another {family}: "
                "give each component a separate Parameters class"
            )


def functions_of(parameters: Any) -> tuple[Callable[..., Any], ...]:
    """Return all functions registered for this type of parameters; empty for other types."""
    return tuple(function for (_, _, cls), function in _functions.items() if cls is parameters)


def _dispatching(family: str, name: str, arguments: str) -> Callable[..., Any]:
    """Return a function that calls `name` of the component with the type of the last argument."""

    def dispatch(*given):
        return _functions[family, name, type(given[-1])](*given)

    dispatch.__name__ = dispatch.__qualname__ = f"{family}_{name}"
    _DISPATCHERS[dispatch] = (family, name, arguments)
    return dispatch


operator_trial = _dispatching("hysteresis", "trial", "state, memory, u, p")
operator_commit = _dispatching("hysteresis", "commit", "state, memory, move, p")
operator_measure = _dispatching("hysteresis", "measure", "p")
# The Everett function E(alpha, beta), alpha >= beta, of the measure q.
everett = _dispatching("everett", "value", "alpha, beta, q")
everett_slope = _dispatching("everett", "slope", "alpha, beta, side, q")
virgin_curve = _dispatching("everett", "virgin", "u, q")
virgin_slope = _dispatching("everett", "virgin_slope", "u, q")
friction_trial = _dispatching("friction", "trial", "state, memory, motion, dt, p")
friction_trial_sided = _dispatching(
    "friction", "trial_sided", "state, memory, motion, dt, backward, forward"
)
friction_commit = _dispatching("friction", "commit", "state, memory, move, p")
friction_rate = _dispatching("friction", "rate", "state, motion, p")
friction_piece = _dispatching("friction", "piece", "state, memory, motion, p")
friction_flow = _dispatching("friction", "flow", "contact, piece, motion, p")
friction_arrival = _dispatching("friction", "arrival", "state, memory, contact, p")
plant_port = _dispatching("plant", "port", "state, effort, dt, p")
plant_step = _dispatching("plant", "step", "state, effort, force, dt, p")
plant_rest = _dispatching("plant", "rest", "state, effort, dt, p")
plant_rate = _dispatching("plant", "rate", "state, effort, force, p")
controller_step = _dispatching("controller", "step", "state, reference, measured, dt, p")
sensor_step = _dispatching("sensor", "step", "state, x, dt, p")


def chosen_by_fields(
    function: Callable[..., Any], choose: Callable[[tuple[str, ...]], Callable[..., Any]]
) -> Callable[..., Any]:
    """Return a function of a NamedTuple; `choose` selects its kernel by the names of the fields."""
    _by_fields[function] = choose
    names = ", ".join(inspect.signature(function).parameters)
    on_activation(lambda: _overload(function, names, lambda types: choose(types[-1].fields)))
    return function


def is_dispatch(function: Callable[..., Any]) -> bool:
    """Return whether `function` dispatches, by the type of parameters or by fields."""
    return function in _DISPATCHERS or function in _by_fields


def implementation_of(function: Callable[..., Any], parameters: type) -> Callable[..., Any] | None:
    """Return the function that a dispatching function calls for this type of parameters; None if there is no such function."""
    if function in _by_fields:
        return _by_fields[function](getattr(parameters, "_fields", ()))
    return _functions.get((*_DISPATCHERS[function][:2], parameters))


def overload_all() -> None:
    """Register every dispatching function of this module with the compiler."""
    for function, (family, name, arguments) in _DISPATCHERS.items():
        _overload(
            function,
            arguments,
            lambda types, family=family, name=name: _functions.get(
                (family, name, getattr(types[-1], "instance_class", type(None)))
            ),
        )


def _overload(
    function: Callable[..., Any], names: str, choose: Callable[[tuple[Any, ...]], Any]
) -> None:
    """Register a function with the compiler; the types of its arguments select the implementation."""
    from numba.extending import overload

    options: Any = {"forceinline": True, "error_model": "numpy"}
    # The compiler matches arguments by name, so the implementation has the argument names of its dispatcher.
    scope: dict[str, Any] = {"choose": lambda *types: choose(types)}
    exec(f"def chosen({names}): return choose({names})", scope)
    overload(function, jit_options=options, strict=False)(scope["chosen"])


on_activation(overload_all)
