"""The outcome of one demand of the contract suite."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Check"]


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
