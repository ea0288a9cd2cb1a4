r"""Tangents: the derivatives of one number in `DIRECTIONS` directions at once, which compiled code keeps in vector registers.

A derivative in direction k is :math:`\dot y_k = \sum_i \frac{\partial y}{\partial x_i} \dot x_{i,k}`, forward through a
computation (R. E. Wengert, Communications of the ACM 7(8), 1964, doi:10.1145/355586.364791). In plain Python a tangent is
an array of shape (DIRECTIONS,); in an array of tangents, that of number i begins at ``i * DIRECTIONS``.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar, cast

import numpy as np

from bristle.core.kernel import kernel_options, on_activation

DIRECTIONS = 8

F = TypeVar("F", bound=Callable[..., Any])


@cache
def tangent_type() -> Any:
    """Return the type of tangents for the compiler."""
    from llvmlite import ir
    from numba.core import types
    from numba.extending import models, register_model

    class TangentType(types.Type):
        """The type of tangents."""

    @register_model(TangentType)
    class TangentModel(models.PrimitiveModel):
        """One vector of so many numbers."""

        def __init__(self, manager: Any, kind: Any) -> None:
            super().__init__(manager, kind, ir.VectorType(ir.DoubleType(), DIRECTIONS))

    return TangentType(name="tangent")


def _compiled(arguments: str, result: str, generate: Callable[..., Any]) -> Callable[[F], F]:
    """Mark a function of tangents (t), reals (r), indices (i) and arrays (a), and how the compiler generates it."""

    def mark(plain: F) -> F:
        on_activation(lambda: _make_known(plain, arguments, result, generate))
        return plain

    return mark


def _make_known(plain: Callable[..., Any], arguments: str, result: str, generate: Callable[..., Any]) -> None:
    from numba.core import types
    from numba.extending import intrinsic, overload

    types_by_letter = {"t": tangent_type(), "r": types.float64, "i": types.int64, "-": types.void}
    names = ", ".join("abcd"[: len(arguments)])
    all_names = f"context, {names}".rstrip(", ")

    def typing(context: Any, *argument_types: Any) -> Any:
        pairs = zip(arguments, argument_types, strict=True)
        return types_by_letter[result](*(kind if letter == "a" else types_by_letter[letter] for letter, kind in pairs)), generate

    # The compiler goes by the names of arguments.
    scope: dict[str, Any] = {"typing": typing}
    exec(f"def generated({all_names}): return typing({all_names})", scope)
    scope["inner"] = intrinsic(scope["generated"])
    exec(f"def implementation({names}): return lambda {names}: inner({names})", scope)
    overload(plain, jit_options=cast(Any, kernel_options(inline=True)), strict=False)(scope["implementation"])


def _spread(builder: Any, number: Any) -> Any:
    """Return a vector of one number."""
    from llvmlite import ir

    kind, index = ir.VectorType(number.type, DIRECTIONS), ir.IntType(32)
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), number, ir.Constant(index, 0))
    return builder.shuffle_vector(first, ir.Constant(kind, ir.Undefined), ir.Constant(ir.VectorType(index, DIRECTIONS), [0] * DIRECTIONS))


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


def _one(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    from llvmlite import ir

    return ir.Constant(ir.VectorType(ir.DoubleType(), DIRECTIONS), [1.0] * DIRECTIONS)


def _last(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    from llvmlite import ir

    return builder.extract_element(arguments[0], ir.Constant(ir.IntType(32), DIRECTIONS - 1))


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


@_compiled("", "t", _zero)
def still():
    """Return the tangent of a constant."""
    return np.zeros(DIRECTIONS)


@_compiled("", "t", _one)
def moving():
    """Return the tangent of a number that changes by 1 in each direction."""
    return np.ones(DIRECTIONS)


@_compiled("t", "r", _last)
def tangent_last(a):
    """Return the derivative in the last direction."""
    return a[DIRECTIONS - 1]


@_compiled("tt", "t", _sum)
def tangent_sum(a, b):
    """Return the sum of two tangents."""
    return a + b


@_compiled("tt", "t", _difference)
def tangent_difference(a, b):
    """Return the difference of two tangents."""
    return a - b


@_compiled("rt", "t", _product)
def tangent_scaled(a, b):
    """Return a tangent times a number `a`."""
    return a * b


@_compiled("rtrt", "t", _combination)
def tangent_combined(a, b, c, d):
    """Return `a` times one tangent and `c` times another."""
    return a * b + c * d


@_compiled("ai", "t", _load)
def tangent_at(a, b):
    """Return the tangent of number `b` of an array of tangents."""
    return a[b * DIRECTIONS : (b + 1) * DIRECTIONS].copy()


@_compiled("ait", "-", _store)
def keep_tangent(a, b, c):
    """Keep a tangent as that of number `b` in an array of them."""
    a[b * DIRECTIONS : (b + 1) * DIRECTIONS] = c


TANGENTS = keep_tangent, moving, still, tangent_at, tangent_combined, tangent_difference, tangent_last, tangent_scaled, tangent_sum
