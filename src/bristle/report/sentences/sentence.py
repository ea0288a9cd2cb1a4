"""The sentence of a code, and short forms to write it."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

Choice = Callable[[tuple[str, ...], Mapping[str, Any]], str]

UNSURE = ". The standard error of {parameter} is {std_percent:.0f} %, which allows for residuals correlated over time"


class Sentence(NamedTuple):
    """The texts of a code, their meaning and their advice."""

    texts: tuple[str, ...]
    means: str
    advice: str
    about: str = ""
    choose: Choice = lambda texts, numbers: texts[0]
    also: tuple[str, ...] = ()

    def template(self, numbers: Mapping[str, Any]) -> str:
        """Return the text for these numbers, with its braces."""
        return self.choose(self.texts, numbers)


def where(*names: str) -> Choice:
    """Return a choice by the first of these numbers that is present and not empty, with the last text as default."""
    return lambda texts, numbers: texts[
        next((n for n, name in enumerate(names) if numbers.get(name) not in (None, "", ())), -1)
    ]


def _unsure(choose: Choice) -> Any:
    """Return a choice that appends the standard error if it is known."""
    return lambda texts, numbers: (
        choose(texts[:-1], numbers) + (texts[-1] if "std_percent" in numbers else "")
    )


def cause(
    means: str, advice: str, *texts: str, choose: Choice = lambda texts, numbers: texts[0]
) -> Sentence:
    """Return a reason why a parameter is not identifiable."""
    return Sentence((*texts, UNSURE), means, advice, "parameter", _unsure(choose))


def held(text: str, means: str, advice: str = "nothing") -> Sentence:
    """Return a reason why a parameter is held constant."""
    return Sentence((text,), means, advice, "parameter")


def says(text: str, means: str, advice: str = "nothing") -> Sentence:
    """Return a sentence about a fit or a prediction as a whole."""
    return Sentence((text,), means, advice)
