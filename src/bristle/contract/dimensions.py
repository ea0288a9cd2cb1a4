"""Whether a friction model is dimensionally consistent: it is the same model in other units of length, time and force."""

import math
from collections.abc import Mapping

import numpy as np

from bristle.contract.check import Fact, UnmetError
from bristle.core import Model, Motion, variables_of
from bristle.core.dimensions import exponents_of

# speeds: forward, back, at rest after either direction
WALK = (1e-4, 1e-3, 5e-3, -1e-4, -1e-3, 0.0, -0.0, 2e-3, -5e-3, 1e-4, -2e-3)
OTHER_UNIT = 16.0  # a power of two with an integer root: numbers of a consistent formula change by their exponents only


def one_dimension(model: Model) -> Fact:
    """Give the same force in other units of length, time or force: sums, comparisons and functions are consistent."""
    expected = _walked(model, {})
    names = ("force", *(f"state {name}" for name in model.component.State._fields))
    for unit in ("length", "time", "force"):
        units = {unit: OTHER_UNIT}
        if unit != "time":
            # Work has the units of force times length, also if the force depends on travel.
            units["force of travel"] = OTHER_UNIT
        for name, wanted, result in zip(names, expected, _walked(model, units), strict=True):
            if not np.allclose(result, wanted, rtol=1e-6, atol=1e-9 * np.max(np.abs(wanted))):
                raise UnmetError(
                    f"the {name} changes with the unit of {unit}",
                    "Compare the quantity of each parameter and state with the formulas; a plain number has no unit",
                )
    return Fact(f"{len(WALK)} steps, in other units of length, time and force")


def _walked(model: Model, units: Mapping[str, float]) -> list[np.ndarray]:
    """Return force and states along a short walk, computed in units smaller by these factors, and converted to SI."""

    def factor(quantity: str) -> float:
        return math.prod(
            units.get(name, 1.0) ** power for name, power in exponents_of(quantity).items()
        )

    component = model.component
    states = variables_of(model.component.State)
    scaled = {
        name: factor(item.quantity)
        for name, item in component.variables.items()
        if factor(item.quantity) != 1.0
    }
    values = {name: np.multiply(model.values[name], by).tolist() for name, by in scaled.items()}
    p = component(**{**model.values, **values}, kind=model.kind, validate=False).parameters
    memory = component.new_memory(p)
    begun = component.initial_state(model.parameters)
    x = 0.0
    rows = []
    state = begun._replace(
        **{name: getattr(begun, name) * factor(item.quantity) for name, item in states.items()}
    )
    for v in WALK:
        x += 1e-3 * v
        motion = Motion(v * factor("length/time"), x * factor("length"))
        force, move = component.trial(state, memory, motion, 1e-3 * factor("time"), p)
        state = component.commit(state, memory, move, p)
        rows.append(
            [
                force / factor("force"),
                *(getattr(state, name) / factor(item.quantity) for name, item in states.items()),
            ]
        )
    return list(np.array(rows, dtype=float).T)
