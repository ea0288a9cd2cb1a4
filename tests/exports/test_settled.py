"""What the parameters of a model decide is decided where its source is written; its bits are tried by every export."""

from typing import NamedTuple

import numpy as np
import pytest

import bristle as br
from bristle.core.kernel import kernel
from bristle.core.mathematics import power
from bristle.exports.settled import fact_of, settled
from bristle.exports.subject import settled_subject, subject_of
from bristle.exports.tunable import tunable_of
from bristle.testing import example_of
from bristle.translation.build import Builder
from bristle.translation.tree import REAL, TRUTH, Array, Binary, Call, Compare, Constant, If, Logic, Return, type_of, walk


class Chosen(NamedTuple):
    kind: int
    level: float
    gain: float
    table: np.ndarray


P = Chosen(2, 0.5 + 1e-9, 3.5, np.array([1.0, 2.0]))


@kernel
def with_a_parameter(x, p):
    if p.kind == 1:
        return p.table[0] * x
    above = p.level > 0.5
    result = x
    if above and p.kind > 1:
        result = p.gain * x
    else:
        result = power(x, p.gain)
    return result if x > 0.0 or p.gain < 0.0 else power(-x, 2.0)


@kernel
def both(x, p):
    return power(x, p.gain) + power(x, 2.0) + power(x, p.level)


@kernel
def looped(x, p):
    at = 0
    total = 0.0
    while at < p.kind:
        total += x
        at += 1
    for i in range(p.kind):
        total += p.table[i]
    return total


def left_of(function, known=None, *, single=False):
    builder, kind = Builder(), type_of(P)
    entry = builder.function(function, [REAL, kind])
    known = {"p": fact_of(P, kind)} if known is None else known
    before = list(walk(entry.body))
    unit, (left,) = settled(builder.unit, [entry], known, single=single)
    assert list(walk(entry.body)) == before  # other targets are written of the same tree
    return unit, left


def parts(function, kind):
    return [part for part in walk(function.body) if isinstance(part, kind)]


KIND = type_of(P)


@pytest.mark.parametrize(
    ("function", "known", "single", "counts"),
    [
        # Of known parameters every choice is made but the one of x; nothing of them is computed.
        (with_a_parameter, None, False, {If: 0, Compare: 1, Logic: 0, Return: 1, Call: 1, Binary: 1}),
        # In single precision 0.5 + 1e-9 is 0.5, and no more than it.
        (with_a_parameter, None, True, {If: 0, Call: 2, Binary: 0}),
        (with_a_parameter, {"p": fact_of(P, KIND, [("level",), ("gain",)])}, False, {If: 1}),
        (with_a_parameter, {}, False, {If: 2}),
        (looped, None, False, {Compare: 1}),
    ],
)
def test_a_choice_is_folded_if_it_is_known(function, known, single, counts):
    _, left = left_of(function, known, single=single)
    assert {kind: len(parts(left, kind)) for kind in counts} == counts


@pytest.mark.parametrize(("function", "whole", "real"), [(with_a_parameter, [], [0.0]), (looped, [0, 0, 1, 2, 2], [0.0])])
def test_whole_numbers_are_folded_and_real_ones_are_not(function, whole, real):
    _, left = left_of(function)
    constants = {kind: [part.value for part in parts(left, Constant) if (part.type == REAL) == kind] for kind in (True, False)}
    assert constants[True] == real
    assert sorted(constants[False]) == sorted(whole)


def test_a_function_is_specialized_for_its_arguments():
    unit, left = left_of(both)
    names = [call.function.name for call in parts(left, Call)]
    assert names == ["mathematics_power", "mathematics_power_2", "mathematics_power"]
    (squares,) = [function for function in left_of(with_a_parameter)[0].functions if function.name == "mathematics_power"]
    assert parts(squares, Call) == []  # neither exp nor log: its exponent is 2
    assert [function.name for function in unit.functions if "log" in function.name]  # of 3.5 and 0.5, not of 2
    assert len({function.name for function in unit.functions}) == len(unit.functions)


@pytest.mark.parametrize(("name", "share"), [("preisach_contact", 0.6), ("preisach_lugre", 0.76), ("lugre", 1.0)])
def test_folded_models_give_the_same_results(name, share):
    model = example_of(br.friction.MODELS[name])
    subject = subject_of(model)

    def size(item):
        return sum(1 for function in item.unit.functions for _ in walk(function.body))

    alone, tuned = settled_subject(subject), settled_subject(subject, tunable_of(model).places)
    assert size(alone) <= share * size(subject)
    assert size(alone) <= size(tuned) <= size(subject)


def test_truths_are_folded_and_arrays_are_not():
    assert fact_of(np.ones(3), Array(3)) is None
    assert fact_of(True, TRUTH) == 1
