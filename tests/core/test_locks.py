"""Processes that are forked while other threads are at work: nothing in them waits for what is not there."""

import itertools
import json
import os
import subprocess
import sys

import pytest

from bristle.core import locks
from bristle.core.lazy import cached_property

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")

# Each holds something in a thread, forks meanwhile, and tells whether the child came to an end.
HELD = """
import json, os, signal, sys, threading, time
from bristle.core import cores, locks
from bristle.core.lazy import cached_property

class Slow:
    @cached_property
    def value(self):
        if threading.current_thread() is not threading.main_thread():
            inside.set()
            time.sleep(0.5)
        return 1.0

def hold(lock):
    with lock:
        inside.set()
        time.sleep(0.3)
        halves.append("done")

def ended(child):
    pid = os.fork()
    if pid == 0:
        signal.alarm(10)
        os._exit(0 if child() else 1)
    return os.waitpid(pid, 0)[1] == 0

found = {}
for name in filter(str.isupper, set(vars(locks)) - {"_ORDER"}):
    inside, halves, lock = threading.Event(), [], getattr(locks, name)
    thread = threading.Thread(target=hold, args=(lock,))
    thread.start()
    inside.wait()
    # A thread of the child: the one that forks could be let through what it holds itself.
    taken = lambda: lock.acquire(timeout=1.0)
    def child():
        got = []
        other = threading.Thread(target=lambda: got.append(taken()))
        other.start()
        other.join()
        return got == [True] and halves == ["done"]
    found[name] = ended(child)
    thread.join()
    found[f"{name} here"] = lock.acquire(timeout=1.0)
    lock.release()

inside = threading.Event()
thread = threading.Thread(target=lambda: Slow().value)
thread.start()
inside.wait()
found["property"] = ended(lambda: Slow().value == 1.0)
thread.join()

import numpy, threadpoolctl
def threads():
    return [one["num_threads"] for one in threadpoolctl.threadpool_info() if one["user_api"] == "blas"]

def block(until):
    with cores.cores_for_simulations():
        inside.set()
        until.wait()

with threadpoolctl.threadpool_limits(2, user_api="blas"):
    inside, until = threading.Event(), threading.Event()
    thread = threading.Thread(target=block, args=(until,))
    thread.start()
    inside.wait()
    def child():
        with cores.cores_for_simulations():
            pass
        return max(threads(), default=2) == 2
    found["cores"] = ended(child)
    until.set()
    thread.join()
print(json.dumps(found))
"""


@pytest.mark.slow
def test_all_locks_are_free_in_a_fork():
    done = subprocess.run(
        [sys.executable, "-c", HELD], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert len(data) == 2 * len(locks._ORDER) + 2
    assert [name for name, fine in data.items() if not fine] == []


class Counted:
    """Something whose value is counted."""

    calls = itertools.count(1)

    @cached_property
    def value(self):
        """How often it was asked for."""
        return next(self.calls)


def test_a_property_is_computed_once_and_kept():
    item = Counted()
    assert (item.value, item.value, vars(item)["value"], next(item.calls)) == (1, 1, 1, 2)
    assert Counted.value.__doc__ == "How often it was asked for."
