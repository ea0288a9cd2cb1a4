"""The best of a search that may be interrupted."""

from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest

from bristle.core.diagnostic import BestSoFar, to_the_end


def test_the_best_is_the_cheapest_point_and_its_numbers_stay():
    best = BestSoFar()
    assert (best.at, best.result, best.whole) == (None, None, False)
    at = np.array([1.0, 2.0])
    best.see(at, 3.0)
    best.see(np.array([9.0, 9.0]), 3.0)
    at[0] = 7.0
    assert (best.at.tolist(), best.cost) == ([1.0, 2.0], 3.0)
    best.see(at, 2.0)
    assert (best.at.tolist(), best.cost) == ([7.0, 2.0], 2.0)


def test_the_cheapest_completed_descent_is_kept():
    best, first = BestSoFar(), SimpleNamespace(cost=2.0, theta=np.array([1.0, -1.0]))
    assert not best.is_known(np.zeros(2))
    for taken, kept in ((2.0, first), (5.0, first), (1.0, None)):
        best.take(first)
        other = SimpleNamespace(cost=taken, theta=np.zeros(2))
        best.take(other)
        assert best.result is (kept or other)


@pytest.mark.parametrize(
    ("at", "is_known"), [([1.019, -1.019], True), ([1.021, -1.0], False), ([1.0, -0.979], False)]
)
def test_a_point_near_a_completed_descent_is_known(at, is_known):
    best = BestSoFar()
    best.take(SimpleNamespace(cost=2.0, theta=np.array([1.0, -1.0])))
    assert bool(best.is_known(np.array(at))) is is_known


@pytest.mark.parametrize(("interruptions", "expected"), [(0, (5, False)), (1, (5, True))])
def test_short_work_that_a_person_interrupts_is_done_again(interruptions, expected):
    assert to_the_end(Mock(side_effect=[*[KeyboardInterrupt] * interruptions, 5])) == expected


def test_short_work_that_a_person_interrupts_twice_ends():
    with pytest.raises(KeyboardInterrupt):
        to_the_end(Mock(side_effect=KeyboardInterrupt))
