"""Cores are for simulations while models are identified, and for linear algebra again after that."""

import threading
from functools import partial

import pytest
import scipy.linalg  # noqa: F401  (brings its own library of linear algebra)
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort
from threadpoolctl import threadpool_info, threadpool_limits

from bristle.core import cores
from bristle.core.cores import Abreast, abreast, cores_for_simulations
from bristle.identification import identify


def threads():
    return [item["num_threads"] for item in threadpool_info() if item["user_api"] == "blas"]


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


def test_linear_algebra_has_a_single_thread_inside_and_recovers_after_an_error():
    seen = []
    with pytest.raises(ZeroDivisionError):
        failing(seen)
    assert set(seen) == {1}
    assert max(threads()) == 2


class EnoughError(Exception):
    """Enough is seen of an identification."""


def test_identification_keeps_to_it():
    def look(*_):
        assert set(threads()) == {1}
        raise EnoughError

    motion = sines(duration=2.0)
    with pytest.raises(EnoughError):
        identify(
            log_of(motion, sliding_effort(motion)),
            "coulomb_viscous",
            axis=STATED,
            blocks=0,
            draws=0,
            progress=look,
        )
    assert max(threads()) == 2


def test_an_interruption_does_not_wait_for_threads():
    released, began = threading.Event(), threading.Event()

    def work():
        began.set()
        return released.wait(5.0)

    pool = Abreast(1)
    running, waiting = pool.submit(work), pool.submit(work)
    began.wait(5.0)
    pool.__exit__(KeyboardInterrupt, KeyboardInterrupt(), None)
    assert (running.done(), waiting.cancelled()) == (False, True)
    released.set()
    assert running.result(5.0)


class Other:
    """Another thread, which enters and leaves a block when it is told to, and lives until the end of the test."""

    def __init__(self):
        self.pool = Abreast(1)
        self.block = cores_for_simulations()

    def enter(self):
        self.pool.submit(self.block.__enter__).result()

    def leave(self):
        self.pool.submit(self.block.__exit__, None, None, None).result()


@pytest.fixture
def other():
    result = Other()
    yield result
    result.pool.shutdown()


def test_a_block_holds_whoever_set_the_threads_before(other):
    other.enter()
    assert max(threads()) == 1
    other.leave()
    assert max(threads()) == 2
    with threadpool_limits(1, user_api="blas"):
        assert max(threads()) == 1
    assert max(threads()) == 2


@pytest.mark.parametrize("is_last", [True, False])
def test_overlapping_blocks_do_not_end_each_other(other, is_last):
    mine = cores_for_simulations()
    mine.__enter__()
    other.enter()
    first, last = (
        (partial(mine.__exit__, *[None] * 3), other.leave)
        if is_last
        else (other.leave, partial(mine.__exit__, *[None] * 3))
    )
    first()
    assert max(threads()) == 1
    last()
    assert max(threads()) == 2


def test_a_fork_inside_a_block_starts_without_active_blocks():
    parent = cores_for_simulations()
    parent.__enter__()
    cores._leave_blocks()  # as after a fork
    parent.__exit__(None, None, None)
    with cores_for_simulations():
        with cores_for_simulations():
            pass
        assert max(threads()) == 1
    assert max(threads()) == 2


def test_a_single_value_needs_no_thread_and_results_keep_their_order():
    here = threading.get_ident()
    assert abreast(lambda value: (value, threading.get_ident()))([3]) == [(3, here)]
    several = abreast(lambda value: (2 * value, threading.get_ident()))([1, 2, 3])
    assert [value for value, _ in several] == [2, 4, 6]
    assert here not in {thread for _, thread in several}
    assert abreast(str)([]) == []
