"""The contents of the report for one figure of the paper."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from bristle.core import Origin, number
from bristle.files import read_toml

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from bristle.report.table import Table

Verdict = Literal[
    "found", "found in part", "built in in part", "built in", "calibrated", "refuted", "shown"
]


def verdict_if(holds: bool, verdict: Verdict = "found") -> Verdict:
    """Return the verdict on a claim that holds here under a condition."""
    if holds:
        return verdict
    return "refuted"


class Words(NamedTuple):
    """The fixed texts of a figure."""

    title: str
    claim: str
    quotation: str
    differs: str
    alternative: str
    short: str = ""


_all_words = cache(lambda: read_toml(Path(__file__).with_name("words.toml")).data)


@dataclass(frozen=True)
class Reproduced:
    """One figure of the paper, reproduced."""

    number: int
    verdict: Verdict
    found: list[str]
    draw: Callable[[], Figure]
    origin: Origin
    numbers: Mapping[str, Any]
    tables: tuple[Table, ...] = ()
    extras: Mapping[str, tuple[Callable[[], Figure], str, str]] = field(default_factory=dict)
    beside: tuple[Origin, ...] = ()

    @property
    def words(self) -> Words:
        """The fixed texts of the figure."""
        return Words(**_all_words()[str(self.number)])


def percent(share: float, step: float = 0.1) -> str:
    """Return a share as text, in percent to this step."""
    return f"{number(100.0 * share, resolution=10.0 * step)} %"


def in_micrometres(length: float, digits: int = 3) -> str:
    """Return a length [m] as text, in micrometres."""
    return f"{number(1e6 * length, digits=digits)} µm"


def in_millinewtons(torque: float, digits: int = 3) -> str:
    """Return a torque [N*m] as text, in millinewton metres."""
    return f"{number(1e3 * torque, digits=digits)} mN·m"


def spread(values: ArrayLike, step: float = 0.0) -> str:
    """Return mean and standard deviation of repeated values, as text; only the mean without a spread.

    Examples
    --------
    >>> spread([4.1, 4.3, 4.6]), spread([0.93])
    ('4.33 ± 0.25', '0.9300')
    """
    array = np.asarray(values, dtype=float)
    mean = float(np.mean(array))
    deviation = 0.0
    if array.size > 1:
        deviation = float(np.std(array, ddof=1))
    if deviation > max(1e-9 * abs(mean), 0.01 * step):
        return f"{number(mean, deviation)} ± {number(deviation, deviation)}"
    return number(mean, step or None)
