"""A fit that is made again goes downhill, even where its first step would lead too far."""

import numpy as np
import pytest

from bristle.identification.parameter_space import ParameterSpace, Solution
from bristle.identification.refit import Refit

ANYWHERE = ParameterSpace(("x",), np.array([-np.inf]), np.array([np.inf]), linear=False)


class Steep:
    """One row, x + x^3: far from its zero it is much steeper than there."""

    def residual(self, free):
        return np.array([-(free["x"] + free["x"] ** 3)])


@pytest.mark.parametrize("start", [-1.8, 1.2, 2.0])
def test_where_a_whole_step_leads_uphill_a_part_of_it_is_taken(start):
    solution = Solution(ANYWHERE, np.zeros(1), np.ones((1, 1)))
    x, residual = Refit(solution, np.ones(1, dtype=bool)).solve(Steep(), np.array([start]))
    # The slope at the solution is 1: the whole first step ends beyond the other side of it, further up than the start.
    overshot = start - (start + start**3)
    assert abs(overshot + overshot**3) > abs(start + start**3)
    assert abs(x[0]) < 0.5 * abs(start)
    assert residual[0] == pytest.approx(-(x[0] + x[0] ** 3))
