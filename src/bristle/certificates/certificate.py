"""What a certificate says."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Certificate", "not_applicable"]


@dataclass(frozen=True)
class Certificate:
    """The answer to one question about a model.

    Parameters
    ----------
    applies : bool
        Whether the question makes sense for this model.
    value : float or None
        What was found, in `unit`; None where the question does not apply.
    unit : str
        SI unit of `value` and `threshold`.
    threshold : float or None
        The limit that `value` is held against.
    passed : bool or None
        The verdict; None where the question does not apply.
    advice : str
        One line: what the number means and, where it fails, what to change.
    """

    applies: bool
    value: float | None
    unit: str
    threshold: float | None
    passed: bool | None
    advice: str


def not_applicable(unit: str, reason: str) -> Certificate:
    """Return the certificate of a question that does not make sense for a model."""
    return Certificate(False, None, unit, None, None, reason)
