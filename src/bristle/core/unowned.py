"""Unowned views of arrays: the same numbers, without the count of who holds them.

Compiled code counts the holders of an array whenever it is handed on, by an instruction that all processors must agree
on. An entry outlives everything that it calls and its caller keeps the arrays alive, so inside of it nothing needs to
be counted. An unowned view must not be returned to Python.
"""

from __future__ import annotations

from typing import Any

from bristle.core.kernel import kernel

__all__ = ["unowned"]


def without_holder() -> Any:
    """Return `unowned` for the compiler."""
    from numba.core import cgutils
    from numba.extending import intrinsic

    @intrinsic
    def disowned(context: Any, array: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            lent = context.make_array(signature.args[0])(context, builder, arguments[0])
            lent.meminfo = cgutils.get_null_value(lent.meminfo.type)
            return lent._getvalue()

        return array(array), generate

    def implementation(array: Any) -> Any:
        return lambda array: disowned(array)  # noqa: PLW0108  # pyright: ignore[reportCallIssue]

    return implementation


@kernel(compiled_as=without_holder)
def unowned(array):
    """Return the array itself; compiled, without the count of its holders."""
    return array
