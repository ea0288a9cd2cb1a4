"""Kernels are linked into an entry and not made ready by themselves; whatever else the compiler makes works as ever."""

import math

import numba
import pytest
from numba.core.registry import cpu_target

from bristle.core import kernel
from bristle.engine.signature import linked_into


@numba.njit
def cube(x):
    """What somebody calls from Python too."""
    return x * x * x


@kernel
def cube_and_root(x):
    return cube(x) + math.sqrt(x)


def entry(x):
    return cube_and_root(x) + 1.0


@pytest.fixture
def symbols():
    """The compiler's symbols with addresses."""
    return cpu_target.target_context.codegen()._engine._defined_symbols


def linked(function, signature):
    from bristle.core.kernel import activate

    activate()
    made = numba.njit(function)
    with linked_into(function):
        made.compile(signature)
    return made


def test_a_kernel_has_no_separate_machine_code_and_the_entry_has_its_number(symbols):
    before = set(symbols)
    made = linked(entry, "float64(float64)")
    assert made(4.0) == 4.0**3 + 2.0 + 1.0
    new = symbols - before
    assert [name for name in new if "entry" in name]
    assert not [name for name in new if "cube_and_root" in name and "NumbaEnv" not in name]


def test_a_function_compiled_by_a_user_stays_callable_after_linking():
    linked(entry, "float64(float64)")
    assert cube(3.0) == 27.0
    calls_a_kernel = numba.njit(lambda x: cube_and_root(x) - 1.0)
    assert calls_a_kernel(4.0) == 65.0


def test_the_compiler_is_restored_after_a_fault():
    codegen = cpu_target.target_context.codegen()
    before = codegen._library_class
    with pytest.raises(RuntimeError), linked_into(entry), linked_into(cube_and_root):
        raise RuntimeError
    assert codegen._library_class is before
    assert "get_executable" not in vars(cpu_target.target_context)
