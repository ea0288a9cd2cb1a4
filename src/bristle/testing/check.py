"""The outcome of one demand of the contract suite."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from bristle.core.errors import place_in_own_code, told_by
from bristle.core.variable import Kind, unit_of
from bristle.engine import interpreted

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


def judged(fact: Fact, advice: str, *, unmet: bool) -> Fact:
    """Return what was seen; raise it with the advice where the demand is not met."""
    if unmet:
        raise UnmetError(fact, advice)
    return fact


def _outcome(check: Demand, subject: Any, where_it_stops: str = "Kernels never raise") -> Check:
    """Return what became of a demand on a model, or what else has a contract; what to do where its code stops."""
    name = check.__name__.replace("_", " ")
    try:
        return Check(name, True, **asdict(check(subject)))
    except UnmetError as failure:
        return Check(name, False, advice=failure.advice, **asdict(failure.fact))
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001  (a user's code may raise anything: that is the fact)
        return Check(name, False, f"stops with {type(error).__name__}: {told_by(error)}{_told_place(error)}", where_it_stops)


def outcomes(checks: Iterable[Demand], subject: Any, form: Collection[Demand], where_it_stops: str = "Kernels never raise") -> list[Check]:
    """Return what became of several demands, in order; after one of `form` that is not met the others are not tried."""
    results: list[Check] = []
    for check in checks:
        results.append(_outcome(check, subject, where_it_stops))
        if not results[-1].passed and check in form:
            break
    return results


def _told_place(error: BaseException) -> str:
    """Return where in a user's file it stopped, in brackets; nothing where that is not known."""
    place = place_in_own_code(error)
    return f" ({place})" if place else ""


def compiled_as_plain(forces: Callable[[], np.ndarray], kind: Kind) -> Fact:
    """Return that some signals are the same in plain Python and compiled, to the bit."""
    fast = forces()
    with interpreted():
        slow = forces()
    worst = float(np.max(np.abs(fast - slow)))
    return judged(
        Fact(f"largest difference {worst:.3g} in {fast.size} steps", worst, unit_of("force", kind), 0.0),
        "Use bristle.core.mathematics, not math or **",
        unmet=fast.tobytes() != slow.tobytes(),
    )
