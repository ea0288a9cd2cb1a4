"""The feed of an exported compensator: which share of its friction it feeds forward, by the rule of `models.controllers.feedforward`."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core.variable import Kind, variables_of
from bristle.engine.translation.build import Builder
from bristle.engine.translation.tree import REAL, Function, Struct, Unit, struct_of
from bristle.exports.c_code import Printer, number
from bristle.exports.described import meaning_of
from bristle.exports.subject import Subject
from bristle.models.controllers.feedforward import Rule, portion

PREFIX = "feed_"  # of the names of functions


class Feed(NamedTuple):
    """The function of a feed in the tree, and the types of its rule and its result."""

    portion: Function
    rule: Struct
    result: Struct


def with_feed(subject: Subject) -> tuple[Subject, Feed]:
    """Return a subject with the function of its feed."""
    builder = Builder()
    rule = struct_of(Rule, [REAL] * len(Rule._fields))
    function = builder.function(portion, [REAL, REAL, REAL, REAL, rule])
    assert isinstance(function.result, Struct)
    for part in builder.unit.functions:
        part.name = f"{PREFIX}{part.name}"
    unit = Unit([*subject.unit.functions, *builder.unit.functions])
    return replace(subject, unit=unit), Feed(function, rule, function.result)


def feed_facts(feed: Feed, rule: Rule, printer: Printer, kind: Kind) -> dict[str, Any]:
    """Return the facts of the templates in C."""
    meanings = variables_of(Rule)
    constants = [
        (name.upper(), number(value, printer.scalar), meaning_of(meanings[name], kind))
        for name, value in rule._asdict().items()
    ]
    cast = ""
    if printer.scalar != "double":
        cast = f"({printer.scalar})"
    share, effort = (printer.names.variable(name) for name, _ in feed.result.fields)
    names = {
        "portion": feed.portion.name,
        "rule": printer.type_name(feed.rule),
        "result": printer.type_name(feed.result),
        "share": share,
        "effort": effort,
    }
    return {"feed": names | {"constants": constants, "cast": cast}}


def fed(x: np.ndarray, forces: Iterable[float], dt: float, rule: Rule) -> np.ndarray:
    """Return the feed at each position, from the friction there; the first position sets the axis and feeds nothing."""
    at = x.tolist()
    feed = np.zeros(x.size)
    share = 0.0
    for k, force in enumerate(forces):
        if k == 0:
            continue
        v = (at[k] - at[k - 1]) / dt
        share, feed[k] = portion(force, share, v, dt, rule)
    return feed
