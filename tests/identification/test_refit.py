"""A refit goes downhill, even if its first step overshoots."""

import numpy as np
import pytest

from bristle.identification.parameter_space import ParameterSpace, Solution
from bristle.identification.refit import Refit

ANYWHERE = ParameterSpace(("x",), np.array([-np.inf]), np.array([np.inf]), linear=False)


class Steep:
    """One row, x + x^3 in some unit of force: far from its zero it is much steeper than there."""

    def __init__(self, unit=1.0):
        self.unit = unit

    def residual(self, free):
        return self.unit * np.array([-(free["x"] + free["x"] ** 3)])


@pytest.mark.parametrize("start", [-12.0, -1.8, 1.2, 2.0, 5.0])
def test_a_step_that_leads_uphill_is_shortened(start):
    solution = Solution(ANYWHERE, np.zeros(1), np.ones((1, 1)))
    x, residual = Refit(solution).solve(Steep(), np.array([start]))
    # The slope at the solution is 1: the whole first step ends beyond the other side of it, further up than the start.
    overshot = start - (start + start**3)
    assert abs(overshot + overshot**3) > abs(start + start**3)
    assert abs(x[0]) < 0.5 * abs(start)
    assert residual[0] == pytest.approx(-(x[0] + x[0] ** 3))


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_the_solution_does_not_depend_on_units(unit):
    plain, other = (
        Refit(Solution(ANYWHERE, np.zeros(1), np.full((1, 1), size))).solve(Steep(size), np.array([0.6]))[0] for size in (1.0, unit)
    )
    assert other == pytest.approx(plain, rel=1e-9)
    # Not after the first step, which leaves more than a third.
    assert abs(plain[0]) < 0.05


def step_of(low, high, residual, theta=(1.0, 1.0)):
    """The step of two coordinates whose columns are 1 and 2 long, at a right angle."""
    space = ParameterSpace(("x", "y"), np.array(low), np.array(high))
    solution = Solution(space, np.zeros(2), np.array([[1.0, 0.0], [0.0, 2.0], [0.0, 0.0]]))
    return Refit(solution).step(np.array(theta), np.array(residual)).tolist()


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        ((-np.inf, -np.inf), (np.inf, np.inf), (-3.0, 2.0)),
        ((0.0, -np.inf), (np.inf, np.inf), (-1.0, 2.0)),
        ((0.0, 0.0), (np.inf, np.inf), (-1.0, 2.0)),
        ((-np.inf, -np.inf), (np.inf, 2.5), (-3.0, 1.5)),
        ((0.0, 0.0), (9.0, 1.5), (-1.0, 0.5)),
        ((1.0, 0.0), (9.0, 1.0), (0.0, 0.0)),
    ],
)
def test_a_step_ends_at_the_bounds(low, high, expected):
    assert step_of(low, high, (-3.0, 4.0, 5.0)) == pytest.approx(expected, abs=1e-9)


def test_a_linear_signal_is_solved_by_one_step_on_the_fitted_rows():
    space = ParameterSpace(("x", "y"), np.full(2, -np.inf), np.full(2, np.inf))
    jacobian = np.array([[1.0, 0.0], [0.0, 2.0], [1.0, 1.0]])
    solution, signal = Solution(space, np.zeros(2), jacobian), np.array([3.0, 8.0, 7.0])

    class Plane:
        def residual(self, free):
            return signal - jacobian @ [free["x"], free["y"]]

    theta, residual = Refit(solution).solve(Plane(), np.array([9.0, -5.0]))
    assert theta.tolist() == pytest.approx([3.0, 4.0])
    assert residual == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    signal[1] = 80.0
    theta, residual = Refit(solution, rows=np.array([True, False, True])).solve(Plane(), np.array([0.0, 2.0]))
    assert theta.tolist() == pytest.approx([3.0, 4.0])
    assert residual == pytest.approx([0.0, 72.0, 0.0], abs=1e-12)
