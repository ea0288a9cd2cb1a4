"""Forward derivatives of kernels: rule by rule what complex steps of the plain kernel give, and nothing where nothing moves."""

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import pytest
from tests.engine.translation.complex_step import (
    Complex,
    complex_mathematics,
    imaginary_of,
    real_of,
    seeded,
    slopes_of,
)

from bristle.core import mathematics
from bristle.core.exponent import exponent, mantissa, power_of_two
from bristle.core.kernel import kernel
from bristle.core.mathematics import EXP_MAX, EXP_MIN, LARGEST, NORMAL_MIN, exp, power
from bristle.core.tangent import (
    DIRECTIONS,
    keep_tangent,
    still,
    tangent_at,
    tangent_combined,
    tangent_difference,
    tangent_scaled,
    tangent_sum,
)
from bristle.engine.translation.build import Builder
from bristle.engine.translation.derivative import Derivatives, activity_of, joined
from bristle.engine.translation.scope import defined
from bristle.engine.translation.slopes import SLOPES
from bristle.engine.translation.tree import INTEGER, REAL, TRUTH, Array, type_of

STEP = 2.0**-650


class Part(NamedTuple):
    low: float
    turns: int = 3
    high: float = 0.5


class Outer(NamedTuple):
    inner: Part
    rate: float
    table: np.ndarray


@kernel
def arithmetic(x, y, n, memory, p):
    total = 3.0 * x - y / 4.0 + x * y - 2.0 / y - (1.0 - x)
    total -= x / y + y / (x + n) - -x * y
    total *= 0.5 + x * x
    return total - 1.0 + n + 5.0 - (7.0 + y) + (y - 3.0) * n


@kernel
def functions(x, y, n, memory, p):
    plain = (
        abs(x)
        + abs(-0.0 * y)
        + math.fabs(y - 9.0)
        + math.copysign(x, y)
        + math.copysign(3.0, x)
        - math.copysign(y, -2.0)
    )
    roots = math.sqrt(abs(x) + 1.0) * exp(-y) + power(abs(x) + 0.5, abs(y) + 1.27)
    parts = mantissa(abs(y) + 3.0) * power_of_two(exponent(abs(x) + 5.0))
    return plain + roots + parts + power(2.0, x) + power(abs(x) + 0.1, 2.5) + exp(2.0) * x


@kernel
def limits(x, y, n, memory, p):
    one_sided = min(x, 0.25) + 2.0 * min(0.5, y) + 4.0 * max(x, -0.25) + 8.0 * max(-0.5, y)
    return (
        one_sided
        + 16.0 * min(x, y)
        + 32.0 * max(x, y)
        + 64.0 * max(min(x, y, 0.1), -y, -0.3)
        + min(1.0, 2.0) * x
    )


@kernel
def choices(x, y, n, memory, p):
    near = 1.0
    if x > 0.0:
        near = x * y
        if n > 2:
            near += y
    elif y > 0.0:
        far = 3.0 * y
        near = far * far
    else:
        near = -2.0
    return (
        near
        + (x if y > 0.5 else 2.0)
        + (y if n == 2 else (x * x if x < 0.0 else y * x))
        + (1.0 if x > 0.0 else 2.0) * y
    )


@kernel
def loops(x, y, n, memory, p):
    total, before, last = 0.0, 1.0, 2.0
    for i in range(n):
        if i == 2:
            continue
        total += last * y
        last = before
        before = i * x
        if total > 3.0:
            break
    k = 0
    while k < n:
        k += 1
        if k == 4:
            return total - k * x
        total = total * y + k
    return total + last


@kernel
def stores(x, y, n, memory, p):
    memory[0] = x
    memory[1] = memory[0] * y + memory[2]
    memory[n % 3] += 2.0 * x
    filled(memory, 1, y)
    at = n % 2
    if x < 0.0:
        memory[2] = 7.0
    memory[0], memory[1] = memory[1], memory[0]
    return memory[at] + p.table[1] * x + p.table[at] + len(memory)


@kernel
def filled(memory, at, x):
    memory[at] = memory[at] + x * x
    memory[at + 1] = x


@kernel
def parts_of(x, n):
    """Return a tuple of which the first two have a tangent."""
    return Part(x, n, x * x), x + 1.0, 5.0, n


@kernel
def tuples(x, y, n, memory, p):
    whole = parts_of(y, n)
    part, shifted, steady, turns = parts_of(x, n)
    _ = parts_of(steady, turns)
    return (
        Outer(Part(part.high, part.turns, whole[0].high), shifted + whole[2], p.table),
        steady,
        whole[1] * p.inner.high,
        part.low,
    )


@kernel
def uneven(x, y, n, memory, p):
    """Return a tuple whose fields have tangents in some branches only."""
    if x > 1.0:
        return Part(x, n, 0.5), 1.0, Part(1.0, 2, 3.0), y
    if y > 1.0:
        return Part(0.5, n, y), x, Part(1.0, 2, 3.0), 2.0
    part = Part(1.0, 5, y) if x > 0.0 else Part(x, 1, 2.0)
    part = part if n > 2 else p.inner
    last = (1.0, x) if n > 3 else (y, 2.0)
    return part, last[0], Part(1.0, 3, 3.0), last[1]


@kernel
def rests(x, y, n, memory, p):
    """Return numbers that stand still: made of whole numbers, truths and places."""
    whole = int(x * 10.0) + math.floor(y)
    shift = 0.5 if math.isnan(x) or math.isinf(y) else float(whole)
    return shift + whole, x > y, n, exponent(abs(x) + 1.0)


@kernel
def before_itself(x, y, n, memory, p):
    """Return what the third round over the variables first shows to have a tangent."""
    a, b, c, d = 1.0, 1.0, 1.0, 1.0
    for _ in range(n):
        d = c
        c = b
        b = a
        a = x
    return d + 0.0 * y


KERNELS = (
    arithmetic,
    functions,
    limits,
    choices,
    loops,
    stores,
    tuples,
    uneven,
    rests,
    before_itself,
)
OUTER = Outer(Part(0.75, 2, -1.5), 0.1, np.array([1.5, -2.0]))
TYPES = [REAL, REAL, INTEGER, Array(3, writable=True), type_of(OUTER)]
RANDOM = np.random.default_rng(5)
MEMORY = np.array([0.5, -1.5, 2.5])
DX, DY = RANDOM.uniform(-1.0, 1.0, (2, DIRECTIONS))
D_MEMORY, D_OUTER = (
    RANDOM.uniform(-1.0, 1.0, (3, DIRECTIONS)),
    RANDOM.uniform(-1.0, 1.0, (7, DIRECTIONS)),
)
TANGENTS_OF_OUTER = ((D_OUTER[0], D_OUTER[2]), D_OUTER[3], D_OUTER[5:].ravel())


def agrees(value, tangent, activity, expected):
    """Hold a value and its tangent against complex numbers; what has no tangent must not move."""
    if isinstance(activity, tuple):
        rest = iter(tangent)
        for field, active, complex_field in zip(value, activity, expected, strict=True):
            does = active is True or (isinstance(active, tuple) and joined_all(active))
            agrees(
                field,
                next(rest) if does else (),
                active if does else still_of(active),
                complex_field,
            )
        assert not list(rest)
    elif isinstance(value, np.ndarray):
        moved = np.array(
            [imaginary_of(number) / STEP + np.zeros(DIRECTIONS) for number in expected]
        )
        np.testing.assert_allclose(
            np.reshape(tangent, (-1, DIRECTIONS)) if activity else 0.0 * moved,
            moved,
            rtol=1e-13,
            atol=1e-13,
        )
    else:
        assert value == real_of(expected)
        moved = imaginary_of(expected) / STEP + np.zeros(DIRECTIONS)
        np.testing.assert_allclose(
            tangent if activity else np.zeros(DIRECTIONS), moved, rtol=1e-12, atol=1e-13
        )


def joined_all(activity):
    return any(joined_all(part) if isinstance(part, tuple) else part for part in activity)


def still_of(activity):
    return tuple(map(still_of, activity)) if isinstance(activity, tuple) else False


@pytest.mark.parametrize("function", KERNELS, ids=lambda function: function.__name__)
@pytest.mark.parametrize("moving", ["all", "x", "memory"])
def test_a_derived_kernel_agrees_with_the_complex_step(function, moving):
    of_p = activity_of(TYPES[4])
    activities = [
        moving != "memory",
        moving == "all",
        False,
        True,
        of_p if moving == "all" else still_of(of_p),
    ]
    derivatives = Derivatives()
    derived = derivatives.of(Builder().function(function, TYPES), activities)
    for x in (-1.25, -0.3, 0.0, 0.3, 2.75):
        for y in (-0.75, 0.2, 0.7, 1.5):
            for n in (1, 2, 3, 5):
                memory, d_memory = MEMORY.copy(), D_MEMORY.ravel().copy()
                tangents = (
                    [DX] * activities[0]
                    + [DY] * activities[1]
                    + [d_memory]
                    + [TANGENTS_OF_OUTER] * (moving == "all")
                )
                outcome = (
                    derivatives.scope[derived.name](x, y, n, memory, OUTER, *tangents)
                    if derived.is_needed
                    else function(x, y, n, memory, OUTER)
                )
                value, tangent = outcome if joined_all((derived.result,)) else (outcome, ())
                memories = np.array([*map(complex_number, MEMORY, D_MEMORY)], dtype=object)
                with complex_mathematics():
                    expected = function(
                        complex_number(x, DX) if activities[0] else x,
                        complex_number(y, DY) if activities[1] else y,
                        n,
                        memories,
                        seeded(OUTER, D_OUTER) if moving == "all" else OUTER,
                    )
                agrees(value, tangent, derived.result, expected)
                agrees(memory, d_memory, True, memories)
                assert memory.tolist() == list(map(real_of, memories))


def complex_number(real, tangent):
    return Complex(real, tangent * STEP)


def derived_of(text, kinds, activities, **names):
    scope = {"math": math, "Part": Part, "parts_of": parts_of, "__name__": __name__} | names
    derivatives = Derivatives()
    return derivatives, derivatives.of(
        Builder().function(kernel(defined("tried", text, scope)), kinds), activities
    )


@kernel
def rests_of_two(x, y, n):
    return math.floor(x + y) + n


@pytest.mark.parametrize(
    ("value", "active"),
    [("x * x + n", False), ("parts_of(x, n)", False), ("rests_of_two(x, x, n)", True)],
    ids=["a number", "a tuple", "a constant result"],
)
def test_values_without_tangents_are_not_derived(value, active):
    derivatives, derived = derived_of(
        f"def tried(x, n):\n    return {value}\n",
        [REAL, INTEGER],
        [active, False],
        rests_of_two=rests_of_two,
    )
    assert not derived.is_needed
    assert not [name for name in derivatives.scope if name.startswith("with_tangent")]


@pytest.mark.parametrize(
    ("value", "result"),
    [
        ("parts_of(x, n)", ((True, False, True), True, False, False)),
        ("parts_of(2.0, n)[0].low, parts_of(x, n)[0].turns, x", (False, False, True)),
    ],
)
def test_only_active_fields_have_tangents(value, result):
    assert (
        derived_of(f"def tried(x, n):\n    return {value}\n", [REAL, INTEGER], [True, False])[
            1
        ].result
        == result
    )


def test_a_kernel_is_derived_once_for_each_pattern_of_active_arguments():
    derivatives, builder = Derivatives(), Builder()
    function = builder.function(arithmetic, TYPES)
    patterns = [
        [first, second, False, False, still_of(activity_of(TYPES[4]))]
        for first, second in ((True, True), (True, False), (True, True))
    ]
    names = [derivatives.of(function, pattern).name for pattern in patterns]
    assert names[0] == names[2] != names[1]


@pytest.mark.parametrize(
    ("first", "second", "both"),
    [
        ((True, (False, False)), (False, (False, True)), (True, (False, True))),
        (False, True, True),
        (True, False, True),
        (False, False, False),
    ],
)
def test_two_activities_join_field_by_field(first, second, both):
    assert joined(first, second) == both


@pytest.mark.parametrize(
    ("kind", "activity"),
    [(type_of(Part(1.0)), (True, False, True)), (TRUTH, False), (Array(3), True)],
)
def test_real_numbers_are_active(kind, activity):
    assert activity_of(kind) == activity


SEARCH = "x = 1.5\n    for _ in range(30):\n        x = x - (x * x * x - a) / (3.0 * x * x)\n    return x"
NAMES = "d_x = 5.0\n    t_1 = a * a\n    d_t_1 = t_1 * (a + d_x)\n    return d_t_1 + d_x + (t_1 + a) * t_1"


@kernel
def scaled_anew(step, rate):
    step = step * rate
    return step * step


@pytest.mark.parametrize(
    ("body", "at", "value", "slope"),
    [
        (
            "return min(a, math.inf) + max(a, -math.inf) + (math.nan if a > 2.0 else 1.0)",
            1.5,
            4.0,
            2.0,
        ),
        (
            "return min(a, math.inf) + max(a, -math.inf) + (math.nan if a > 2.0 else 1.0)",
            2.5,
            math.nan,
            2.0,
        ),
        # A search of Newton has the derivative of the implicit function.
        (SEARCH, 5.0, 5.0 ** (1.0 / 3.0), 1.0 / (3.0 * 5.0 ** (2.0 / 3.0))),
        # An argument that is assigned an active value has a tangent.
        ("return scaled_anew(2.0, a)", 3.0, 36.0, 24.0),
        # Variables that are named as tangents keep their names.
        (NAMES, 2.0, 4.0 * 7.0 + 5.0 + 24.0, 3.0 * 4.0 + 10.0 * 2.0 + 4.0 * 8.0 + 3.0 * 4.0),
    ],
)
def test_a_derived_function_has_the_slope_of_its_formula(body, at, value, slope):
    derivatives, derived = derived_of(
        f"def tried(a):\n    {body}\n", [REAL], [True], scaled_anew=scaled_anew
    )
    found, tangent = derivatives.scope[derived.name](at, DX)
    assert found == pytest.approx(value, nan_ok=True)
    assert tangent == pytest.approx(slope * DX, rel=1e-14)


# --- tangents ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("tangent", "expected"),
    [
        (still(), np.zeros(DIRECTIONS)),
        (tangent_sum(DX, DY), DX + DY),
        (tangent_difference(DX, DY), DX - DY),
        (tangent_scaled(3.0, DX), 3.0 * DX),
        (tangent_combined(2.0, DX, -3.0, DY), 2.0 * DX - 3.0 * DY),
    ],
)
def test_tangents_compute_as_vectors_do(tangent, expected):
    assert tangent.tolist() == expected.tolist()


def test_storing_a_tangent_does_not_change_a_tangent_read_before():
    tangents = np.arange(3.0 * DIRECTIONS)
    before = tangent_at(tangents, 1)
    keep_tangent(tangents, 1, DX)
    assert before.tolist() == list(range(DIRECTIONS, 2 * DIRECTIONS))
    assert tangent_at(tangents, 1).tolist() == DX.tolist()
    assert tangents[:DIRECTIONS].tolist() == list(range(DIRECTIONS))
    assert tangents[2 * DIRECTIONS :].tolist() == list(range(2 * DIRECTIONS, 3 * DIRECTIONS))


# --- slopes of elementary functions -----------------------------------------------------------------------------

PLACES = {
    mathematics.exp: (
        -1e4,
        -709.0,
        EXP_MIN,
        -700.0,
        -1.0,
        0.0,
        0.3,
        1.0,
        700.0,
        EXP_MAX,
        710.0,
        1e4,
    ),
    mathematics.decay: (0.0, 1e-9, 0.5, 30.0, 707.0, 709.0),
    mathematics.expm1: (-1e4, -709.0, -40.0, -1.0, -1e-9, 0.0, 1e-9, 2.0, 700.0, 710.0),
    mathematics.tanh: (-25.0, -3.0, -1e-9, -0.0, 0.0, 1e-9, 0.5, 3.0, 25.0),
    mathematics.log: (-1.0, 0.0, 1e-310, NORMAL_MIN, 1e-300, 0.1, 1.0, 1.5, 3.0, 1e300, LARGEST),
    mathematics.log1p: (-2.0, -1.0, -0.999, -0.5, -1e-9, 0.0, 1e-20, 0.3, 0.7, 5.0, 1e300),
    mathematics.sin: (-1e5, -4.0, -2.0, -0.5, 0.0, 1.0, 2.0, 3.5, 5.0, 12.0, 1e5, 1e8),
    mathematics.cos: (-1e5, -4.0, -2.0, -0.5, 0.0, 1.0, 2.0, 3.5, 5.0, 12.0, 1e5, 1e8),
    mathematics.relaxation: (1e-3, 0.02, 0.0299, 0.03, 0.1, 1.0, 5.0, 50.0, 800.0),
}


@pytest.mark.parametrize("function", PLACES, ids=lambda function: function.__name__)
def test_a_slope_is_that_of_the_complex_step(function):
    # The two parts of a relaxation cancel near 0: there its complex step has fewer digits.
    for x in PLACES[function]:
        value, (expected,) = slopes_of(function, x)
        tolerance = 1e-12 if function is mathematics.relaxation and x < 0.1 else 4e-15
        assert SLOPES[function](x, value) == pytest.approx(
            expected, rel=tolerance * (100.0 if abs(x) > 100.0 else 1.0), abs=tolerance
        )


@pytest.mark.parametrize("rate", [0.0, 1e-12, 1e-3, 0.01, 0.0299, 0.0301, 0.2])
def test_the_slope_of_a_relaxation_is_its_series(rate):
    exact, total, term = Fraction(rate), Fraction(0), Fraction(-1, 2)
    for k in range(1, 25):
        total += term * k
        term *= -exact / (k + 2)
    assert SLOPES[mathematics.relaxation](rate, mathematics.relaxation(rate)) == pytest.approx(
        float(total), rel=5e-13
    )


@pytest.mark.parametrize("x", [1e-6, 0.3, 1.0, 2.0, 7.5])
@pytest.mark.parametrize("n", [0.2, 0.5, 1.0, 1.3, 2.0, 3.0, 4.4])
def test_slopes_of_a_power_agree_with_differences_also_in_its_shortcuts(x, n):
    value, step = mathematics.power(x, n), 1e-5
    to_base, to_exponent = SLOPES[mathematics.power](x, n, value)
    assert to_base == pytest.approx(
        ((x * (1.0 + step)) ** n - (x * (1.0 - step)) ** n) / (2.0 * step * x), rel=1e-8
    )
    assert to_exponent == pytest.approx(
        (x ** (n + step) - x ** (n - step)) / (2.0 * step), rel=1e-8, abs=1e-10
    )
    if n not in (0.5, 1.0, 2.0, 3.0):
        assert (to_base, to_exponent) == pytest.approx(
            tuple(slopes_of(mathematics.power, x, n)[1]), rel=1e-13, abs=1e-15
        )


@pytest.mark.parametrize(
    ("x", "n", "slope"),
    [
        (0.0, 1.0, 1.0),
        (0.0, 2.0, 0.0),
        (0.0, 0.5, 0.0),
        (0.0, 0.0, 0.0),
        (-1.0, 1.0, 0.0),
        (-1.0, 2.0, 0.0),
    ],
)
def test_slopes_of_a_power_are_one_sided_at_zero_and_zero_below(x, n, slope):
    assert SLOPES[mathematics.power](x, n, mathematics.power(x, n)) == (slope, 0.0)


@pytest.mark.parametrize(
    ("x", "n"), [(5e-324, 0.01), (NORMAL_MIN, 1e-3), (1e-300, 0.5), (1e300, 1.0), (1e200, 1.5)]
)
def test_slopes_of_a_power_stay_finite_on_overflow(x, n):
    assert all(map(math.isfinite, SLOPES[mathematics.power](x, n, mathematics.power(x, n))))


@pytest.mark.parametrize("x", [0.0, 1e-300, 0.25, 1.0, 3.0, 1e300])
def test_slopes_of_root_and_mantissa_agree_with_their_inverse_functions(x):
    root = math.sqrt(x)
    assert 2.0 * root * SLOPES[math.sqrt](x, root) == pytest.approx(1.0 if x else 0.0, rel=1e-15)
    if x:
        assert SLOPES[mantissa](x, mantissa(x)) == pytest.approx(
            power_of_two(-exponent(x)), rel=1e-15
        )
    assert SLOPES[mantissa](0.0, 0.0) == 0.0
