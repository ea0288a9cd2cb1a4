"""`kernel`: the decorator of functions that run compiled and remain plain Python functions."""

from collections.abc import Callable
from typing import Any, TypeVar, overload

from bristle.core.errors import InputError, error_text

F = TypeVar("F", bound=Callable[..., Any])

_kernels: list[tuple[Callable[..., Any], bool, bool]] = []
_pending: list[Callable[[], None]] = []
_active = False


@overload
def kernel(function: F, /) -> F: ...
@overload
def kernel(
    *, inline: bool = True, compiled_as: Callable[[], Any] | None = None, portable: bool = True
) -> Callable[[F], F]: ...
def kernel(
    function: Any = None,
    /,
    *,
    inline: bool = True,
    compiled_as: Callable[[], Any] | None = None,
    portable: bool = True,
) -> Any:
    """Mark a plain function as a kernel and return it unchanged.

    Parameters
    ----------
    function : callable
        The function.
    inline : bool
        Whether compiled callers inline it. False for long branches that rarely run.
    compiled_as : callable, optional
        Returns a replacement for the compiler, with the same arguments and the same bits.
    portable : bool
        Whether other targets support it, too. False for a function with tangents.

    Returns
    -------
    callable
        The same function.
    """

    def mark(plain: F) -> F:
        _kernels.append((plain, inline, portable))
        on_activation(lambda: _make_known(plain, inline, compiled_as))
        return plain

    return mark if function is None else mark(function)


def kernels(*, portable: bool = True) -> list[Callable[..., Any]]:
    """Return all kernels defined so far, by default only kernels for other targets."""
    return [plain for plain, _, is_portable in _kernels if is_portable or not portable]


def is_absorbed(function: Callable[..., Any]) -> bool:
    """Return whether this is a kernel that compiled callers inline."""
    return any(plain is function and inline for plain, inline, _ in _kernels)


def on_activation(action: Callable[[], None]) -> None:
    """Run `action` when the compiler is first used, or immediately if it is already in use."""
    if _active:
        action()
    else:
        _pending.append(action)


def compiler() -> Any:
    """Return numba, loaded."""
    try:
        import numba
    except ImportError:
        raise
    except Exception as error:  # noqa: BLE001  (it reads settings of the environment on import)
        raise InputError(
            f"cannot be loaded ({error_text(error)})",
            path="numba",
            mend="Unset the variables of the environment that begin with NUMBA_",
        ) from None
    return numba


def activate() -> None:
    """Import the compiler and register all kernels with it."""
    global _active  # noqa: PLW0603
    if _active:
        return
    compiler()
    _active = True
    while _pending:
        _pending.pop(0)()


def _make_known(
    plain: Callable[..., Any], inline: bool, compiled_as: Callable[[], Any] | None
) -> None:
    from numba.extending import overload, register_jitable

    if compiled_as is None:
        register_jitable(**kernel_options(inline))(plain)
    else:
        options: Any = kernel_options(inline)
        overload(plain, jit_options=options, strict=False)(compiled_as())


def kernel_options(inline: bool) -> dict[str, Any]:
    """Return the compiler options of a kernel."""
    return {"error_model": "numpy", "forceinline": inline} | ({} if inline else {"nogil": True})
