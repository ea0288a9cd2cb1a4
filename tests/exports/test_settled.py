"""What the parameters of a model decide is decided where its source is written; those that may change stay."""

import math
from typing import NamedTuple

import numpy as np
import pytest

import bristle as br
from bristle.contract import example_of
from bristle.core.mathematics import power
from bristle.engine.translation.build import Builder
from bristle.engine.translation.tree import (
    REAL,
    TRUTH,
    Array,
    Binary,
    Call,
    Compare,
    Constant,
    If,
    Logic,
    Return,
    type_of,
    walk,
)
from bristle.exports.settled import fact_of, settled
from bristle.exports.subject import settled_subject, subject_of
from bristle.exports.tunable import (
    CONSTANTS,
    bounds_of,
    checkpoints,
    refuse_beyond_single,
    single_note,
    tunable_of,
)


class Chosen(NamedTuple):
    kind: int
    level: float
    gain: float
    table: np.ndarray


P = Chosen(2, 0.5 + 1e-9, 3.5, np.array([1.0, 2.0]))


@br.core.kernel
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


@br.core.kernel
def both(x, p):
    return power(x, p.gain) + power(x, 2.0) + power(x, p.level)


@br.core.kernel
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
        (
            with_a_parameter,
            None,
            False,
            {If: 0, Compare: 1, Logic: 0, Return: 1, Call: 1, Binary: 1},
        ),
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


@pytest.mark.parametrize(
    ("function", "whole", "real"), [(with_a_parameter, [], [0.0]), (looped, [0, 0, 1, 2, 2], [0.0])]
)
def test_whole_numbers_are_folded_and_real_ones_are_not(function, whole, real):
    _, left = left_of(function)
    constants = {
        kind: [part.value for part in parts(left, Constant) if (part.type == REAL) == kind]
        for kind in (True, False)
    }
    assert constants[True] == real
    assert sorted(constants[False]) == sorted(whole)


def test_a_function_is_specialized_for_its_arguments():
    unit, left = left_of(both)
    names = [call.function.name for call in parts(left, Call)]
    assert names == ["mathematics_power", "mathematics_power_2", "mathematics_power"]
    (squares,) = [
        function
        for function in left_of(with_a_parameter)[0].functions
        if function.name == "mathematics_power"
    ]
    assert parts(squares, Call) == []  # neither exp nor log: its exponent is 2
    # Of 3.5 and 0.5, not of 2
    assert [function.name for function in unit.functions if "log" in function.name]
    assert len({function.name for function in unit.functions}) == len(unit.functions)


@pytest.mark.parametrize(
    ("name", "share"), [("preisach_contact", 0.6), ("preisach_lugre", 0.765), ("lugre", 1.0)]
)
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


# --- tunable ---------------------------------------------------------------------------------------------------------


LUGRE = br.friction.lugre(F_C=22.0, F_S=29.0, v_S=3e-3, sigma_0=2e6)
SLIP = br.friction.maxwell_slip(F_C=4.0, nu_i=[0.25, 0.75], k_i=[1e5, 2e5])


def test_real_numbers_are_variable_by_name_and_index():
    tuned = tunable_of(SLIP)
    numbers = [
        ("F_C", None, 4.0),
        ("nu_i", 0, 0.25),
        ("nu_i", 1, 0.75),
        ("k_i", 0, 1e5),
        ("k_i", 1, 2e5),
        ("sigma_2", None, 0.0),
    ]
    assert sorted(tuned.numbers(), key=str) == sorted(numbers, key=str)
    assert tunable_of(SLIP, ("F_C",)).values.keys() == {"nu_i", "k_i", "sigma_2"}
    assert set(tuned.places.values()) == {"F_C", "nu_i", "k_i", "sigma_2"}


def test_a_number_is_limited_by_its_bounds_or_by_the_largest_number():
    bounds = {(name, place): compared for name, place, compared in bounds_of(tunable_of(SLIP))}
    assert bounds["F_C", None] == [(">=", SLIP.component.variables["F_C"].min)]
    share = SLIP.component.variables["nu_i"]
    assert bounds["nu_i", 1] == [(">=", share.min)] * math.isfinite(share.min) + [
        ("<=", share.max)
    ] * math.isfinite(share.max)
    offset = br.friction.with_slots(br.friction.coulomb, [])(F_C=1.0, offset=0.5)
    assert {name: compared for name, _, compared in bounds_of(tunable_of(offset))}["offset"] == [
        (">=", -math.inf),
        ("<=", math.inf),
    ]


def test_a_value_beyond_single_precision_is_refused_by_its_path():
    refuse_beyond_single({"a": 1e38, "b": math.inf, "c": "text", "d": np.array([1.0, np.nan])})
    with pytest.raises(br.core.InputError) as reported:
        refuse_beyond_single({"a": LUGRE.parameters._replace(sigma_0=1e39)})
    assert (reported.value.path, reported.value.value) == ("a.sigma_0", 1e39)
    with pytest.raises(br.core.InputError, match="k: is too large"):
        refuse_beyond_single({"k": np.array([1.0, -4e38])})


def test_single_precision_is_compared_at_checkpoints():
    outputs = np.linspace(-3.0, 1.0, 101)
    near = checkpoints(outputs, single=True)
    assert [float(number) for number in near["checkpoints"]] == pytest.approx(
        [-3.0, -2.0, -1.0, 0.0, 1.0]
    )
    assert (near["largest"], near["every"], near["tolerance"]) == ("3.0", 25, "0.001")
    assert checkpoints(outputs, single=False)["tolerance"] == ""
    assert single_note("force").endswith("the self-test allows 0.001 of the largest force")


SINGLE, INFO = {name: number for (name, _), number in CONSTANTS.items()}, np.finfo(np.float32)


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (SINGLE["NORMAL_MIN"], float(INFO.tiny)),
        (SINGLE["LARGEST"], float(INFO.max)),
        (SINGLE["LOG_OF_MIN"], pytest.approx(math.log(float(INFO.tiny)), rel=1e-12)),
        # The largest exponents whose exponential is a normal number, and its size there.
        (SINGLE["EXP_OF_MAX"], pytest.approx(math.exp(SINGLE["EXP_MAX"]), rel=1e-12)),
        (SINGLE["EXP_MAX"], math.floor(math.log(float(INFO.max)))),
        (SINGLE["EXP_MIN"], math.ceil(math.log(float(INFO.tiny)))),
        # A number plus one and a half times 2^23 is whole; a tangent is 1 to the last place from there on.
        (np.float32(SINGLE["ROUNDER"]) + np.float32(0.7) - np.float32(SINGLE["ROUNDER"]), 1.0),
        (SINGLE["ROUNDER"], 1.5 * 2.0**23),
        (np.float32(math.tanh(SINGLE["TANH_MAX"])), 1.0),
        (np.float32(math.tanh(0.5 * SINGLE["TANH_MAX"])) < 1.0, True),
        # Parts of a few bits whose products with whole numbers are exact, and what is left.
        (SINGLE["LN2_HIGH"] + SINGLE["LN2_LOW"], pytest.approx(math.log(2.0), abs=1e-14)),
        (SINGLE["LN2_HIGH"] * 2.0**9 % 1.0, 0.0),
        (
            sum(SINGLE[f"HALF_PI_{part}"] for part in (1, 2, 3, 4)),
            pytest.approx(math.pi / 2.0, abs=1e-15),
        ),
        (SINGLE["HALF_PI_1"] * 2.0**7 % 1.0, 0.0),
        (SINGLE["HALF_PI_2"] * 2.0**23 % 1.0, 0.0),
    ],
)
def test_constants_of_single_precision_follow_from_the_format(found, expected):
    assert found == expected
