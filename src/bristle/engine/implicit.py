r"""Derivatives of the two searches for a root in a step of a plant: those of the implicit function.

Of :math:`v = a + b\,F(v; \theta)` and of the time :math:`t` after which a body stops, :math:`R(t; \theta) = 0`,

.. math::
    \dot v = \frac{\dot a + \dot b\,F + b\,\partial_\theta F\,\dot\theta}{1 - b\,\partial_v F}, \qquad
    \dot t = -\frac{\partial_\theta R\,\dot\theta}{\partial_t R}

on every path through the search. A body with zero velocity counts as resting: :math:`\dot v = 0`, and the reaction is
:math:`-a/b`. The slope :math:`\partial_v F` is the additional change of the last direction if the velocity changes by 1, too.
"""

from collections.abc import Callable, Mapping
from typing import Any

from bristle.engine import efim
from bristle.engine.translation import tree
from bristle.engine.translation.derivative import Derivatives, Derived, Rules, is_active
from bristle.engine.translation.scope import NotExportableError


def mechanism_derivatives() -> Derivatives:
    """Return the rules for a plant with friction; its model is compiled once with tangents, for all callers."""
    rules = {efim.solve: _of_solve, efim.stopping_time: _of_stopping_time}
    return Derivatives(frozenset({efim.evaluate, efim.stop_residual}), rules)


def _derived(rules: Rules, source: Callable[..., Any]) -> tuple[tree.Function, Derived]:
    """Return the called function of this source, and its derived function with tangents for all possible arguments."""
    calls = (
        part.function for part in tree.walk(rules.function.body) if isinstance(part, tree.Call)
    )
    called = next(function for function in calls if function.source is source)
    activities = [rules.entering.get(part.name, True) for part in called.parameters]
    return called, rules.all.of(called, activities)


def _run(
    rules: Rules,
    called: tree.Function,
    derived: Derived,
    values: Mapping[str, str],
    tangents: Mapping[str, str],
) -> str:
    """Return the text that calls a derived function, with arguments of the same name except for the given values and tangents."""
    names = [part.name for part in called.parameters]
    pairs = zip(names, derived.entering, strict=True)
    moved = [
        tangents.get(name) or rules.fitted(rules.argument(name), activity)
        for name, activity in pairs
        if is_active(activity)
    ]
    return f"{derived.name}({', '.join([values.get(name, name) for name in names] + moved)})"


def _of_solve(rules: Rules) -> None:
    """Derive `efim.solve`: at constant velocity, with a velocity that changes by 1, and with the solution of the equation."""
    called, derived = _derived(rules, efim.evaluate)
    assert isinstance(derived.result, tuple)
    if not is_active(derived.result[0]):
        raise NotExportableError(efim.evaluate, None, "returns a constant force")
    tangent = {name: rules.fitted(rules.argument(name), True) for name in ("a", "b", "effort")}
    values = {"v": "at", "transmitted": "passed"}

    def run(v: str, passed: str) -> str:
        return _run(rules, called, derived, values, {"v": v, "transmitted": passed})

    solve = rules.kernel(efim.solve)
    for line in (
        f"solution = {solve}({', '.join(part.name for part in rules.function.parameters)})",
        "rests = solution.v == 0.0",
        "at = -0.0 if rests else solution.v",
        "passed = effort - (at - a) / b",
        f"reaction = tangent_combined(1.0 / b, {tangent['a']}, -a / (b * b), {tangent['b']})",
        f"d_passed = tangent_sum({tangent['effort']}, tangent_combined(1.0, reaction, at / (b * b), {tangent['b']}))",
        "d_v = still()",
        "if not rests:",
        f"    _, held = {run('d_v', 'd_passed')}",
        f"    _, moved = {run('moving()', 'tangent_sum(d_passed, tangent_scaled(-1.0 / b, moving()))')}",
        "    inverse = 1.0 / (1.0 - b * (tangent_last(moved[0]) - tangent_last(held[0])))",
        f"    d_v = tangent_sum({tangent['a']}, tangent_combined(solution.force, {tangent['b']}, b, held[0]))",
        "    d_v = tangent_scaled(inverse, d_v)",
        "    d_passed = tangent_sum(d_passed, tangent_scaled(-1.0 / b, d_v))",
        f"_, found = {run('d_v', 'd_passed')}",
        "d_force = tangent_scaled(-1.0, reaction) if rests else found[0]",
    ):
        rules.line(line)
    move = derived.result[1]
    rules.result = True, True, move, False, False
    rules.line(f"return solution, (d_v, d_force{', found[1]' if is_active(move) else ''})")


def _of_stopping_time(rules: Rules) -> None:
    """Derive `efim.stopping_time`."""
    called, derived = _derived(rules, efim.stop_residual)
    find = rules.kernel(efim.stopping_time)
    rules.line(f"time = {find}({', '.join(part.name for part in rules.function.parameters)})")
    rules.line(f"_, held = {_run(rules, called, derived, {}, {'time': 'still()'})}")
    rules.line(f"_, moved = {_run(rules, called, derived, {}, {'time': 'moving()'})}")
    rules.line("slope = tangent_last(moved) - tangent_last(held)")
    rules.line("return time, tangent_scaled(-1.0 / slope if slope != 0.0 else 0.0, held)")
    rules.result = True
