"""What a fast test may cost: two seconds of processor time, and a fixture that tests share ten; compilation is not counted.

`slow` marks a test that takes more than half a second. The limits are higher, so that a busy machine fails nothing.
"""

import os
import time
from pathlib import Path

import numpy as np
import pytest
from tests.plugins import kernels, process

TEST, SHARED = 2.0, 10.0  # processor time [s] on a machine that does `work` in REFERENCE [s]
REFERENCE = 0.03
MEMORY = 1750.0  # of one worker [MB]: measured are 1.3 to 1.5 GB, and code for another processor may be larger


class Spent:
    """Processor time of fixtures that the running test shares with others [s]."""

    shared = 0.0


def work():
    """Return the processor time that a fixed piece of Python and of linear algebra takes now [s]."""
    begun = time.process_time()
    total = 0
    for number in range(400_000):
        total += number * number % 7
    matrix = np.arange(40_000.0).reshape(200, 200)
    for _ in range(10):
        matrix = matrix @ matrix.T / 1e6 % 1.0
    return time.process_time() - begun


def slowness():
    """Return how many times slower than the machine of REFERENCE this one is now, at least 1.

    More than two processes a core share its caches, and each takes more processor time for the same work.
    """
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    return max(1.0, min(work() for _ in range(3)) / REFERENCE) * max(
        1.0, 0.5 * load / (os.cpu_count() or 1)
    )


def is_slow(item):
    """Return whether a test is exempt."""
    return item.get_closest_marker("slow") is not None


class Meter:
    """Processor time since its making, without compilation and without what other meters have counted as shared."""

    def __init__(self):
        self.begun = time.time()
        self.marks = self._read()

    @staticmethod
    def _read():
        return (
            process.seconds(children=False),
            process.seconds(),
            kernels.Clock.seconds,
            Spent.shared,
        )

    def seconds(self):
        """Return the processor time with that of children [s]."""
        now = self._read()
        return now[1] - self.marks[1] - self._elsewhere(now)

    def own_seconds(self):
        """Return the processor time without children where one of them has compiled a kernel [s]."""
        if not compiled_since(self.begun):
            return self.seconds()
        now = self._read()
        return now[0] - self.marks[0] - self._elsewhere(now)

    def _elsewhere(self, now):
        return now[2] - self.marks[2] + now[3] - self.marks[3]


def compiled_since(begun):
    """Return whether a process has written a kernel to the cache since a time."""
    from bristle.engine.compilation import cache_folder

    folder = cache_folder()
    if folder is None:
        return True
    return any(modified(file) >= begun for file in folder.glob("*.bin"))


def modified(file: Path):
    """Return when a file was written, 0 if it is gone."""
    try:
        return file.stat().st_mtime
    except OSError:
        return 0.0


def judge(meter, limit, what):
    """Fail what took more than its limit."""
    if meter.seconds() <= limit:
        return
    taken, allowed = meter.own_seconds(), limit * slowness()
    if taken > allowed:
        pytest.fail(
            f"{what} takes {taken:.1f} s of processor time, allowed are {allowed:.1f} s: make it cheaper, or mark it slow",
            pytrace=False,
        )


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_setup(item):
    """Begin to measure a test with its own fixtures."""
    item.meter = Meter()
    return (yield)


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_call(item):
    """Fail a fast test that takes too long."""
    result = yield
    item.user_properties.append(("processor seconds", round(item.meter.seconds(), 3)))
    if not is_slow(item):
        judge(item.meter, TEST, "this fast test")
    return result


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef, request):
    """Fail a fixture of fast tests that takes too long; what tests share counts for none of them."""
    if fixturedef.scope == "function":
        return (yield)
    meter = Meter()
    result = yield
    if not is_slow(request._pyfuncitem):
        judge(meter, SHARED, f"the fixture {fixturedef.argname}, which tests share,")
    Spent.shared += meter.seconds()
    return result


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session):
    """Tell the process that collects the results what this one has used."""
    output = getattr(session.config, "workeroutput", None)
    used = {
        "peak": process.peak_megabytes(),
        "compiling": kernels.Clock.seconds,
        "seconds": process.seconds(),
    }
    if output is not None:
        output["used"] = used
    elif not hasattr(session.config, "used"):
        session.config.used = [used]


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node, error):
    """Collect what a worker has used."""
    used = getattr(node, "workeroutput", {}).get("used")
    if used:
        node.config.used = [*getattr(node.config, "used", []), used]


def pytest_terminal_summary(terminalreporter, config):
    """Say what the workers have used."""
    for used in getattr(config, "used", []):
        memory, taken, compiling = used["peak"], used["seconds"], used["compiling"]
        terminalreporter.write_line(
            f"a process of tests: at most {memory:.0f} MB, {taken:.0f} s of processor time ({compiling:.0f} s for kernels)"
        )


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_cmdline_main(config):
    """Fail a run of CI whose workers took too much memory."""
    status = yield
    largest = max((used["peak"] for used in getattr(config, "used", [])), default=0.0)
    if status == 0 and config.getoption("ci") and largest > MEMORY:
        print(f"A process of tests took {largest:.0f} MB; allowed are {MEMORY:.0f} MB.")
        return 1
    return status
