"""Errors for invalid input; problems during a computation are a status in the result (`bristle.core.status`)."""

from __future__ import annotations

import reprlib
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

from bristle.core.typography import escaped

# Limits that keep a message readable despite long names in files.
PLACE, MESSAGE, ALLOWED = 400, 800, 1200
# Limits for the comparison of names, which takes time.
LONGEST_NAME, MOST_NAMES = 80, 10_000
MOST_SHOWN = 20  # of the values of a list


class BristleError(Exception):
    """Base of all errors that bristle raises on purpose; `exit_code` is the exit code of the command line."""

    exit_code = 70


class InputError(BristleError, ValueError):
    """Invalid input of the user.

    Parameters
    ----------
    message : str
        The error in one sentence.
    path : str, optional
        Place: a file and its key, an argument or a column.
    value : object, optional
        The invalid value.
    allowed : str, optional
        Allowed values, with unit.
    mend : str, optional
        Remedy, in the imperative.

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
        self.message, self.path, self.value, self.allowed, self.mend = (
            message,
            path,
            value,
            allowed,
            mend,
        )
        super().__init__(str(self))

    def __str__(self) -> str:
        message = shortened(self.message, MESSAGE)
        text = f"{shortened(self.path, PLACE)}: {message}" if self.path else message
        facts = [f"found {_short(self.value)}"] if self.value is not None else []
        facts += [f"allowed {shortened(self.allowed, ALLOWED)}"] if self.allowed else []
        text += f"; {', '.join(facts)}" if facts else ""
        return in_one_line(f"{text}. {shortened(self.mend, MESSAGE)}" if self.mend else text)

    def at(self, prefix: str = "", **parts: Any) -> InputError:
        """Return the same error with `prefix` before its path, and with `parts` replaced."""
        path = f"{prefix}: {self.path}" if prefix and self.path else prefix or self.path
        return type(self)(
            self.message,
            **{"path": path, "value": self.value, "allowed": self.allowed, "mend": self.mend}
            | parts,
        )


@contextmanager
def located(prefix: object = "", **parts: Any) -> Iterator[None]:
    """Return a context that adds a place to the errors inside it, as `InputError.at` does."""
    try:
        yield
    except InputError as error:
        raise error.at(str(prefix), **parts) from None


class TooShortError(InputError):
    """A recording that is too short; of several, bristle uses the others."""


class MissingExtraError(InputError):
    """A required optional dependency is not installed."""

    @classmethod
    def of(cls, feature: str, extra: str) -> MissingExtraError:
        """Return the error for `feature`, which needs the optional dependencies named `extra`."""
        return cls(
            f"{feature} needs an optional dependency", mend=f'Type: pip install "bristle[{extra}]"'
        )


class InputWarning(UserWarning):
    """bristle changes or reinterprets input of the user; the message states how."""


def did_you_mean(name: object, names: Iterable[str], cutoff: float = 0.6) -> str:
    """Return a question that suggests a similar known name; empty if there is no similar name."""
    close = close_names(str(name), names, cutoff)
    return f"Did you mean {close[0]!r}?" if close else ""


def close_names(name: str, names: Iterable[str], cutoff: float = 0.5) -> list[str]:
    """Return the `names` that resemble `name` without regard to case, the closest first."""
    import difflib

    if len(name) > LONGEST_NAME:
        return []
    spelt = {
        name.casefold(): name for name in islice(names, MOST_NAMES) if len(name) <= LONGEST_NAME
    }
    return [
        spelt[name] for name in difflib.get_close_matches(name.casefold(), spelt, cutoff=cutoff)
    ]


def error_text(error: BaseException) -> str:
    """Return the message of an error in one line; the message of an error in user code may fail, too."""
    try:
        return " ".join(str(error).split())
    except Exception as failure:  # noqa: BLE001
        return f"its message is not available ({type(failure).__name__})"


def said_by_library(error: BaseException) -> str:
    """Return the message of a library in brackets; empty if it refers to internal objects."""
    message = error_text(error)
    return f" ({shortened(message, 120)})" if message and not set("<>[{") & set(message) else ""


def in_one_line(text: str) -> str:
    """Return text in one line of printable characters; names in files may contain any characters."""
    if text.isprintable():
        return text
    line = " ".join(escaped(text).splitlines())
    return "".join(
        letter if letter.isprintable() else letter.encode("unicode_escape").decode()
        for letter in line
    )


def shortened(text: str, width: int) -> str:
    """Shorten text to this width, with an ellipsis."""
    return text if len(text) <= width else f"{text[: width - 3]}..."


def _short(value: object, width: int = 60) -> str:
    if isinstance(value, (str, bytes)):
        value = value[: 2 * width]
    try:
        if callable(dated := getattr(value, "isoformat", None)):  # a date in a file of settings
            return str(dated())
        many = isinstance(value, (list, tuple, dict, set, frozenset)) and len(value) > MOST_SHOWN
        text = reprlib.repr(value) if many else repr(value)
        shape = getattr(value, "shape", ()) if len(text) > width or "\n" in text else ()
        return f"an array of shape {shape}" if shape else shortened(text, width)
    except Exception:  # noqa: BLE001  (the repr of a foreign object may fail)
        return f"a value of type {type(value).__name__}"


OWN_CODE = "bristle_user_"  # Prefix of the module names of user files


def place_in_own_code(error: BaseException) -> str:
    """Return the user file and its last line in the traceback of an error, or an empty text."""
    for frame, line in reversed(list(traceback.walk_tb(error.__traceback__))):
        if str(frame.f_globals.get("__name__", "")).startswith(OWN_CODE):
            return f"{Path(frame.f_code.co_filename).name}, line {line}"
    return ""
