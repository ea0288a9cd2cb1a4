"""A fit that is made again goes downhill, even where its first step would lead too far."""

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


@pytest.mark.parametrize("start", [-1.8, 1.2, 2.0])
def test_where_a_whole_step_leads_uphill_a_part_of_it_is_taken(start):
    solution = Solution(ANYWHERE, np.zeros(1), np.ones((1, 1)))
    x, residual = Refit(solution, np.ones(1, dtype=bool)).solve(Steep(), np.array([start]))
    # The slope at the solution is 1: the whole first step ends beyond the other side of it, further up than the start.
    overshot = start - (start + start**3)
    assert abs(overshot + overshot**3) > abs(start + start**3)
    assert abs(x[0]) < 0.5 * abs(start)
    assert residual[0] == pytest.approx(-(x[0] + x[0] ** 3))


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_where_it_ends_depends_on_no_unit(unit):
    plain, other = (
        Refit(Solution(ANYWHERE, np.zeros(1), np.full((1, 1), size)), np.ones(1, dtype=bool)).solve(Steep(size), np.array([0.6]))[0]
        for size in (1.0, unit)
    )
    assert other == pytest.approx(plain, rel=1e-9)
    # Not after the first step, which leaves more than a third.
    assert abs(plain[0]) < 0.05
