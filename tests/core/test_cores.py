"""Cores are for simulations while models are identified, and for linear algebra again after that."""

import pytest
import scipy.linalg  # noqa: F401  (brings its own library of linear algebra)
from tests.identification.known_logs import sliding_log
from threadpoolctl import threadpool_info, threadpool_limits

from bristle.core.cores import core_count, cores_for_simulations
from bristle.identification import identify


def threads():
    return [one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"]


@pytest.fixture(autouse=True)
def two_threads():
    with threadpool_limits(2, user_api="blas"):
        if not threads() or max(threads()) < 2:
            pytest.skip("this linear algebra has one thread")
        yield


@cores_for_simulations()
def failing(seen):
    seen += threads()
    raise ZeroDivisionError


def test_linear_algebra_has_one_thread_inside_and_its_own_after_an_error():
    seen = []
    with pytest.raises(ZeroDivisionError):
        failing(seen)
    assert set(seen) == {1}
    assert max(threads()) == 2


def test_identification_keeps_to_it():
    seen = set()
    identify(sliding_log(), blocks=0, draws=0, progress=lambda *_: seen.update(threads()))
    assert seen == {1}
    assert max(threads()) == 2


def test_there_is_a_core():
    assert core_count() >= 1
