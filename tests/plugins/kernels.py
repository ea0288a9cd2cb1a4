"""Kernels are compiled in a child where this process is large already, and their time is counted apart from that of tests.

What a compiler allocates stays with its process: a worker that compiles all kernels of the tests grows to three gigabytes.
A child compiles, writes the product to the cache on disk and ends; this process reads it from there. A kernel that another worker
compiles at this moment is awaited.
"""

import contextlib
import functools
import os
import sys
import tempfile
import zlib
from pathlib import Path

import pytest
from tests.plugins import process

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

# Below this resident memory [MB] a process compiles by itself: the next kernel then finds what they share.
LARGE = 600.0


class Clock:
    """Processor time of compilation and of loading kernels in this process so far [s]."""

    seconds = 0.0


def watch():
    """Count the time of compilation, as soon as the compiler of the package is loaded."""
    compilation = sys.modules.get("bristle.engine.compilation")
    if compilation is None or hasattr(compilation._compile, "__wrapped__"):
        return
    compilation._compile = counted(compilation._compile, compilation.cache_folder)


def counted(compile_entry, cache_folder):
    """Return the function that compiles an entry, with its time counted, and in a child where it is large."""

    @functools.wraps(compile_entry)
    def compiled(*arguments):
        begun = process.seconds()
        try:
            names = [argument for argument in arguments if isinstance(argument, str)]
            with one_worker(" ".join(names)):
                if is_large() and cache_folder() is not None:
                    in_child(compile_entry, arguments)
                return compile_entry(*arguments)
        finally:
            Clock.seconds += process.seconds() - begun

    return compiled


@contextlib.contextmanager
def one_worker(name):
    """Let one process at a time compile what has a name: each name locks one byte of a file that all of them share."""
    if fcntl is None:
        yield
        return
    owner = os.getuid()
    place = zlib.crc32(name.encode())
    with (Path(tempfile.gettempdir()) / f"bristle-kernels-{owner}.lock").open("a+b") as file:
        fcntl.lockf(file, fcntl.LOCK_EX, 1, place)
        yield  # closing the file unlocks


def is_large():
    """Return whether a child has to compile for this process."""
    return hasattr(os, "fork") and process.resident_megabytes() > LARGE


def in_child(compile_entry, arguments):
    """Compile in a child, which leaves the product in the cache; what fails there fails again here, where it is told."""
    child = os.fork()
    if child == 0:
        with contextlib.suppress(BaseException):
            compile_entry(*arguments)
        os._exit(0)
    os.waitpid(child, 0)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item, nextitem):
    """Watch before each test: the first that needs kernels loads their compiler."""
    watch()
    return (yield)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_fixture_setup(fixturedef, request):
    """Watch before each fixture: one of a session may load the compiler."""
    watch()
    return (yield)
