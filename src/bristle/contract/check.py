"""The result of one demand of the contract suite."""

from collections.abc import Callable, Collection, Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from bristle.core.errors import error_text, place_in_own_code
from bristle.core.variable import Kind, unit_of
from bristle.engine import interpreted

Demand = Callable[[Any], Any]


@dataclass(frozen=True)
class Check:
    """One demand of the contract: whether the model meets it, the observation, and the advice.

    Parameters
    ----------
    name : str
        The demand.
    passed : bool
        Whether it is met; true for a demand that does not apply.
    detail : str
        The observation, in words.
    advice : str
        The remedy, if it is not met.
    applies : bool
        Whether the demand applies to the model.
    value : float or None
        The measured number; None if the check has no number or stopped early.
    unit : str
        Unit of value and threshold; ``"1"`` is a ratio or a count.
    threshold : float or None
        Limit of the value.
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
    """The observation of a check: in words, as a number, and the limit of that number."""

    detail: str = ""
    value: float | None = None
    unit: str | None = None
    threshold: float | None = None
    applies: bool = True


class UnmetError(Exception):
    """A demand is not met; carries the observation and the advice."""

    def __init__(self, fact: Fact | str, advice: str = "") -> None:
        self.fact = fact if isinstance(fact, Fact) else Fact(fact)
        self.advice = advice
        super().__init__(self.fact.detail)


def judged(fact: Fact, advice: str, *, unmet: bool) -> Fact:
    """Return the observation; raise it with the advice if the demand is not met."""
    if unmet:
        raise UnmetError(fact, advice)
    return fact


def outcomes(
    checks: Iterable[Demand],
    subject: Any,
    form: Collection[Demand],
    where_it_stops: str = "Kernels never raise",
) -> list[Check]:
    """Return the results of several demands, in order; if a demand of `form` is not met, the others are skipped."""
    results: list[Check] = []
    for check in checks:
        name = check.__name__.replace("_", " ")
        try:
            outcome = Check(name, True, **asdict(check(subject)))
        except UnmetError as failure:
            outcome = Check(name, False, advice=failure.advice, **asdict(failure.fact))
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # noqa: BLE001  (user code may raise any error: it is the observation)
            place = place_in_own_code(error)
            detail = f"stops with {type(error).__name__}: {error_text(error)}"
            if place:
                detail += f" ({place})"
            outcome = Check(name, False, detail, where_it_stops)
        results.append(outcome)
        if not outcome.passed and check in form:
            break
    return results


def compiled_as_plain(forces: Callable[[], np.ndarray], kind: Kind) -> Fact:
    """Check that signals are the same in plain Python and compiled, to the bit."""
    fast = forces()
    with interpreted():
        slow = forces()
    worst = float(np.max(np.abs(fast - slow)))
    return judged(
        Fact(
            f"largest difference {worst:.3g} in {fast.size} steps",
            worst,
            unit_of("force", kind),
            0.0,
        ),
        "Use bristle.core.mathematics, not math or **",
        unmet=fast.tobytes() != slow.tobytes(),
    )
