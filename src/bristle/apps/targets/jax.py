r"""Friction along walks in JAX, with a compiled model, as functions that XLA calls on the CPU.

.. math:: (s_k, F_k) = g(s_{k-1}, x_k, \Delta t, p), \qquad
   \bar s_{k-1} = \left(\frac{\partial s_k}{\partial s_{k-1}}\right)^T \bar s_k
   + \left(\frac{\partial F_k}{\partial s_{k-1}}\right)^T \bar F_k

with the state :math:`s` including the memory. In reverse mode, a walk is recomputed in segments from stored states.
"""

import ctypes
import math
import shutil
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib import import_module, resources
from typing import Any

import numpy as np

from bristle.core import InputError, MissingExtraError, Model, did_you_mean
from bristle.exports import CompiledWalk

TARGET = "bristle_walk"


class Friction:
    """A friction model in JAX; `walk` and `force` are differentiable in all their numbers.

    They work under ``jit``, ``vmap``, ``lax.scan``, ``jvp`` and ``grad``, with derivatives of first order. For a gradient
    over many steps use `walk`: a ``scan`` over `force` stores the state of each step.

    Leading axes of all arguments are lanes, which broadcast. The derivatives are those of `bristle.engine.derivatives`:
    exact, of the executed branches. All numbers are in SI units and of double precision, on the CPU. A refused input,
    such as ``dt=0`` or a parameter outside its range, repeats the last force and its derivatives.

    Parameters
    ----------
    model : Model
        A friction model with parameters. The C compiler of this machine compiles it at first use.

    Attributes
    ----------
    model : Model
        The friction model.
    parameters : dict of str to float or ndarray
        Values of its parameters, which can be arguments of `walk` and `force`.

    Raises
    ------
    InputError
        If bristle does not export derivatives of the model, or finds no C compiler.
    MissingExtraError
        If JAX is not installed.
    """

    def __init__(self, model: Model) -> None:
        try:
            self._numpy = import_module("jax.numpy")
        except ImportError as error:
            raise MissingExtraError.of("friction in jax", "jax") from error
        self.model = model
        self._walk = CompiledWalk(model)
        self.parameters = {name: model.values[name] for name in self._walk.parameters}

    def start(self) -> Any:
        """Return the state of a virgin contact before the first sample, shape (number,).

        The first sample sets the position, and its force is 0.
        """
        return self._array(self._walk.start, "start")

    def walk(
        self, state: Any, x: Any, dt: Any, parameters: Any = None, **signals: Any
    ) -> tuple[Any, Any]:
        """Return the state after a walk, and the friction force of each step.

        Parameters
        ----------
        state : array, shape (..., number)
            State before the walk, from `start` or an earlier call.
        x : array, shape (..., step)
            Position at the end of each step [m or rad].
        dt : array, shape (...)
            Time step [s].
        parameters : mapping or array, shape (..., parameter), optional
            Some parameters by name, or all their numbers in the order of `parameters`; those of the model by default.
        **signals : array, shape (..., step)
            Inputs of friction besides the motion, such as ``load`` and ``temperature``; nominal values by default.

        Returns
        -------
        state : array, shape (..., number)
            State after the walk.
        force : array, shape (..., step)
            Mean friction force of each step [N or N*m].

        Raises
        ------
        InputError
            If an argument is not of double precision, or has the wrong shape or an unknown name.
        """
        walk = self._walk
        for kind, names, allowed in (
            ("signals", signals, walk.signals),
            ("parameters", parameters, walk.parameters),
        ):
            if not isinstance(names, Mapping):
                continue
            for name in set(names) - set(allowed):
                raise InputError(
                    "no such name",
                    path=kind,
                    value=name,
                    mend=did_you_mean(name, allowed),
                    allowed=", ".join(allowed) or f"no {kind}",
                )
        around = [
            self._array(signals.get(name, usual), name) for name, usual in walk.signals.items()
        ]
        x = self._array(x, "x")
        operands = [
            self._array(state, "state"),
            x,
            self._array(dt, "dt")[..., None],
            self._flat(parameters),
        ]
        operands += [signal if signal.shape else signal[None] for signal in around]
        widths = [
            walk.start.size,
            x.shape[-1],
            1,
            sum(map(np.size, walk.parameters.values())),
            *[x.shape[-1]] * len(around),
        ]
        names = ["state", "x", "dt", "parameters", *walk.signals]
        for name, operand, width in zip(names, operands, widths, strict=True):
            if operand.shape[-1] != width and not (name in walk.signals and operand.shape[-1] == 1):
                raise InputError(
                    "has a wrong shape",
                    path=name,
                    value=tuple(operand.shape),
                    allowed=f"(..., {width})",
                )
        lanes = np.broadcast_shapes(*(operand.shape[:-1] for operand in operands))
        pairs = zip(operands, widths, strict=True)
        return self._run(
            [self._numpy.broadcast_to(operand, (*lanes, width)) for operand, width in pairs]
        )

    def force(
        self, state: Any, x: Any, dt: Any, parameters: Any = None, **signals: Any
    ) -> tuple[Any, Any]:
        """Return the state after one step, and its force: `walk` with a position and signals of shape (...)."""
        signals = {name: self._array(signal, name)[..., None] for name, signal in signals.items()}
        state, force = self.walk(state, self._array(x, "x")[..., None], dt, parameters, **signals)
        return state, force[..., 0]

    def _flat(self, parameters: Any) -> Any:
        """Return the numbers of all parameters."""
        if parameters is not None and not isinstance(parameters, Mapping):
            return self._array(parameters, "parameters")
        parts = []
        for name, usual in self.parameters.items():
            part = self._array((parameters or {}).get(name, usual), name)
            if not isinstance(usual, np.ndarray):
                part = part[..., None]
            parts.append(part)
        lanes = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
        return self._numpy.concatenate(
            [self._numpy.broadcast_to(part, (*lanes, part.shape[-1])) for part in parts], -1
        )

    def _array(self, value: Any, name: str) -> Any:
        array = self._numpy.asarray(value)
        if array.dtype.kind in "iu":
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
        state, force = _walk_primitive().bind(*operands, library=str(self._walk.library))
        return state, force


@cache
def _walk_primitive() -> Any:
    """Return the primitive of a walk with its derivatives; the function that XLA calls is compiled once, for all models."""
    jax = import_module("jax")
    ad = import_module("jax.interpreters.ad")
    text = resources.files("bristle.apps.targets").joinpath("walk.cc").read_text(encoding="ascii")
    command = next((name for name in ("c++", "g++", "clang++") if shutil.which(name)), None)
    path = CompiledWalk.build(
        {"walk.cc": text},
        command,
        ["-std=c++17", "-O1", f"-DJAX={jax.__version__}", f"-I{jax.ffi.include_dir()}"],
    )
    jax.ffi.register_ffi_target(
        TARGET, jax.ffi.pycapsule(ctypes.CDLL(str(path)).bristle_walk), platform="cpu"
    )
    walk = _primitive("walk", lambda operands: operands[:2])
    forward = _primitive("walk_forward", lambda operands: operands[:2])
    reverse = _primitive("walk_reverse", lambda operands: operands[:-2])

    def with_tangents(primals: Sequence[Any], tangents: Sequence[Any], *, library: str) -> Any:
        """Return the results of a walk and their tangents."""
        moved = forward.bind(*primals, *map(ad.instantiate_zeros, tangents), library=library)
        return walk.bind(*primals, library=library), moved

    def transposed(adjoints: Sequence[Any], *operands: Any, library: str) -> Any:
        """Return the adjoints of the tangents of a walk, from those of its results."""
        primals = operands[: len(operands) // 2]
        tangents = operands[len(operands) // 2 :]
        moved = reverse.bind(*primals, *map(ad.instantiate_zeros, adjoints), library=library)
        pairs = zip(tangents, moved, strict=True)
        return [None] * len(primals) + [
            adjoint if ad.is_undefined_primal(tangent) else None for tangent, adjoint in pairs
        ]

    ad.primitive_jvps[walk] = with_tangents
    ad.primitive_transposes[forward] = transposed
    return walk


def _primitive(function: str, like: Callable[[Sequence[Any]], Sequence[Any]]) -> Any:
    """Return a primitive that calls a function of the library; `like` chooses the operands with the shapes of the results."""
    jax, batching, mlir = map(
        import_module, ("jax", "jax.interpreters.batching", "jax.interpreters.mlir")
    )
    primitive = import_module("jax.extend.core").Primitive(f"bristle_{function}")
    primitive.multiple_results = True

    def call(*operands: Any, library: str) -> Any:
        *lanes, steps = operands[1].shape
        shapes = [jax.ShapeDtypeStruct(operand.shape, operand.dtype) for operand in like(operands)]
        attributes = {
            "library": library,
            "symbol": function,
            "lanes": np.int64(math.prod(lanes)),
            "steps": np.int64(steps),
        }
        return jax.ffi.ffi_call(TARGET, shapes)(*operands, **attributes)

    def batched(operands: Sequence[Any], axes: Sequence[Any], *, library: str) -> Any:
        size = next(
            operand.shape[axis]
            for operand, axis in zip(operands, axes, strict=True)
            if axis is not None
        )
        moved = [
            batching.bdim_at_front(operand, axis, size)
            for operand, axis in zip(operands, axes, strict=True)
        ]
        results = primitive.bind(*moved, library=library)
        return results, [0] * len(results)

    primitive.def_impl(call)
    primitive.def_abstract_eval(
        lambda *operands, library: [
            jax.core.ShapedArray(operand.shape, operand.dtype) for operand in like(operands)
        ]
    )
    mlir.register_lowering(primitive, mlir.lower_fun(call, multiple_results=True), platform="cpu")
    batching.primitive_batchers[primitive] = batched
    return primitive
