"""The outcome of one demand of the contract suite."""

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


def outcomes(checks: Iterable[Demand], subject: Any, form: Collection[Demand], where_it_stops: str = "Kernels never raise") -> list[Check]:
    """Return what became of several demands, in order; after one of `form` that is not met the others are not tried.

    `where_it_stops` tells what to do where the code of a demand stops.
    """
    results: list[Check] = []
    for check in checks:
        name = check.__name__.replace("_", " ")
        try:
            outcome = Check(name, True, **asdict(check(subject)))
        except UnmetError as failure:
            outcome = Check(name, False, advice=failure.advice, **asdict(failure.fact))
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # noqa: BLE001  (a user's code may raise anything: that is the fact)
            place = place_in_own_code(error)
            detail = f"stops with {type(error).__name__}: {told_by(error)}{f' ({place})' if place else ''}"
            outcome = Check(name, False, detail, where_it_stops)
        results.append(outcome)
        if not outcome.passed and check in form:
            break
    return results


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
