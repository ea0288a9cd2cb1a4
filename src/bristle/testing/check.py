"""The outcome of one demand of the contract suite."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from bristle.core.errors import told_by

__all__ = ["Check", "Demand", "Fact", "UnmetError", "outcome"]

Demand = Callable[[Any], Any]


@dataclass(frozen=True)
class Check:
    """One demand of the contract: whether the model meets it, what was seen, and what to do.

    Parameters
    ----------
    name : str
        The demand.
    passed : bool
        Whether it is met; a demand that does not apply is.
    detail : str
        What was seen, in words.
    advice : str
        What to change where it is not met.
    applies : bool
        Whether the model has what the demand is about.
    value : float or None
        What was measured; None where nothing was, or where the check stopped before.
    unit : str
        Unit of value and threshold; ``"1"`` is a ratio or a count.
    threshold : float or None
        What the value is compared with.
    """

    name: str
    passed: bool
    detail: str = ""
    advice: str = ""
    applies: bool = True
    value: float | None = None
    unit: str | None = None
    threshold: float | None = None


@dataclass(frozen=True)
class Fact:
    """What a check saw: in words, as a number, and what that number must keep to."""

    detail: str = ""
    value: float | None = None
    unit: str | None = None
    threshold: float | None = None
    applies: bool = True


class UnmetError(Exception):
    """A demand is not met; carries what was seen and the advice."""

    def __init__(self, fact: Fact | str, advice: str = "") -> None:
        self.fact, self.advice = fact if isinstance(fact, Fact) else Fact(fact), advice
        super().__init__(self.fact.detail)


def outcome(check: Demand, model: Any) -> Check:
    """Return what became of a demand on a model or a slot."""
    name = check.__name__.replace("_", " ")
    try:
        return Check(name, True, **asdict(check(model)))
    except UnmetError as failure:
        return Check(name, False, advice=failure.advice, **asdict(failure.fact))
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001  (a user's code may raise anything: that is the fact)
        return Check(name, False, f"stops with {type(error).__name__}: {told_by(error)}", "Kernels never raise")
