"""Solvers get finite numbers that they can square; what they find does not depend on the scale."""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import bristle
from bristle.core import InputError
from bristle.core.least_squares import bounded, left_out, non_negative, normal, unbounded

SOURCE = Path(bristle.__file__).parent
CHANCE = np.random.default_rng(3)
A = CHANCE.standard_normal((30, 4))
TRUTH = np.array([2.0, -1.0, 0.5, 3.0])
LOW, HIGH = np.full(4, -np.inf), np.array([1.0, 1.0, 1.0, np.inf])
SOLVERS = {
    "unbounded": (unbounded, TRUTH),
    "bounded": (lambda A, b: bounded(A, b, LOW, HIGH)[0], None),
    "non-negative": (non_negative, None),
}


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize(
    ("of_columns", "of_target"), [(2.0**900, 1.0), (1.0, 2.0**900), (2.0**-900, 2.0**-900)]
)
def test_no_scale_costs_a_digit(name, of_columns, of_target):
    solve, expected = SOLVERS[name]
    reference = solve(A, A @ TRUTH)
    if expected is not None:
        np.testing.assert_allclose(reference, expected, rtol=1e-12)
    if name == "bounded":  # the bounds go with the solution

        def solve(A, b):
            return bounded(A, b, LOW * (of_target / of_columns), HIGH * (of_target / of_columns))[0]

    result = solve(A * of_columns, (A @ TRUTH) * of_target)
    np.testing.assert_allclose(result * of_columns / of_target, reference, rtol=1e-12)


def test_active_bounds_are_reported():
    result, active = bounded(A, A @ TRUTH, LOW, HIGH)
    assert (active[0], active[3], result[0]) == (1, 0, 1.0)
    assert np.all(result <= HIGH)


def test_no_part_is_negative_and_the_rest_fits_best():
    result = non_negative(A, A @ TRUTH)
    assert np.all(result >= 0.0)
    assert result[1] == 0.0
    np.testing.assert_allclose(result[[0, 2, 3]], unbounded(A[:, [0, 2, 3]], A @ TRUTH), rtol=1e-10)


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("of_target", [False, True])
def test_only_finite_numbers_reach_a_solver(name, bad, of_target):
    spoiled = np.where(np.arange(30) == 3, bad, 1.0)
    with pytest.raises(InputError, match="exceeds the range of floating-point numbers"):
        SOLVERS[name][0](*((A, spoiled) if of_target else (A * spoiled[:, None], A @ TRUTH)))


def test_solvers_are_called_only_in_this_module():
    calls = re.compile(r"\b(lstsq|nnls|lsq_linear)\(")
    result = {
        file.name for file in SOURCE.rglob("*.py") if calls.search(file.read_text(encoding="utf-8"))
    }
    assert result == {"least_squares.py"}


def test_normal_equations_are_solved_for_unknowns_of_any_scale():
    sizes = np.array([1e-6, 1.0, 1e4, 1e8])
    columns = A * sizes
    result = normal(columns.T @ columns, columns.T @ (A @ TRUTH), rcond=1e-12)
    np.testing.assert_allclose(result * sizes, TRUTH, rtol=1e-9)
    # An unknown that no equation tells is nothing.
    gram = np.diag([4.0, 0.0])
    np.testing.assert_allclose(normal(gram, np.array([8.0, 0.0]), rcond=1e-12), [2.0, 0.0])


def test_without_each_block_the_others_are_solved():
    b = A @ TRUTH
    b[6:12] += 5.0
    parts = left_out(A.T, b, 5, rcond=1e-12)
    assert [(part.shape, of_b.shape) for part, of_b, _ in parts] == [((4, 6), (6,))] * 5
    np.testing.assert_array_equal(parts[1][1], b[6:12])
    # The spoiled block is the one left out.
    np.testing.assert_allclose(parts[1][2], TRUTH, rtol=1e-9)
    for number in (0, 2, 3, 4):
        kept = np.r_[0 : 6 * number, 6 * number + 6 : 30]
        np.testing.assert_allclose(parts[number][2], unbounded(A[kept], b[kept]), rtol=1e-9)
        assert np.max(np.abs(parts[number][2] - TRUTH)) > 0.1


@pytest.mark.parametrize(
    "result",
    [unbounded(A, np.zeros(30)), unbounded(0.0 * A, A @ TRUTH), non_negative(0.0 * A, A @ TRUTH)],
)
def test_a_problem_without_target_or_columns_has_a_zero_solution(result):
    assert result.tolist() == [0.0] * 4


def test_a_bounded_solution_is_within_its_bounds_although_the_solver_rounds(monkeypatch):
    result = SimpleNamespace(x=np.array([-1e-18, 2.0 + 1e-15]), active_mask=np.array([-1, 1]))
    monkeypatch.setattr("scipy.optimize.lsq_linear", lambda *_, **__: result)
    x, _ = bounded(np.eye(2), np.array([-1.0, 3.0]), np.zeros(2), np.full(2, 2.0))
    assert x.tolist() == [0.0, 2.0]
