"""What bristle says to a person whose input it cannot use.

Everything that a person hands in is validated once, where it enters. What is refused there is an
`InputError`: it names the place, the value, what is allowed and what to write instead. Trouble met while
computing is a status in the result (`bristle.core.status`), never an exception.
"""

from __future__ import annotations

from collections.abc import Iterable

__all__ = ["BristleError", "InputError", "InputWarning", "MissingExtraError", "did_you_mean"]


class BristleError(Exception):
    """Base of every error that bristle raises on purpose; `exit_code` is what the command line returns."""

    exit_code = 70


class InputError(BristleError, ValueError):
    """Something a person handed in cannot be used.

    Parameters
    ----------
    message : str
        What is wrong, in one sentence.
    path : str, optional
        Where: a file and the key in it, an argument, a column.
    value : object, optional
        The value found there.
    allowed : str, optional
        What is allowed there, with unit.
    mend : str, optional
        What to write or do instead.

    Examples
    --------
    >>> print(InputError("out of range", path="friction.F_C", value=-1.0, allowed=">= 0 N"))
    friction.F_C: out of range; found -1.0, allowed >= 0 N
    """

    exit_code = 2

    def __init__(
        self,
        message: str,
        *,
        path: str = "",
        value: object = None,
        allowed: str = "",
        mend: str = "",
    ) -> None:
        self.message, self.path, self.value, self.allowed, self.mend = message, path, value, allowed, mend
        super().__init__(str(self))

    def __str__(self) -> str:
        text = f"{self.path}: {self.message}" if self.path else self.message
        found = [f"found {_short(self.value)}"] if self.value is not None else []
        found += [f"allowed {self.allowed}"] if self.allowed else []
        text += f"; {', '.join(found)}" if found else ""
        return f"{text}. {self.mend}" if self.mend else text

    def at(self, prefix: str) -> InputError:
        """Return the same error with `prefix` put before its path."""
        path = f"{prefix}: {self.path}" if self.path else prefix
        return type(self)(self.message, path=path, value=self.value, allowed=self.allowed, mend=self.mend)


class MissingExtraError(InputError):
    """An optional dependency is needed and not installed."""

    @classmethod
    def of(cls, what: str, extra: str) -> MissingExtraError:
        """Return the error for `what`, which needs the optional dependencies named `extra`."""
        return cls(f"{what} needs an optional dependency", mend=f'Type: pip install "bristle[{extra}]"')


class InputWarning(UserWarning):
    """Something a person handed in is used, but not as it stands; the message says how."""


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """Return the question after the name that was meant; nothing where no known one is close.

    Examples
    --------
    >>> did_you_mean("F_c", ["F_v", "F_C"])
    "Did you mean 'F_C'?"
    """
    import difflib

    spelt = {one.casefold(): one for one in known}
    close = difflib.get_close_matches(str(name).casefold(), spelt, n=1)
    return f"Did you mean {spelt[close[0]]!r}?" if close else ""


def _short(value: object, width: int = 60) -> str:
    text = repr(value)
    return text if len(text) <= width else f"{text[: width - 3]}..."
