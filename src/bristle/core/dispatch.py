"""Dispatch by the type of the parameters: how one driver serves every model, ours or a user's.

In plain Python each function below looks the component up by ``type(p)``. For the compiler each has an overload on
the same type, which returns the same plain function: one source, both worlds. It is the only form in
which a component holds another one as data (a controller its compensator, an asymmetric model its two sides)
without importing it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from bristle.core.kernel import on_activation

__all__ = [
    "controller_step",
    "friction_commit",
    "friction_trial",
    "function_of",
    "is_dispatch",
    "plant_port",
    "plant_rest",
    "plant_step",
    "register",
    "sensor_step",
]

_functions: dict[tuple[str, str, type], Callable[..., Any]] = {}


def register(family: str, parameters: type, functions: Mapping[str, Callable[..., Any]]) -> None:
    """Make the functions of a component known under the type of its parameters.

    Raises
    ------
    TypeError
        If the type belongs to another component already: two could not be told apart.
    """
    for name, function in functions.items():
        if _functions.setdefault((family, name, parameters), function) is not function:
            raise TypeError(
                f"{parameters.__module__}.{parameters.__qualname__} are the parameters of another {family} already: "
                "give each component a Parameters class of its own"
            )


def function_of(family: str, name: str, parameters: type) -> Callable[..., Any]:
    """Return the function `name` of the component of this family with parameters of this type."""
    return _functions[family, name, parameters]


def friction_trial(state, memory, motion, dt, p):
    """Call ``trial`` of the friction model with parameters `p`."""
    return _functions["friction", "trial", type(p)](state, memory, motion, dt, p)


def friction_commit(state, memory, move, p):
    """Call ``commit`` of the friction model with parameters `p`."""
    return _functions["friction", "commit", type(p)](state, memory, move, p)


def plant_port(state, effort, dt, p):
    """Call ``port`` of the plant with parameters `p`."""
    return _functions["plant", "port", type(p)](state, effort, dt, p)


def plant_step(state, effort, force, dt, p):
    """Call ``step`` of the plant with parameters `p`."""
    return _functions["plant", "step", type(p)](state, effort, force, dt, p)


def plant_rest(state, effort, dt, p):
    """Call ``rest`` of the plant with parameters `p`."""
    return _functions["plant", "rest", type(p)](state, effort, dt, p)


def controller_step(state, reference, measured, dt, p):
    """Call ``step`` of the controller with parameters `p`."""
    return _functions["controller", "step", type(p)](state, reference, measured, dt, p)


def sensor_step(state, x, dt, p):
    """Call ``step`` of the sensor with parameters `p`."""
    return _functions["sensor", "step", type(p)](state, x, dt, p)


_DISPATCHERS = {
    friction_trial: ("friction", "trial"),
    friction_commit: ("friction", "commit"),
    plant_port: ("plant", "port"),
    plant_step: ("plant", "step"),
    plant_rest: ("plant", "rest"),
    controller_step: ("controller", "step"),
    sensor_step: ("sensor", "step"),
}


def is_dispatch(function: Callable[..., Any]) -> bool:
    """Return whether `function` is one of the dispatching functions of this module."""
    return function in _DISPATCHERS


def overload_all() -> None:
    from numba.extending import overload

    options: Any = {"forceinline": True, "error_model": "numpy"}

    def choose(key: tuple[str, str], p: Any) -> Any:
        return _functions.get((*key, getattr(p, "instance_class", type(None))))

    # Each implementation carries the argument names of its contract: the compiler matches by name.
    def commit(state, memory, move, p):
        return choose(("friction", "commit"), p)

    def trial(state, memory, motion, dt, p):
        return choose(("friction", "trial"), p)

    def port(state, effort, dt, p):
        return choose(("plant", "port"), p)

    def plant(state, effort, force, dt, p):
        return choose(("plant", "step"), p)

    def rest(state, effort, dt, p):
        return choose(("plant", "rest"), p)

    def controller(state, reference, measured, dt, p):
        return choose(("controller", "step"), p)

    def sensor(state, x, dt, p):
        return choose(("sensor", "step"), p)

    for function, implementation in (
        (friction_trial, trial),
        (friction_commit, commit),
        (plant_port, port),
        (plant_step, plant),
        (plant_rest, rest),
        (controller_step, controller),
        (sensor_step, sensor),
    ):
        overload(function, jit_options=options, strict=False)(implementation)


on_activation(overload_all)
