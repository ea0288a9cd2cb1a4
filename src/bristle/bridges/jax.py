"""Friction in JAX, differentiable along walks, as functions that XLA calls on the CPU."""

import ctypes
import math
import shutil
from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module, resources
from typing import Any

import numpy as np

from bristle.bridges.compiled import CompiledFriction
from bristle.core import InputError
from bristle.exports import CompiledWalk

TARGET = "bristle_walk"


class Friction(CompiledFriction):
    """A friction model in JAX, for arrays of double precision on the CPU.

    `walk` and `force` work under ``jit``, ``vmap``, ``lax.scan``, ``jvp`` and ``grad``. They have derivatives of first
    order. For a gradient over many steps use `walk`: a ``scan`` over `force` stores the state of each step.
    """

    framework = "jax.numpy"

    def _array(self, value: Any, name: str) -> Any:
        array = self._numpy.asarray(value)
        array = array.astype(float) if array.dtype.kind in "iu" else array
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
        state, force = _walk_primitive().bind(*operands, library=str(self._walk.library))
        return state, force


@cache
def _walk_primitive() -> Any:
    """Return the primitive of a walk with its derivatives; the function that XLA calls is compiled once, for all models."""
    jax, ad = import_module("jax"), import_module("jax.interpreters.ad")
    text = resources.files("bristle.bridges").joinpath("walk.cc").read_text(encoding="ascii")
    command = next((name for name in ("c++", "g++", "clang++") if shutil.which(name)), None)
    path = CompiledWalk.build({"walk.cc": text}, command, ["-std=c++17", "-O1", f"-DJAX={jax.__version__}", f"-I{jax.ffi.include_dir()}"])
    jax.ffi.register_ffi_target(TARGET, jax.ffi.pycapsule(ctypes.CDLL(str(path)).bristle_walk), platform="cpu")
    walk = _primitive("walk", lambda operands: operands[:2])
    forward = _primitive("walk_forward", lambda operands: operands[:2])
    reverse = _primitive("walk_reverse", lambda operands: operands[:-2])

    def with_tangents(primals: Sequence[Any], tangents: Sequence[Any], *, library: str) -> Any:
        """Return the results of a walk and their tangents."""
        moved = forward.bind(*primals, *map(ad.instantiate_zeros, tangents), library=library)
        return walk.bind(*primals, library=library), moved

    def transposed(adjoints: Sequence[Any], *operands: Any, library: str) -> Any:
        """Return the adjoints of the tangents of a walk, from those of its results."""
        primals, tangents = operands[: len(operands) // 2], operands[len(operands) // 2 :]
        moved = reverse.bind(*primals, *map(ad.instantiate_zeros, adjoints), library=library)
        pairs = zip(tangents, moved, strict=True)
        return [None] * len(primals) + [adjoint if ad.is_undefined_primal(tangent) else None for tangent, adjoint in pairs]

    ad.primitive_jvps[walk] = with_tangents
    ad.primitive_transposes[forward] = transposed
    return walk


def _primitive(function: str, like: Callable[[Sequence[Any]], Sequence[Any]]) -> Any:
    """Return a primitive that calls a function of the library; `like` chooses the operands with the shapes of the results."""
    jax, batching, mlir = map(import_module, ("jax", "jax.interpreters.batching", "jax.interpreters.mlir"))
    primitive = import_module("jax.extend.core").Primitive(f"bristle_{function}")
    primitive.multiple_results = True

    def call(*operands: Any, library: str) -> Any:
        *lanes, steps = operands[1].shape
        shapes = [jax.ShapeDtypeStruct(operand.shape, operand.dtype) for operand in like(operands)]
        attributes = {"library": library, "symbol": function, "lanes": np.int64(math.prod(lanes)), "steps": np.int64(steps)}
        return jax.ffi.ffi_call(TARGET, shapes)(*operands, **attributes)

    def batched(operands: Sequence[Any], axes: Sequence[Any], *, library: str) -> Any:
        size = next(operand.shape[axis] for operand, axis in zip(operands, axes, strict=True) if axis is not None)
        moved = [batching.bdim_at_front(operand, axis, size) for operand, axis in zip(operands, axes, strict=True)]
        results = primitive.bind(*moved, library=library)
        return results, [0] * len(results)

    primitive.def_impl(call)
    primitive.def_abstract_eval(
        lambda *operands, library: [jax.core.ShapedArray(operand.shape, operand.dtype) for operand in like(operands)]
    )
    mlir.register_lowering(primitive, mlir.lower_fun(call, multiple_results=True), platform="cpu")
    batching.primitive_batchers[primitive] = batched
    return primitive
