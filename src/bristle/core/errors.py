"""What bristle says to a person whose input it cannot use: an `InputError` names place, value, what is allowed, the mend.

Trouble met while computing is a status in the result (`bristle.core.status`), never an exception.
"""

from __future__ import annotations

import reprlib
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

from bristle.core.typography import escaped

# A name in a file may be of any length, a message is to be read.
PLACE, MESSAGE, ALLOWED = 400, 800, 1200
# Names longer than this resemble nothing, and among more than this nobody looks: comparing takes time.
LONGEST_NAME, MOST_NAMES = 80, 10_000
MOST_SHOWN = 20  # of the values of a list


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

    def __init__(self, message: str, *, path: str = "", value: object = None, allowed: str = "", mend: str = "") -> None:
        self.message, self.path, self.value, self.allowed, self.mend = message, path, value, allowed, mend
        super().__init__(str(self))

    def __str__(self) -> str:
        message = shortened(self.message, MESSAGE)
        text = f"{shortened(self.path, PLACE)}: {message}" if self.path else message
        facts = [f"found {_short(self.value)}"] if self.value is not None else []
        facts += [f"allowed {shortened(self.allowed, ALLOWED)}"] if self.allowed else []
        text += f"; {', '.join(facts)}" if facts else ""
        return in_one_line(f"{text}. {shortened(self.mend, MESSAGE)}" if self.mend else text)

    def at(self, prefix: str = "", **parts: Any) -> InputError:
        """Return the same error with `prefix` put before its path, and with other `parts` where they are given."""
        path = f"{prefix}: {self.path}" if prefix and self.path else prefix or self.path
        return type(self)(self.message, **{"path": path, "value": self.value, "allowed": self.allowed, "mend": self.mend} | parts)


@contextmanager
def located(prefix: object = "", **parts: Any) -> Iterator[None]:
    """Say of what is refused inside this block where it stands, as `InputError.at` does."""
    try:
        yield
    except InputError as error:
        raise error.at(str(prefix), **parts) from None


class MissingExtraError(InputError):
    """An optional dependency is needed and not installed."""

    @classmethod
    def of(cls, feature: str, extra: str) -> MissingExtraError:
        """Return the error for `feature`, which needs the optional dependencies named `extra`."""
        return cls(f"{feature} needs an optional dependency", mend=f'Type: pip install "bristle[{extra}]"')


class InputWarning(UserWarning):
    """Something a person handed in is used, but not as it stands; the message says how."""


def did_you_mean(name: object, names: Iterable[str], cutoff: float = 0.6) -> str:
    """Return the question after the name that was meant; nothing where no known one is close."""
    close = close_names(str(name), names, cutoff)
    return f"Did you mean {close[0]!r}?" if close else ""


def close_names(name: str, names: Iterable[str], cutoff: float = 0.5) -> list[str]:
    """Return those of `names` that resemble `name`, the closest first, whatever their case."""
    import difflib

    if len(name) > LONGEST_NAME:
        return []
    spelt = {name.casefold(): name for name in islice(names, MOST_NAMES) if len(name) <= LONGEST_NAME}
    return [spelt[name] for name in difflib.get_close_matches(name.casefold(), spelt, cutoff=cutoff)]


def told_by(error: BaseException) -> str:
    """Return what an error says, in one line; an error of a person's own code may fail at that, too."""
    try:
        return " ".join(str(error).split())
    except Exception as failure:  # noqa: BLE001
        return f"it cannot say why ({type(failure).__name__})"


def said_by_library(error: BaseException) -> str:
    """Return in brackets what a library says of a file, but for what it says of its own objects."""
    message = told_by(error)
    return f" ({shortened(message, 120)})" if message and not set("<>[{") & set(message) else ""


def in_one_line(text: str) -> str:
    """Return text in one line in which every character can be printed: names in files may hold any."""
    if text.isprintable():
        return text
    line = " ".join(escaped(text).splitlines())
    return "".join(letter if letter.isprintable() else letter.encode("unicode_escape").decode() for letter in line)


def shortened(text: str, width: int) -> str:
    """Return text of at most this width; what is left out is marked."""
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
    except Exception:  # noqa: BLE001  (what a person handed in may refuse to describe itself)
        return f"a value of the kind {type(value).__name__}"


OWN_CODE = "bristle_user_"  # What the name of a module begins with that was made of a file of a user's own


def place_in_own_code(error: BaseException) -> str:
    """Return the file and the last line of a user's own on the way to an error; nothing where there is none."""
    for frame, line in reversed(list(traceback.walk_tb(error.__traceback__))):
        if str(frame.f_globals.get("__name__", "")).startswith(OWN_CODE):
            return f"{Path(frame.f_code.co_filename).name}, line {line}"
    return ""
