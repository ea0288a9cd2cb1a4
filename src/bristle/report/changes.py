"""Changes between two sides in words: names of what changed, the change in percent, its interval."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.core.typography import number

if TYPE_CHECKING:
    from bristle.comparison.result import Change

__all__ = ["WORDS", "interval_of", "percent_of"]

WORDS = {
    "following_error.rms": "Following error, root mean square",
    "following_error.peak": "Following error, largest in a cycle",
    "reversals.forward_to_backward": "Following error behind a reversal, forward to backward",
    "reversals.backward_to_forward": "Following error behind a reversal, backward to forward",
    "effort.rms": "Effort, root mean square",
    "effort.peak": "Effort, largest in a cycle",
    "friction.level": "Friction level",
}
FINEST = 0.1  # percent, told to two digits


def _half_width(change: Change) -> float | None:
    """Return the half-width of the interval [%], but for digits that nobody reads."""
    if change.interval_percent is None:
        return None
    low, high = change.interval_percent
    return max(0.5 * (high - low), FINEST)


def _signed(value: float, resolution: float | None) -> str:
    text = number(value, resolution, digits=2)
    return text if text.startswith(("−", "–")) or not text.strip("0.") else f"+{text}"


def percent_of(change: Change) -> str:
    """Return a change in percent of before, to the digits that its interval allows."""
    return f"{_signed(change.change_percent, _half_width(change))} %"


def interval_of(change: Change) -> str:
    """Return the ends of its 95 % interval."""
    if change.interval_percent is None:
        return "–"
    low, high = (_signed(end, _half_width(change)) for end in change.interval_percent)
    return f"{low} to {high} %"
