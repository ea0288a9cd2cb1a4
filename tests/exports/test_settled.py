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
from bristle.translation.tree import REAL, TRUTH, Array, Binary, Call, Compare, Constant, If, Logic, Return, Variable, type_of, walk


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


def test_a_known_choice_is_folded():
    unit, left = left_of(with_a_parameter)
    assert parts(left, If) == []
    assert [part.operator for part in parts(left, Compare)] == [">"]  # of x alone
    assert parts(left, Logic) == []
    assert len(parts(left, Return)) == 1
    assert [call.function.name for call in parts(left, Call)] == ["mathematics_power"]
    (squares,) = [function for function in unit.functions if function.name == "mathematics_power"]
    assert parts(squares, Call) == []  # neither exp nor log: its exponent is 2


def test_real_numbers_are_not_folded():
    _, left = left_of(with_a_parameter)
    assert [part.value for part in parts(left, Constant) if part.type == REAL] == [0.0]  # nobody asks for the 2
    assert any(isinstance(part, Binary) and part.operator == "*" for part in walk(left.body))


def test_comparisons_are_folded_in_the_precision_of_the_target():
    _, double = left_of(with_a_parameter)
    _, single = left_of(with_a_parameter, single=True)
    assert [part.name for part in parts(double, Variable)] != [part.name for part in parts(single, Variable)]
    assert len(parts(single, Call)) == 2  # 0.5 + 1e-9 is 0.5 there, and no more than it


def test_a_function_is_specialized_for_its_arguments():
    unit, left = left_of(both)
    names = [call.function.name for call in parts(left, Call)]
    assert names == ["mathematics_power", "mathematics_power_2", "mathematics_power"]
    assert [function.name for function in unit.functions if "log" in function.name]  # of 3.5 and 0.5, not of 2
    assert len({function.name for function in unit.functions}) == len(unit.functions)


def test_variable_parameters_are_not_folded():
    kind = type_of(P)
    _, left = left_of(with_a_parameter, {"p": fact_of(P, kind, [("level",), ("gain",)])})
    assert len(parts(left, If)) == 1
    _, nothing = left_of(with_a_parameter, {})
    assert len(parts(nothing, If)) == 2


def test_a_loop_variable_is_not_folded():
    _, left = left_of(looped)
    assert len(parts(left, Compare)) == 1
    assert [part.value for part in parts(left, Constant) if part.type != REAL].count(2) == 2


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
