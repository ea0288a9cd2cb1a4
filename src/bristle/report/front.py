"""The first page of a report: what it is about, a verdict with its reasons, the answers to five questions, a figure."""

from __future__ import annotations

import datetime
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from bristle.core.typography import number, with_unit
from bristle.core.variable import Kind, unit_of

if TYPE_CHECKING:
    from bristle.report.page import Picture

__all__ = ["MICROMETRE", "QUESTIONS", "Front", "Ruling", "about", "answered", "fixed", "length_text", "percent_text"]

QUESTIONS = ("Is it good?", "What to type in", "What it gains, and costs", "Can it be trusted?", "What next")
"""What a person who answers for an axis asks of each report."""
MICROMETRE = 1e-6  # the errors of servos are told in no smaller unit


class Ruling(NamedTuple):
    """What a report comes to."""

    level: str
    words: str
    reasons: tuple[str, ...] = ()

    def as_data(self) -> dict[str, Any]:
        """Return it as it stands in JSON."""
        return self._asdict()


class Front(NamedTuple):
    """What the first page of a report shows."""

    heading: str
    facts: str
    level: str
    words: str
    reasons: Sequence[str]
    answers: Sequence[tuple[str, Sequence[str]]]
    figure: Picture | None
    further: str
    without_reasons: str = ""


def about(*facts: str) -> str:
    """Return the line under the heading: the date, and what else is to be known first."""
    return " · ".join((datetime.date.today().isoformat(), *(fact for fact in facts if fact)))


def answered(*lines: Iterable[str], third: str = QUESTIONS[2]) -> list[tuple[str, list[str]]]:
    """Return the five questions, each with its lines; the third one may have other words, where nothing is gained."""
    questions = (*QUESTIONS[:2], third, *QUESTIONS[3:])
    return [(question, list(answer)) for question, answer in zip(questions, lines, strict=True)]


def fixed(value: float, unit: str) -> str:
    """Return a number with its unit, between which no line ends."""
    return with_unit(value, unit).replace(" ", "\u00a0")


def length_text(value: float, kind: Kind) -> str:
    r"""Return a length in no smaller unit than the micrometre, in which the errors of servos are told.

    Examples
    --------
    >>> length_text(4.19e-7, "translational"), length_text(2.5e-3, "rotational")
    ('0.419\xa0µm', '2.5\xa0mrad')
    """
    unit = unit_of("length", kind)
    if not 0.0 < abs(value) < MICROMETRE:
        return fixed(value, unit)
    return f"{number(value / MICROMETRE, digits=3)}\u00a0µ{unit}"


def percent_text(value: float) -> str:
    """Return a share to three digits."""
    return f"{number(value, digits=3)}\u00a0%"
