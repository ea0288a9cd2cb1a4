"""What the report tells of one figure of the paper."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from bristle.core.typography import number

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure

    from bristle.report.table import Table

__all__ = ["Reproduced", "Verdict", "in_micrometres", "percent"]

Verdict = Literal["holds", "holds in part", "does not hold", "shown"]


@dataclass(frozen=True)
class Reproduced:
    """One figure of the paper, reproduced.

    Parameters
    ----------
    number : int
        Of the figure.
    title : str
        What it shows.
    claim : str
        What the paper concludes from it, one sentence.
    verdict : {"holds", "holds in part", "does not hold", "shown"}
        What became of the claim; ``shown`` where there is none to be tested.
    said : str
        What the paper says, in its words or close to them.
    found : list of str
        What came out here, with the numbers.
    differs : str
        Why it is not what the paper shows.
    draw : callable
        Returns the figure.
    alternative : str
        What the figure is, for people who cannot see it.
    source : Path
        The experiment.
    numbers : mapping
        What was found, in SI, for the summary.
    tables : tuple of Table
        What was found, side by side.
    extras : mapping of str to (callable, str, str)
        Further figures by name: how to draw them, what they are, what to see in them.
    """

    number: int
    title: str
    claim: str
    verdict: Verdict
    said: str
    found: list[str]
    differs: str
    draw: Callable[[], Figure]
    alternative: str
    source: Path
    numbers: Mapping[str, Any]
    tables: tuple[Table, ...] = ()
    extras: Mapping[str, tuple[Callable[[], Figure], str, str]] = field(default_factory=dict)


def percent(share: float, step: float = 0.1) -> str:
    """Return a share as text, in percent to this step."""
    return f"{number(100.0 * share, resolution=10.0 * step)} %"


def in_micrometres(length: float, digits: int = 3) -> str:
    """Return a length [m] as text, in micrometres."""
    return f"{number(1e6 * length, digits=digits)} µm"
