"""What there is to say of a code, and short forms to write it down with."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

Choice = Callable[[tuple[str, ...], Mapping[str, Any]], str]

UNSURE = "; standard error {std_percent:.0f} %, with residuals correlated over time"


class Sentence(NamedTuple):
    """What there is to say of a code."""

    texts: tuple[str, ...]
    means: str
    advice: str
    about: str = ""
    choose: Choice = lambda texts, numbers: texts[0]
    also: tuple[str, ...] = ()

    def template(self, numbers: Mapping[str, Any]) -> str:
        """Return the text for these numbers, braces still in it."""
        return self.choose(self.texts, numbers)


def where(*names: str) -> Choice:
    """Return the choice of the text of the first of these numbers that is there and not empty, else of the last text."""
    return lambda texts, numbers: texts[next((n for n, name in enumerate(names) if numbers.get(name) not in (None, "", ())), -1)]


def _unsure(choose: Choice) -> Any:
    """Return a choice with the standard error behind it, where there is one."""
    return lambda texts, numbers: choose(texts[:-1], numbers) + (texts[-1] if "std_percent" in numbers else "")


def cause(means: str, advice: str, *texts: str, choose: Choice = lambda texts, numbers: texts[0]) -> Sentence:
    """Return a reason why a log does not determine a parameter."""
    return Sentence((*texts, UNSURE), means, advice, "parameter", _unsure(choose))


def held(text: str, means: str, advice: str = "nothing") -> Sentence:
    """Return a reason why a parameter is held."""
    return Sentence((text,), means, advice, "parameter")


def says(text: str, means: str, advice: str = "nothing") -> Sentence:
    """Return what there is to say of a fit or a prediction as a whole."""
    return Sentence((text,), means, advice)
