r"""Tangents: derivatives of a number in `DIRECTIONS` directions at once, in vector registers of compiled code.

A derivative in direction k is :math:`\dot y_k = \sum_i \frac{\partial y}{\partial x_i} \dot x_{i,k}`, forward through a
computation (R. E. Wengert, Communications of the ACM 7(8), 1964, doi:10.1145/355586.364791). In plain Python a tangent is
an array of shape (DIRECTIONS,); in an array of tangents, the tangent of number i begins at ``i * DIRECTIONS``.
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
        """A vector of `DIRECTIONS` numbers."""

        def __init__(self, manager: Any, kind: Any) -> None:
            super().__init__(manager, kind, ir.VectorType(ir.DoubleType(), DIRECTIONS))

    return TangentType(name="tangent")


def _compiled(arguments: str, result: str, generate: Callable[..., Any]) -> Callable[[F], F]:
    """Mark a function of tangents (t), reals (r), indices (i) and addresses of arrays (a), with its code generator."""

    def mark(plain: F) -> F:
        on_activation(lambda: _make_known(plain, arguments, result, generate))
        return plain

    return mark


def _make_known(
    plain: Callable[..., Any], arguments: str, result: str, generate: Callable[..., Any]
) -> None:
    from numba.core import types
    from numba.extending import intrinsic, overload

    types_by_letter = {"t": tangent_type(), "r": types.float64, "i": types.int64, "-": types.void}
    names = ", ".join("abcd"[: len(arguments)])
    all_names = f"context, {names}".rstrip(", ")

    def write(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        def plain_value(letter: str, kind: Any, value: Any) -> Any:
            return (
                context.make_array(kind)(context, builder, value).data if letter == "a" else value
            )

        made = generate(builder, *map(plain_value, arguments, signature.args, values))
        return context.get_dummy_value() if result == "-" else made

    def typing(context: Any, *argument_types: Any) -> Any:
        pairs = zip(arguments, argument_types, strict=True)
        return types_by_letter[result](
            *(kind if letter == "a" else types_by_letter[letter] for letter, kind in pairs)
        ), write

    # The compiler matches arguments by name.
    scope: dict[str, Any] = {"typing": typing}
    exec(f"def generated({all_names}): return typing({all_names})", scope)
    scope["inner"] = intrinsic(scope["generated"])
    exec(f"def implementation({names}): return lambda {names}: inner({names})", scope)
    overload(plain, jit_options=cast(Any, kernel_options(inline=True)), strict=False)(
        scope["implementation"]
    )


def _uniform(number: float) -> Any:
    """Return a vector with equal numbers."""
    from llvmlite import ir

    return ir.Constant(ir.VectorType(ir.DoubleType(), DIRECTIONS), [number] * DIRECTIONS)


def _product(builder: Any, number: Any, tangent: Any) -> Any:
    from llvmlite import ir

    index = ir.IntType(32)
    first = builder.insert_element(
        ir.Constant(tangent.type, ir.Undefined), number, ir.Constant(index, 0)
    )
    everywhere = ir.Constant(ir.VectorType(index, DIRECTIONS), [0] * DIRECTIONS)
    return builder.fmul(
        builder.shuffle_vector(first, ir.Constant(tangent.type, ir.Undefined), everywhere), tangent
    )


def _last(builder: Any, tangent: Any) -> Any:
    from llvmlite import ir

    return builder.extract_element(tangent, ir.Constant(ir.IntType(32), DIRECTIONS - 1))


def _place(builder: Any, data: Any, at: Any) -> Any:
    """Return the address of a tangent in an array of them."""
    from llvmlite import ir

    number = builder.gep(data, [builder.mul(at, at.type(DIRECTIONS))])
    return builder.bitcast(number, ir.VectorType(ir.DoubleType(), DIRECTIONS).as_pointer())


@_compiled("", "t", lambda builder: _uniform(0.0))
def still():
    """Return the tangent of a constant."""
    return np.zeros(DIRECTIONS)


@_compiled("", "t", lambda builder: _uniform(1.0))
def moving():
    """Return the tangent of a number that changes by 1 in each direction."""
    return np.ones(DIRECTIONS)


@_compiled("t", "r", _last)
def tangent_last(a):
    """Return the derivative in the last direction."""
    return a[DIRECTIONS - 1]


@_compiled("tt", "t", lambda builder, a, b: builder.fadd(a, b))
def tangent_sum(a, b):
    """Return the sum of two tangents."""
    return a + b


@_compiled("tt", "t", lambda builder, a, b: builder.fsub(a, b))
def tangent_difference(a, b):
    """Return the difference of two tangents."""
    return a - b


@_compiled("rt", "t", _product)
def tangent_scaled(a, b):
    """Return a tangent times a number `a`."""
    return a * b


@_compiled(
    "rtrt",
    "t",
    lambda builder, a, b, c, d: builder.fadd(_product(builder, a, b), _product(builder, c, d)),
)
def tangent_combined(a, b, c, d):
    """Return `a` times one tangent and `c` times another."""
    return a * b + c * d


@_compiled("ai", "t", lambda builder, a, b: builder.load(_place(builder, a, b), align=8))
def tangent_at(a, b):
    """Return the tangent of number `b` of an array of tangents."""
    return a[b * DIRECTIONS : (b + 1) * DIRECTIONS].copy()


@_compiled("ait", "-", lambda builder, a, b, c: builder.store(c, _place(builder, a, b), align=8))
def keep_tangent(a, b, c):
    """Store a tangent for number `b` in an array of tangents."""
    a[b * DIRECTIONS : (b + 1) * DIRECTIONS] = c


TANGENTS = (
    keep_tangent,
    moving,
    still,
    tangent_at,
    tangent_combined,
    tangent_difference,
    tangent_last,
    tangent_scaled,
    tangent_sum,
)
