"""What of a tree is not needed: arguments that nobody looks at, variables that nobody reads, functions nobody calls.

Kernels share one grammar, so that many take more than they look at. A target pays for each argument, and its compiler
warns.
"""

from __future__ import annotations

from collections.abc import Iterable

from bristle.exports.tree import Assign, Call, Evaluate, For, Function, If, Node, Statement, Unit, Variable, While, walk


def pruned(unit: Unit, roots: Iterable[Function]) -> Unit:
    """Return a unit with what the roots need.

    Functions are changed in place: who calls one, a root too, hands over the arguments that are left.
    """
    entries = list(roots)
    while True:
        needed: set[int] = set()
        waiting = list(entries)
        while waiting:
            function = waiting.pop()
            if id(function) not in needed:
                needed.add(id(function))
                waiting += [part.function for part in walk(function.body) if isinstance(part, Call)]
        functions = [function for function in unit.functions if id(function) in needed]
        size = sum(1 for function in functions for _ in walk(function.body))
        for function in functions:
            function.body = _live(function.body, {part.name for part in _read(list(walk(function.body)))})
        dead = sum(1 for function in functions for _ in walk(function.body)) < size
        if not _without_arguments(functions) and not dead:
            return Unit(functions)


def _read(parts: list[Node]) -> list[Variable]:
    """Return the variables that are looked at among parts of a tree; what takes a value is not."""
    assigned = {id(part.variable) for part in parts if isinstance(part, (Assign, For))}
    return [part for part in parts if isinstance(part, Variable) and id(part) not in assigned]


def _live(block: list[Statement], read: set[str]) -> list[Statement]:
    entries: list[Statement] = []
    for statement in block:
        if isinstance(statement, Assign) and statement.variable.name not in read:
            if isinstance(statement.value, Call) and statement.value.function.writes:
                entries.append(Evaluate(statement.value))
            continue
        if isinstance(statement, If):
            statement.body, statement.otherwise = _live(statement.body, read), _live(statement.otherwise, read)
            if not statement.body and not statement.otherwise:
                continue
        elif isinstance(statement, (For, While)):
            statement.body = _live(statement.body, read)
        entries.append(statement)
    return entries


def _without_arguments(functions: list[Function]) -> bool:
    """Leave out arguments that nobody looks at; return whether there were some."""
    used: dict[int, set[str]] = {id(function): set() for function in functions}
    parts = [list(walk(function.body)) for function in functions]
    calls = [[part for part in each if isinstance(part, Call)] for each in parts]
    read = [_read(each) for each in parts]
    news = True
    while news:  # arguments that are looked at, given those of the functions called that are
        news = False
        for function, called, variables in zip(functions, calls, read, strict=True):
            idle = {
                id(argument)
                for call in called
                for parameter, argument in zip(call.function.parameters, call.arguments, strict=True)
                if isinstance(argument, Variable) and parameter.name not in used[id(call.function)]
            }
            looked_at = {part.name for part in variables if id(part) not in idle}
            fresh = {parameter.name for parameter in function.parameters} & looked_at - used[id(function)]
            used[id(function)] |= fresh
            news |= bool(fresh)
    for call in (call for each in calls for call in each):
        pairs = zip(call.function.parameters, call.arguments, strict=True)
        call.arguments = [argument for parameter, argument in pairs if parameter.name in used[id(call.function)]]
    dropped = False
    for function in functions:
        left = [parameter for parameter in function.parameters if parameter.name in used[id(function)]]
        dropped |= len(left) < len(function.parameters)
        function.parameters = left
    return dropped
