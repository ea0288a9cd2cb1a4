"""A control law as an FMU for co-simulation: one sample of it is the internal step.

The step is that of the other targets, `command`: around it, what lasts is taken from an array and put back, so that
the state of the FMU can be kept, set back and written to bytes as that of every other one.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from typing import Any

import numpy as np

from bristle.core.errors import InputError
from bristle.core.variable import Variable
from bristle.exports import tree
from bristle.exports.described import Source
from bristle.exports.fmu_content import INPUT, OUTPUT, PARAMETER, TIME, Content, Port, Ports, parameter_ports
from bristle.exports.law import Law, law_of
from bristle.exports.law_described import INPUTS, law_facts
from bristle.exports.prune import pruned
from bristle.exports.subject import capacity_of
from bristle.exports.tree import INTEGER, REAL, TRUTH, Array, Struct, Type
from bristle.exports.tunable import settled_law, tunable_law

BEGUN = 0  # where what lasts tells whether there was a sample; what the law keeps follows
ORDER = (
    "Step the law before the plant, and give its effort to the plant for the same step: so a simulated loop of bristle "
    "does. An importer that steps both at once gives the plant each effort a sample late: add one to the delay of the "
    "experiment then, and export again."
)
FIRST = "The first step takes over the desired motion with an empty integral, at the position that is measured."
PAST = "what the compensator was brought through before it begins is that of the exported parameters"
AHEAD = "{names}: the desired motion of the samples that follow, [1] of the next one, as many as there are elements."


def content_of_law(law: Law, name: str, source: Source) -> Content:
    """Return what an FMU of a control law is made of; its parameters may be changed where that is possible."""
    law, constant_note = _tuned(law)
    law = settled_law(law)
    entry, begin = _stepped(law)
    facts = law_facts(law, name, source)
    title = f"{facts['title']}, as in the variant {facts['variant']}: effort [{facts['unit_force']}]"
    ahead = [f"{name}[1..{law.samples_ahead}]" for name in law.inputs if name.endswith("_ahead")]
    unit = pruned(tree.Unit([*law.unit.functions, entry]), [entry])
    lines = [line for table in (facts["table"], facts["fed_table"]) for line in table.splitlines()]
    changed = np.any(law.memory) and law.tunable
    return Content(
        title,
        law.controller.kind,
        unit,
        entry,
        None,
        _ports(law, source, constant_note),
        "effort",
        {"p": (law.p, law.types[1])},
        begin,
        law.memory,
        [2, *_most(law.types[0], law.memory_size)],
        f"{law.types[0].fields} {law.memory_size} {law.dt!r}",
        lines,
        (ORDER, FIRST, *([AHEAD.format(names=" and ".join(ahead))] if ahead else []), f"Fed forward: {'; '.join(facts['fed'])}."),
        (*([constant_note] if constant_note else []), *([PAST] if changed else [])),
    )


def _tuned(law: Law) -> tuple[Law, str]:
    """Return a law with parameters that may be changed; or as it is, and why."""
    tuned = law if law.tunable else law_of(law.variant, tunable=True)
    try:
        tunable_law(tuned)
    except InputError as error:
        return law_of(law.variant), f"the parameters of the law are constant: {error}"
    return tuned, ""


def _stepped(law: Law) -> tuple[tree.Function, np.ndarray]:
    """Return the step of an FMU around that of a law, and what lasts before the first one."""
    begin = np.array([0.0, *_numbers(law.lasting)])
    lasting, state, now = Array(begin.size, writable=True), law.types[0], law.entry.result
    places = count(1)
    arguments: list[tree.Expression] = []
    for parameter in law.entry.parameters:
        if parameter.name == "lasting":
            arguments.append(_loaded(state, lasting, places))
        elif parameter.name == "begun":
            arguments.append(tree.Compare(TRUTH, "!=", _at(lasting, BEGUN), tree.Constant(REAL, 0.0)))
        else:
            arguments.append(tree.Variable(parameter.type, parameter.name))
    body: list[tree.Statement] = [
        tree.Assign(tree.Variable(now, "now"), tree.Call(now, law.entry, arguments)),
        tree.Store(tree.Variable(lasting, "lasting"), tree.Constant(INTEGER, BEGUN), tree.Constant(REAL, 1.0)),
        *_stored(state, ("_1",), now, lasting, count(1)),
        tree.Return(_part(now, ("_0",))),
    ]
    handed = [
        tree.Variable(parameter.type, parameter.name) for parameter in law.entry.parameters if parameter.name not in ("lasting", "begun")
    ]
    return tree.Function("law_stepped", _stepped, [tree.Variable(lasting, "lasting"), *handed], REAL, body, writes=True), begin


def _at(lasting: Array, place: int) -> tree.Index:
    return tree.Index(REAL, tree.Variable(lasting, "lasting"), tree.Constant(INTEGER, place))


def _part(now: Type, path: tuple[str, ...]) -> tree.Expression:
    """Return a part of what the law gave; no node of a tree stands in two places."""
    if not path:
        return tree.Variable(now, "now")
    outer = _part(now, path[:-1])
    inside = outer.type
    assert isinstance(inside, Struct)
    return tree.Field(inside.fields[inside.place(path[-1])][1], outer, path[-1])


def _loaded(kind: Struct, lasting: Array, places: Iterator[int]) -> tree.Make:
    parts: list[tree.Expression] = []
    for _, part in kind.fields:
        if isinstance(part, Struct):
            parts.append(_loaded(part, lasting, places))
        else:
            parts.append(_of_type(part, _at(lasting, next(places))))
    return tree.Make(kind, parts)


def _of_type(kind: Type, number: tree.Index) -> tree.Expression:
    if kind == TRUTH:
        return tree.Compare(TRUTH, "!=", number, tree.Constant(REAL, 0.0))
    return number if kind == REAL else tree.Convert(kind, number)


def _stored(kind: Struct, path: tuple[str, ...], now: Type, lasting: Array, places: Iterator[int]) -> Iterator[tree.Statement]:
    for name, part in kind.fields:
        inner = (*path, name)
        if isinstance(part, Struct):
            yield from _stored(part, inner, now, lasting, places)
        else:
            field = _part(now, inner)
            number = field if part == REAL else tree.Convert(REAL, field)
            yield tree.Store(tree.Variable(lasting, "lasting"), tree.Constant(INTEGER, next(places)), number)


def _numbers(value: Any) -> Iterator[float]:
    for part in value:
        yield from _numbers(part) if hasattr(part, "_fields") else (float(part),)


def _most(kind: Struct, memory_size: int) -> Iterator[int]:
    """Give how many values each whole number that lasts can take, 0 for a real one."""
    for name, part in kind.fields:
        if isinstance(part, Struct):
            yield from _most(part, memory_size)
        else:
            yield 2 if part == TRUTH else capacity_of(name, memory_size) if part == INTEGER else 0


def _ports(law: Law, source: Source, constant_note: str) -> Ports:
    """Return the variables: inputs as those of the law in other targets, the effort, and its parameters."""
    listed = [Port("time", TIME, Variable("time", "time"), 0.0)]
    for name in law.inputs:
        meaning, quantity = INPUTS[name]
        variable = Variable(quantity, f"{meaning}, held over a step of co-simulation")
        samples = range(1, law.samples_ahead + 1) if name.endswith("_ahead") else ()
        names = [f"{name}[{place}]" for place in samples] or [name]
        listed += [Port(input_name, INPUT, variable, 0.0) for input_name in names]
    listed.append(Port("effort", OUTPUT, Variable("force", "what the drive is to give, from the last sample on"), 0.0))
    if constant_note:
        return Ports(tuple(listed), {}, ())
    tuned = tunable_law(law)
    places = {"p": (tuned, len(listed))}
    return Ports((*listed, *parameter_ports(tuned.variables, tuned.values, PARAMETER, source)), places, ())
