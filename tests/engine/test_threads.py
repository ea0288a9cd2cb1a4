"""Threads: what one of them asks for holds for it and for what works for it, and for no other."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from threading import Barrier, Thread

import numpy as np
import pytest
from tests.apps.design.conftest import loop
from tests.core.same_bits import bits_of

import bristle as br
from bristle.core.cores import Abreast, abreast
from bristle.core.experiment import Experiment, Run
from bristle.engine import compilation, interpreted, is_interpreted


def in_threads(*works):
    threads = [Thread(target=work) for work in works]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def test_overlapping_blocks_restore_the_mode():
    inside, left = Barrier(2, timeout=30.0), Barrier(2, timeout=30.0)
    seen = []

    def first():
        with interpreted():
            inside.wait()
            seen.append(is_interpreted())
        left.wait()
        seen.append(is_interpreted())

    def second():
        with interpreted():
            inside.wait()
            left.wait()
            seen.append(is_interpreted())
        seen.append(is_interpreted())

    in_threads(first, second)
    assert sorted(seen) == [False, False, True, True]
    assert not is_interpreted()


def test_a_block_does_not_affect_other_threads():
    seen = []
    with interpreted():
        in_threads(lambda: seen.append(is_interpreted()))
        assert is_interpreted()
    assert seen == [False]


def test_nested_blocks_end_in_order_even_with_an_error():
    seen = []

    def fail():
        with interpreted():
            with interpreted():
                pass
            seen.append(is_interpreted())
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert (*seen, is_interpreted()) == (True, False)


def test_worker_threads_inherit_the_block():
    with Abreast(2) as pool:
        with interpreted():
            inside = pool.map(lambda _: is_interpreted(), range(20))
        outside = pool.map(lambda _: is_interpreted(), range(20))
        assert all(inside)
        assert not any(outside)


@pytest.fixture
def no_compiler(monkeypatch):
    """Fail where anything is compiled, or taken as it was."""

    def compiled(name, *_):
        raise AssertionError(f"{name} is compiled")

    monkeypatch.setattr(compilation, "_entries", {})
    monkeypatch.setattr(compilation, "_compile", compiled)


def test_parallel_runs_inherit_the_mode_of_their_caller(no_compiler):
    variant = loop(run=Run(0.02, 1e-3, settle=0.0))
    several = Experiment(
        "small", "translational", (replace(variant, run=replace(variant.run, seeds=3)),)
    )
    with interpreted():
        assert br.simulate(several).variants["fed"].runs == 3


def test_parallel_searches_inherit_the_mode_of_their_caller(no_compiler):
    def cost(x):
        assert is_interpreted()
        return float(np.sum(x * x))

    with interpreted():
        assert abreast(cost)([np.array([1.0, 2.0]), np.ones(3)]) == [5.0, 3.0]


COMPILING = """
import json, sys
from threading import Barrier, Thread
import numpy as np
from numba.core.bytecode import FunctionIdentity
import bristle as br
from bristle.engine import compilation
from bristle.contract import example_of

models = [example_of(br.friction.MODELS[name]) for name in ("coulomb", "viscous", "coulomb", "viscous")]
together, before = Barrier(len(models)), FunctionIdentity._unique_ids

def work(model):
    together.wait()
    br.response(model, np.zeros(3), 1e-3)

def numbers():
    found = {}
    for (name, _), entry in compilation._entries.items():
        (product,) = entry.overloads.values()
        found[name] = product.fndesc.uid
    return found

if sys.argv[1] == "abreast":
    threads = [Thread(target=work, args=(model,)) for model in models]
    for one in threads: one.start()
    for one in threads: one.join()
else:
    for model in models:
        br.response(model, np.zeros(3), 1e-3)
print(json.dumps([len(compilation._compiled), numbers(), FunctionIdentity._unique_ids is before]))
"""


@pytest.mark.slow
def test_concurrent_requests_for_entries_give_the_same_entries():
    environment = os.environ | {"BRISTLE_CACHE_DIR": ""}
    environment.pop("NUMBA_DISABLE_JIT", None)
    result = []
    for way in ("in turn", "abreast"):
        done = subprocess.run(
            [sys.executable, "-c", COMPILING, way],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        result.append(json.loads(done.stdout))
    assert result[0] == result[1]
    count, numbers, as_before = result[0]
    assert (count, len(numbers), as_before) == (2, 2, True)


def test_a_model_in_several_threads_is_identical_to_one_thread():
    several = Experiment(
        "small", "translational", (loop(run=Run(0.05, 1e-3, settle=0.0, seeds=4)),)
    )
    result = []
    in_threads(*[lambda: result.append(bits_of(br.simulate(several)))] * 4)
    assert result == [bits_of(br.simulate(several))] * 4
