"""Elementary functions: as exact as the C library, without traps, and the same bits compiled."""

import math

import mpmath
import numpy as np
import pytest

from bristle.core import mathematics
from bristle.core.kernel import activate, kernel_options
from bristle.core.mathematics import (
    NEWTON_LAST,
    Bracket,
    bracket_guess,
    bracket_update,
    newton_from,
    newton_next,
)

UNIT = np.finfo(float).eps


def points():
    generator = np.random.default_rng(7)
    small = generator.choice((-1.0, 1.0), 5000) * 10 ** generator.uniform(-20, 0, 5000)
    return np.concatenate(
        [generator.uniform(-708.0, 709.0, 5000), small, [0.0, 1.0, -1.0, 0.5 * math.log(2.0)]]
    )


@pytest.mark.parametrize(
    ("ours", "library"), [(mathematics.exp, math.exp), (mathematics.expm1, math.expm1)]
)
def test_exponentials_agree_with_the_library_to_rounding(ours, library):
    for x in points().tolist():
        assert ours(x) == pytest.approx(library(x), rel=3 * UNIT, abs=0.0), x


def errors(name, x):
    """Return how far each value is from the true one, in units of the last place of that."""
    function = getattr(mathematics, name)
    with mpmath.workprec(200):
        true = [getattr(mpmath, name)(mpmath.mpf(item)) for item in x]
        return [
            float(abs(mpmath.mpf(function(item)) - t) / math.ulp(float(t)))
            for item, t in zip(x, true, strict=True)
        ]


def decades(low, high, count=1500, seed=3):
    generator = np.random.default_rng(seed)
    return generator.choice((-1.0, 1.0), count) * 10.0 ** generator.uniform(low, high, count)


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sine_and_cosine_are_within_a_unit_of_the_last_place_up_to_a_million(name):
    generator = np.random.default_rng(5)
    # The multiples of a quarter turn and their neighbours are where a reduction loses its digits.
    turns = np.append(generator.integers(-636_000, 636_000, 1500), np.arange(-40, 41)) * (
        0.5 * math.pi
    )
    beside = np.concatenate([turns, np.nextafter(turns, np.inf), np.nextafter(turns, -np.inf)])
    spread = np.concatenate(
        [generator.uniform(-10.0, 10.0, 1500), generator.uniform(-1e6, 1e6, 1500)]
    )
    x = np.concatenate([beside, spread, decades(-300.0, 6.0), [0.0, -0.0, 1e6, -1e6]])
    assert np.max(errors(name, x.tolist())) < 0.85


@pytest.mark.parametrize(
    ("name", "parts", "most"),
    [
        (
            "log",
            [
                np.abs(decades(-307.0, 308.0)),
                1.0 + decades(-16.0, -0.5),
                [1.0, 2.0, 0.5, 2.3e-308, 1.7e308],
            ],
            0.85,
        ),
        (
            "log1p",
            [
                decades(-300.0, -0.4),
                np.abs(decades(-3.0, 308.0)),
                np.abs(decades(-15.5, -0.01)) - 1.0,
                np.random.default_rng(4).uniform(-0.35, 0.45, 2000),
                [0.0, 0.41421356, -0.29289322, 1.0, 1e16, 3e16],
            ],
            0.85,
        ),
        # Near 1, correctly rounded.
        ("log1p", [decades(-17.0, -12.0, 900), decades(-12.0, -4.0, 200)], 0.501),
        ("tanh", [decades(-300.0, 2.5), decades(-2.0, 0.5)], 3.0),
    ],
    ids=["log", "log1p", "log1p near 0", "tanh"],
)
def test_logarithms_and_the_hyperbolic_tangent_are_within_units_of_the_last_place(
    name, parts, most
):
    assert np.max(errors(name, np.concatenate(parts).tolist())) < most


INF, NAN = math.inf, math.nan
NEAR_THE_SEAMS = (-0.2928, -0.2930, 0.4142, 0.4143, 1.5, 3.0, 1e-8, -1e-8, 1e3, 2.0**53, -0.999999)


@pytest.mark.parametrize(
    ("name", "arguments", "expected"),
    [
        *(
            ("relaxation", (rate,), -math.expm1(-rate) / rate)
            for rate in (1e-320, 1e-40, 1e-17, 1e-9, 1e-3, 0.7, 30.0, 800.0, 1e300)
        ),
        ("relaxation", (0.0,), 1.0),
        *(
            ("exp", (x,), value)
            for x, value in (
                (0.0, 1.0),
                (-1e300, 0.0),
                (-INF, 0.0),
                (NAN, NAN),
                (1e300, mathematics.exp(709.0)),
            )
        ),
        ("expm1", (-1e300,), -1.0),
        *((name, (NAN,), NAN) for name in ("sin", "cos", "tanh", "log", "log1p")),
        *(("sin", (x,), value) for x, value in ((INF, NAN), (1e300, 0.0))),
        *(("cos", (x,), value) for x, value in ((-INF, NAN), (1e300, 1.0))),
        ("tanh", (-INF,), -1.0),
        ("log", (INF,), INF),
        ("log1p", (INF,), INF),
        *(
            (name, (x,), mathematics.log(0.0))
            for name, x in (("log", -1.0), ("log1p", -1.0), ("log1p", -7.0))
        ),
        *(("log1p", (x,), math.log1p(x)) for x in NEAR_THE_SEAMS),
        *(
            ("hyperbolic_mean", (u,), math.log1p(u) / u)
            for u in (-0.5, -0.0101, -0.0099, -1e-5, 1e-9, 1e-3, 0.0099, 0.0101, 0.7, 30.0)
        ),
        ("hyperbolic_mean", (0.0,), 1.0),
        *(("power", (x, 0.5), math.sqrt(x)) for x in np.abs(decades(-300.0, 300.0, 20)).tolist()),
        *(("power", (0.0, y), float(y == 0.0)) for y in (0.0, 0.5, 1.0, 2.0, 3.0, 2.5)),
        *(("power", (-2.0, y), float(y == 0.0)) for y in (0.0, 1.0, 2.0)),
        *(("power", (x, 1.7), 0.0) for x in (0.0, -0.0, -1.0)),
        *(
            ("power", (1.7, y), value)
            for y, value in ((0.0, 1.0), (1.0, 1.7), (2.0, 1.7 * 1.7), (3.0, 1.7 * 1.7 * 1.7))
        ),
        *(
            ("direction", (v,), side)
            for v, side in ((2.0, 1.0), (0.0, 1.0), (-0.0, -1.0), (-3.0, -1.0))
        ),
    ],
)
def test_special_arguments_have_exact_results(name, arguments, expected):
    assert getattr(mathematics, name)(*arguments) == pytest.approx(
        expected, rel=4e-16, abs=0.0, nan_ok=True
    )


def test_the_logarithm_of_zero_is_finite():
    assert math.isfinite(mathematics.log(0.0))


def test_angles_of_many_turns_keep_the_accuracy_of_their_digits():
    for x in decades(6.0, 14.9).tolist():
        assert abs(mathematics.sin(x) - math.sin(x)) <= math.ulp(x), x
        assert abs(mathematics.cos(x) - math.cos(x)) <= math.ulp(x), x


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize(
    "name",
    [
        "exp",
        "expm1",
        "relaxation",
        "fitted_weight",
        "log",
        "log1p",
        "sin",
        "cos",
        "tanh",
        "hyperbolic_mean",
    ],
)
def test_compiled_functions_give_the_same_bits(name):
    import numba

    activate()
    function = getattr(mathematics, name)

    @numba.njit(**kernel_options(inline=False))
    def over(x, y):
        for i in range(x.size):
            y[i] = function(x[i])

    quarters = np.arange(-500, 501) * (0.5 * math.pi)
    x = np.concatenate(
        [
            points(),
            quarters,
            decades(-300.0, 300.0),
            [-1e300, 1e300, -math.inf, math.inf, 5e-324, 1e8],
        ]
    )
    x = (
        np.abs(x[np.isfinite(x)])
        if name in ("relaxation", "fitted_weight", "hyperbolic_mean")
        else x
    )
    compiled = np.empty(x.size)
    over(x, compiled)
    plain = np.array([function(item) for item in x.tolist()])
    assert np.array_equal(compiled, plain, equal_nan=True)


def test_a_decay_has_the_bits_of_the_exponential():
    for x in [
        0.0,
        *np.abs(decades(-300.0, 3.0)).tolist(),
        708.0,
        np.nextafter(708.0, 709.0),
        1e300,
        math.inf,
    ]:
        assert mathematics.decay(x) == mathematics.exp(-x)


def test_the_smooth_step_rises_as_half_a_sine():
    y = np.linspace(0.0, 1.0, 1001)
    with mpmath.workprec(200):
        true = [(1 + mpmath.sin(mpmath.pi * (mpmath.mpf(item) - 0.5))) / 2 for item in y.tolist()]
        slope = [
            mpmath.pi * mpmath.cos(mpmath.pi * (mpmath.mpf(item) - 0.5)) / 2 for item in y.tolist()
        ]
    ours = [mathematics.smooth_step(item) for item in y.tolist()]
    assert max(abs(a - b) for a, b in zip(ours, true, strict=True)) < 2 * UNIT
    points = [mathematics.smooth_step_point(item) for item in y.tolist()]
    assert [point[0] for point in points] == ours
    ours = [point[1] for point in points]
    assert max(abs(a - b) for a, b in zip(ours, slope, strict=True)) < 4 * UNIT


def test_means_of_a_decay_are_exact_to_rounding_for_every_argument():
    rates = np.abs(
        np.concatenate(
            [
                decades(-300.0, 2.5, 600),
                decades(-3.0, 0.0, 600),
                [0.03, 0.01, np.nextafter(0.01, 1.0)],
            ]
        )
    )
    with mpmath.workprec(300):
        for item in rates.tolist():
            y = mpmath.mpf(item)
            assert abs(mathematics.relaxation(item) / (-mpmath.expm1(-y) / y) - 1) < 4 * UNIT
            assert abs(mathematics.hyperbolic_mean(item) / (mpmath.log1p(y) / y) - 1) < 3 * UNIT
            if item < 1.0:
                assert (
                    abs(mathematics.hyperbolic_mean(-item) / (mpmath.log1p(-y) / -y) - 1) < 3 * UNIT
                )


@pytest.mark.parametrize("y", [0.1, 0.5, 1.0, 1.7, 2.0, 2.5, 3.0, 4.0])
def test_powers_are_exact_but_for_the_rounding_of_their_logarithm(y):
    whole = y in (0.5, 1.0, 2.0, 3.0)
    with mpmath.workprec(200):
        for x in np.abs(decades(-20.0, 20.0, 100)).tolist():
            most = 2.0 if whole else 3.0 + abs(y * math.log(x))
            assert abs(mathematics.power(x, y) / mpmath.power(x, y) - 1) < most * UNIT
    assert [mathematics.power(x, y) for x in (0.0, -0.0, -1.0)] == [0.0] * 3


def test_the_fitted_weight_is_exact_to_the_last_places_on_both_sides_of_its_seams():
    rates = np.concatenate(
        [
            np.geomspace(1e-8, 50.0, 400),
            [np.nextafter(0.03, 0.0), 0.03, np.nextafter(0.25, 0.0), 0.25],
        ]
    )
    with mpmath.workprec(300):
        for rate in rates.tolist():
            x = mpmath.mpf(rate)
            assert abs(mathematics.fitted_weight(rate) - (1 / (1 - mpmath.exp(-x)) - 1 / x)) < 2e-15


def result(function, slope, search):
    """The root that a search comes to, and how many times it looked."""
    while abs(function(search.x)) > 1e-13 and search.rounds < 100:
        search = newton_next(search, function(search.x), slope(search.x))
    return search.x, search.rounds


@pytest.mark.parametrize("begin", [0.0, 0.3, 2.0])
def test_newtons_search_finds_the_root_in_few_steps(begin):
    root, rounds = result(lambda x: x**3 - 0.5, lambda x: 3.0 * x**2, newton_from(2.0, begin))
    assert root == pytest.approx(0.5 ** (1.0 / 3.0), abs=1e-12)
    assert rounds <= 10


SEARCH = newton_from(8.0, 3.0)
ABOVE = newton_next(SEARCH, 1.0, 0.0)


@pytest.mark.parametrize(
    ("search", "value", "slope", "expected"),
    [
        (SEARCH, -1.0, 0.0, (3.0, 8.0, 5.5, 5.0, 1)),  # the root lies above
        (SEARCH, 1.0, 0.0, (0.0, 3.0, 0.0, 3.0, 1)),  # the root lies below
        (ABOVE, -1.0, 0.0, (0.0, 3.0, 1.5, 3.0, 2)),
        (SEARCH, 1.0, 0.5, (0.0, 3.0, 1.0, 2.0, 1)),  # a step of Newton's within the interval
        (SEARCH, 1.0, 0.25, (0.0, 3.0, 1.5, 3.0, 1)),  # one beyond the interval
        # One that is no shorter than half of the last.
        (SEARCH._replace(step=3.0), 1.0, 0.5, (0.0, 3.0, 1.5, 3.0, 1)),
        (SEARCH._replace(rounds=16), 1.0, 0.5, (0.0, 3.0, 1.5, 3.0, 17)),
        (SEARCH, 0.0, 1.0, (3.0, 8.0, 3.0, 0.0, 1)),
    ],
)
def test_newtons_search_bisects_without_a_useful_slope(search, value, slope, expected):
    assert SEARCH == (0.0, 8.0, 3.0, 16.0, 0)
    assert newton_next(search, value, slope) == expected


def test_a_step_function_is_found_to_the_last_place():
    search = newton_from(1.0, 1.0)
    for _ in range(NEWTON_LAST):
        search = newton_next(search, 1.0 if search.x > 0.3 else -1.0, 1e-3)
    assert search.high - search.low <= 1e-15
    assert search.low <= 0.3 <= search.high


@pytest.mark.parametrize(
    "function",
    [
        lambda x: x**9 - 0.2,
        lambda x: math.expm1(9.0 * (x - 0.9)),
        lambda x: math.atan(50.0 * (x - 0.1)),
    ],
)
def test_a_bracket_closes_in_on_its_root_from_both_sides(function):
    bracket = Bracket(0.0, function(0.0), 1.0, function(1.0), 0.0)
    for _ in range(40):
        x = bracket_guess(bracket)
        assert bracket.low < x < bracket.high
        if abs(function(x)) < 1e-12:
            break
        bracket = bracket_update(bracket, x, function(x))
    assert abs(function(x)) < 1e-12


BRACKET = Bracket(1.0, -2.0, 5.0, 6.0, 0.0)


@pytest.mark.parametrize(
    ("bracket", "x", "value", "expected"),
    [
        (BRACKET, 2.0, -1.0, (2.0, -1.0, 5.0, 6.0, -1.0)),
        (Bracket(2.0, -1.0, 5.0, 6.0, -1.0), 2.5, -0.5, (2.5, -0.5, 5.0, 3.0, -2.0)),
        (Bracket(2.5, -0.5, 5.0, 3.0, -2.0), 2.6, -0.4, (2.6, -0.4, 5.0, 1.5, -3.0)),
        (Bracket(2.6, -0.4, 5.0, 1.5, -3.0), 3.8, -0.1, (3.8, -0.1, 5.0, 0.75, 0.0)),
        (BRACKET, 2.0, 1.0, (1.0, -2.0, 2.0, 1.0, 1.0)),
        (BRACKET._replace(stalled=1.0), 2.0, 1.0, (1.0, -1.0, 2.0, 1.0, 2.0)),
        (BRACKET._replace(stalled=3.0), 2.0, 1.0, (1.0, -1.0, 2.0, 1.0, 0.0)),
        (BRACKET._replace(stalled=-2.0), 2.0, 1.0, (1.0, -2.0, 2.0, 1.0, 1.0)),
        (BRACKET._replace(stalled=2.0), 2.0, -1.0, (2.0, -1.0, 5.0, 6.0, -1.0)),
    ],
)
def test_a_bracket_halves_the_value_of_an_end_that_stays(bracket, x, value, expected):
    assert bracket_update(bracket, x, value) == expected


@pytest.mark.parametrize(
    ("bracket", "guess"),
    [
        (BRACKET, 2.0),  # where the line between both ends crosses
        (Bracket(2.6, -0.4, 5.0, 1.5, -3.0), 3.8),  # the middle, for it stalls
        (BRACKET._replace(stalled=3.0), 3.0),
        (BRACKET._replace(stalled=-3.0), 3.0),
        (Bracket(1.0, 1.0, 5.0, 1.0, 0.0), 3.0),
        (Bracket(1.0, 0.0, 5.0, 1.0, 0.0), 3.0),  # an end is no new place
    ],
)
def test_a_bracket_that_stalls_is_halved(bracket, guess):
    assert bracket_guess(bracket) == pytest.approx(guess)
