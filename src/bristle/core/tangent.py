r"""Tangents: the derivatives of one number in `DIRECTIONS` directions at once, which compiled code keeps in vector registers.

A derivative in direction k is :math:`\dot y_k = \sum_i \frac{\partial y}{\partial x_i} \dot x_{i,k}`, forward through a
computation (R. E. Wengert, Communications of the ACM 7(8), 1964, doi:10.1145/355586.364791). In plain Python a tangent is
an array of shape (DIRECTIONS,); in an array of tangents, that of number i begins at ``i * DIRECTIONS``.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from bristle.core.kernel import kernel

DIRECTIONS = 8


def _vector_type() -> Any:
    """Return the type of tangents for the compiler, one for the process."""
    from numba.core import types
    from numba.extending import models, register_model

    class TangentType(types.Type):
        """The type of tangents."""

    @register_model(TangentType)
    class TangentModel(models.PrimitiveModel):
        """One vector of so many numbers."""

        def __init__(self, manager: Any, kind: Any) -> None:
            from llvmlite import ir

            super().__init__(manager, kind, ir.VectorType(ir.DoubleType(), DIRECTIONS))

    return TangentType(name="tangent")


_known: list[Any] = []


def tangent_type() -> Any:
    """Return the type of tangents for the compiler."""
    if not _known:
        _known.append(_vector_type())
    return _known[0]


def _compiled_as(takes: str, gives: str, generate: Callable[..., Any]) -> Callable[[], Any]:
    """Return what makes a function known to the compiler, by letters for its types: t(angent), r(eal), w(hole), v(ector), n(one)."""

    def compiled() -> Any:
        from numba.core import types
        from numba.extending import intrinsic

        names = "abcd"[: len(takes)]
        kinds = {"t": tangent_type(), "r": types.float64, "w": types.int64, "v": types.Array(types.float64, 1, "C"), "n": types.void}

        def typing(context: Any, *given: Any) -> Any:
            taken = (kind if letter == "v" else kinds[letter] for letter, kind in zip(takes, given, strict=True))
            return kinds[gives](*taken), generate

        scope: dict[str, Any] = {"typing": typing}
        arguments = ", ".join(names)
        exec(f"def changed(context{', ' * bool(names)}{arguments}): return typing(context{', ' * bool(names)}{arguments})", scope)
        scope["inner"] = intrinsic(scope["changed"])
        exec(f"def implementation({arguments}): return lambda {arguments}: inner({arguments})", scope)
        return scope["implementation"]

    return compiled


def _spread(builder: Any, number: Any) -> Any:
    """Return a vector of one number."""
    from llvmlite import ir

    kind, whole = ir.VectorType(number.type, DIRECTIONS), ir.IntType(32)
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), number, ir.Constant(whole, 0))
    return builder.shuffle_vector(first, ir.Constant(kind, ir.Undefined), ir.Constant(ir.VectorType(whole, DIRECTIONS), [0] * DIRECTIONS))


def _place(context: Any, builder: Any, kind: Any, array: Any, at: Any) -> Any:
    """Return the address of a tangent in an array of them."""
    from llvmlite import ir

    lent = context.make_array(kind)(context, builder, array)
    first = builder.mul(at, at.type(DIRECTIONS))
    number = builder.gep(lent.data, [first])
    return builder.bitcast(number, ir.VectorType(ir.DoubleType(), DIRECTIONS).as_pointer())


def _zero(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    from llvmlite import ir

    return ir.Constant(ir.VectorType(ir.DoubleType(), DIRECTIONS), [0.0] * DIRECTIONS)


def _sum(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return builder.fadd(*arguments)


def _difference(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return builder.fsub(*arguments)


def _product(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return builder.fmul(_spread(builder, arguments[0]), arguments[1])


def _combination(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    a, x, b, y = arguments
    return builder.fadd(builder.fmul(_spread(builder, a), x), builder.fmul(_spread(builder, b), y))


def _load(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return builder.load(_place(context, builder, signature.args[0], arguments[0], arguments[1]), align=8)


def _store(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    builder.store(arguments[2], _place(context, builder, signature.args[0], arguments[0], arguments[1]), align=8)
    return context.get_dummy_value()


@kernel(compiled_as=_compiled_as("", "t", _zero))
def still():
    """Return the tangent of what does not change."""
    return np.zeros(DIRECTIONS)


@kernel(compiled_as=_compiled_as("tt", "t", _sum))
def tangent_sum(a, b):
    """Return the sum of two tangents."""
    return a + b


@kernel(compiled_as=_compiled_as("tt", "t", _difference))
def tangent_difference(a, b):
    """Return the difference of two tangents."""
    return a - b


@kernel(compiled_as=_compiled_as("rt", "t", _product))
def tangent_scaled(a, b):
    """Return a tangent times a number `a`."""
    return a * b


@kernel(compiled_as=_compiled_as("rtrt", "t", _combination))
def tangent_combined(a, b, c, d):
    """Return `a` times one tangent and `c` times another."""
    return a * b + c * d


@kernel(compiled_as=_compiled_as("vw", "t", _load))
def tangent_at(a, b):
    """Return the tangent of number `b` of an array of tangents."""
    return a[b * DIRECTIONS : (b + 1) * DIRECTIONS].copy()


@kernel(compiled_as=_compiled_as("vwt", "n", _store))
def keep_tangent(a, b, c):
    """Keep a tangent as that of number `b` in an array of them."""
    a[b * DIRECTIONS : (b + 1) * DIRECTIONS] = c
