"""Friction in JAX, differentiable along walks, as foreign functions of XLA on the CPU."""

import ctypes
import math
import shutil
from collections.abc import Sequence
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from bristle.bridges.compiled import CompiledFriction
from bristle.core import InputError, MissingExtraError
from bristle.exports import shared_library

try:
    import jax
    from jax import numpy as jnp
    from jax.extend.core import Primitive
    from jax.interpreters import ad, batching, mlir
except ImportError as error:
    raise MissingExtraError.of("friction in JAX", "jax") from error

TARGET = "bristle_walk"


class Friction(CompiledFriction):
    """A friction model in JAX, under ``jit``, ``vmap``, ``scan``, ``jvp`` and ``grad``, for arrays of double precision on the CPU.

    Examples
    --------
    >>> from bristle import friction
    >>> jax.config.update("jax_enable_x64", True)
    >>> dahl = Friction(friction.dahl(F_C="20 N", sigma_0="10 N/um"))
    >>> def last(F_C):
    ...     return dahl.walk(dahl.start(), jnp.linspace(0.0, 1e-4, 50), 1e-3, {"F_C": F_C})[1][-1]
    >>> round(float(jax.grad(last)(20.0)), 6)
    1.0
    """

    library = jnp

    def _array(self, value: Any, name: str) -> Any:
        array = jnp.asarray(value)
        if jnp.issubdtype(array.dtype, jnp.integer):
            array = array.astype(float)
        if array.dtype != np.float64:
            raise InputError(
                "must be of double precision",
                path=name,
                value=str(array.dtype),
                allowed="float64",
                mend='Write jax.config.update("jax_enable_x64", True) at the beginning',
            )
        return array

    def _run(self, operands: Sequence[Any]) -> tuple[Any, Any]:
        _registered()
        return tuple(WALK.bind(*operands, library=str(self._walk.library)))  # type: ignore[return-value]


@cache
def _registered() -> None:
    """Compile and register the function that XLA calls, for all models."""
    text = resources.files("bristle.bridges").joinpath("walk.cc").read_text(encoding="ascii")
    command = next((name for name in ("c++", "g++", "clang++") if shutil.which(name)), None)
    path = shared_library({"walk.cc": text}, command, ["-std=c++17", "-O1", f"-DJAX={jax.__version__}", f"-I{jax.ffi.include_dir()}"])
    jax.ffi.register_ffi_target(TARGET, jax.ffi.pycapsule(ctypes.CDLL(str(path)).bristle_walk), platform="cpu")


def _primitive(function: str, outputs: Any) -> Primitive:
    """Return a primitive that calls a function of the library; `outputs` chooses the operands with the shapes of the results."""
    primitive = Primitive(f"bristle_{function}")
    primitive.multiple_results = True

    def called(*operands: Any, library: str) -> Any:
        *lanes, steps = operands[1].shape
        shapes = [jax.ShapeDtypeStruct(operand.shape, operand.dtype) for operand in outputs(operands)]
        call = jax.ffi.ffi_call(TARGET, shapes)
        return call(*operands, library=library, symbol=function, lanes=np.int64(math.prod(lanes)), steps=np.int64(steps))

    def batched(operands: Sequence[Any], axes: Sequence[Any], *, library: str) -> Any:
        size = next(operand.shape[axis] for operand, axis in zip(operands, axes, strict=True) if axis is not None)
        pairs = zip(operands, axes, strict=True)
        moved = primitive.bind(*(batching.bdim_at_front(operand, axis, size) for operand, axis in pairs), library=library)
        return moved, [0] * len(moved)

    primitive.def_impl(called)
    primitive.def_abstract_eval(lambda *operands, library: [operand.update() for operand in outputs(operands)])
    mlir.register_lowering(primitive, mlir.lower_fun(called, multiple_results=True), platform="cpu")
    batching.primitive_batchers[primitive] = batched
    return primitive


WALK = _primitive("walk", lambda operands: operands[:2])
FORWARD = _primitive("walk_forward", lambda operands: operands[:2])
REVERSE = _primitive("walk_reverse", lambda operands: operands[:-2])


def _forward(primals: Sequence[Any], tangents: Sequence[Any], *, library: str) -> Any:
    """Return the results of a walk and their tangents."""
    moved = FORWARD.bind(*primals, *map(ad.instantiate_zeros, tangents), library=library)
    return WALK.bind(*primals, library=library), moved


def _reverse(adjoints: Sequence[Any], *operands: Any, library: str) -> Any:
    """Return the adjoints of the tangents of a walk, from those of its results."""
    primals, tangents = operands[: len(operands) // 2], operands[len(operands) // 2 :]
    found = REVERSE.bind(*primals, *map(ad.instantiate_zeros, adjoints), library=library)
    pairs = zip(tangents, found, strict=True)
    return [None] * len(primals) + [adjoint if ad.is_undefined_primal(tangent) else None for tangent, adjoint in pairs]


ad.primitive_jvps[WALK] = _forward
ad.primitive_transposes[FORWARD] = _reverse
