"""A control law as an FMU for co-simulation: one sample of it is the internal step.

The step is that of the other targets, `command`: around it, what lasts is taken from an array and put back, so that
the state of the FMU can be kept, set back and written to bytes as that of every other one.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce
from itertools import count

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


def content_of_law(law: Law, name: str, source: Source) -> Content:
    """Return what an FMU of a control law is made of; its parameters may be changed where that is possible."""
    constant_note = ""
    law = law if law.tunable else law_of(law.variant, tunable=True)
    try:
        tunable_law(law)
    except InputError as error:
        law, constant_note = law_of(law.variant), f"the parameters of the law are constant: {error}"
    law = settled_law(law)
    begin = np.array([0.0, *(float(reduce(getattr, path, law.lasting)) for path, _ in law.leaves)])
    entry = _stepped(law)
    facts = law_facts(law, name, source)
    ahead = [f"{name}[1..{law.samples_ahead}]" for name in law.inputs if name.endswith("_ahead")]
    feeding = f"{' and '.join(ahead)}: the desired motion of the samples that follow, [1] of the next one, as many as there are elements."
    changed = np.any(law.memory) and law.tunable
    return Content(
        f"{facts['title']}, as in the variant {facts['variant']}: effort [{facts['unit_force']}]",
        law.controller.kind,
        pruned(tree.Unit([*law.unit.functions, entry]), [entry]),
        entry,
        None,
        _ports(law, source),
        "effort",
        {"p": (law.p, law.types[1])},
        begin,
        law.memory,
        # How many values each whole number that lasts can take, 0 for a real one.
        [2, *(2 if kind == TRUTH else capacity_of(path[-1], law.memory_size) if kind == INTEGER else 0 for path, kind in law.leaves)],
        f"{law.types[0].fields} {law.memory_size} {law.dt!r}",
        [line for table in (facts["table"], facts["fed_table"]) for line in table.splitlines()],
        (ORDER, FIRST, *([feeding] if ahead else []), f"Fed forward: {'; '.join(facts['fed'])}."),
        (*([constant_note] if constant_note else []), *([PAST] if changed else [])),
    )


def _stepped(law: Law) -> tree.Function:
    """Return the step of an FMU around that of a law."""
    lasting, now = Array(1 + len(law.leaves), writable=True), law.entry.result
    places = count(1)
    inside = {"lasting": lambda: _loaded(law.types[0], lasting, places), "begun": lambda: _loaded(TRUTH, lasting, iter([BEGUN]))}
    arguments = [inside[p.name]() if p.name in inside else tree.Variable(p.type, p.name) for p in law.entry.parameters]
    body: list[tree.Statement] = [
        tree.Assign(tree.Variable(now, "now"), tree.Call(now, law.entry, arguments)),
        tree.Store(tree.Variable(lasting, "lasting"), tree.Constant(INTEGER, BEGUN), tree.Constant(REAL, 1.0)),
    ]
    for place, (path, kind) in enumerate(law.leaves, 1):
        field = _part(now, ("_1", *path))
        number = field if kind == REAL else tree.Convert(REAL, field)
        body.append(tree.Store(tree.Variable(lasting, "lasting"), tree.Constant(INTEGER, place), number))
    body.append(tree.Return(_part(now, ("_0",))))
    handed = [tree.Variable(p.type, p.name) for p in law.entry.parameters if p.name not in inside]
    return tree.Function("law_stepped", _stepped, [tree.Variable(lasting, "lasting"), *handed], REAL, body, writes=True)


def _part(now: Type, path: tuple[str, ...]) -> tree.Expression:
    """Return a part of what the law gave; no node of a tree stands in two places."""
    if not path:
        return tree.Variable(now, "now")
    outer = _part(now, path[:-1])
    inside = outer.type
    assert isinstance(inside, Struct)
    return tree.Field(inside.fields[inside.place(path[-1])][1], outer, path[-1])


def _loaded(kind: Type, lasting: Array, places: Iterator[int]) -> tree.Expression:
    """Return a value of this type of the numbers at the next places."""
    if isinstance(kind, Struct):
        return tree.Make(kind, [_loaded(part, lasting, places) for _, part in kind.fields])
    number = tree.Index(REAL, tree.Variable(lasting, "lasting"), tree.Constant(INTEGER, next(places)))
    if kind == TRUTH:
        return tree.Compare(TRUTH, "!=", number, tree.Constant(REAL, 0.0))
    return number if kind == REAL else tree.Convert(kind, number)


def _ports(law: Law, source: Source) -> Ports:
    """Return the variables: inputs as those of the law in other targets, the effort, and its parameters."""
    listed = [Port("time", TIME, Variable("time", "time"), 0.0)]
    for name in law.inputs:
        meaning, quantity = INPUTS[name]
        variable = Variable(quantity, f"{meaning}, held over a step of co-simulation")
        names = [f"{name}[{place + 1}]" for place in range(law.samples_ahead)] if name.endswith("_ahead") else [name]
        listed += [Port(input_name, INPUT, variable, 0.0) for input_name in names]
    listed.append(Port("effort", OUTPUT, Variable("force", "what the drive is to give, from the last sample on"), 0.0))
    if not law.tunable:
        return Ports(tuple(listed), {})
    tuned = tunable_law(law)
    places = {"p": (tuned, len(listed))}
    return Ports((*listed, *parameter_ports(tuned.variables, tuned.values, PARAMETER, source)), places)
