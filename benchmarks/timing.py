"""Timing side by side: the two sides in turn, so that a machine that slows down slows both."""

from __future__ import annotations

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

__all__ = [
    "BRISTLE",
    "EXAMPLES",
    "Ratio",
    "busy_side_by_side",
    "command",
    "python",
    "side_by_side",
    "wall",
]

EXAMPLES = Path(__file__).parents[1] / "examples"
BRISTLE = shutil.which("bristle") or str(Path(sys.executable).parent / "bristle")


@dataclass(frozen=True)
class Ratio:
    """One claim: what was timed, against what, and its limit: of the ratio, or of the time itself [s]."""

    name: str
    ours: float
    theirs: float
    ratio: float
    limit: float | None
    against: str
    error: str = ""
    most: float | None = None

    @property
    def missed(self) -> bool:
        """Whether the claim does not hold."""
        return (self.limit is not None and self.ratio > self.limit) or (
            self.most is not None and self.ours > self.most
        )

    def row(self) -> str:
        """Return the claim as a line of the table."""
        ratio = f"{self.ratio:.2f}" if self.ratio >= 0.1 else f"{self.ratio:.2g}"
        limit = "" if self.limit is None else f"<= {self.limit:g}"
        if self.most is not None:
            limit = f"<= {self.most:g} s"
        verdict = "MISSED" if self.missed else "ok" if limit else ""
        return (
            f"{self.name:<44} {_time(self.ours):>10} {_time(self.theirs):>10} {ratio:>7} {limit:>8} "
            f"{verdict:<7} {self.against}{'; ' + self.error if self.error else ''}"
        )


HEAD = f"{'claim':<44} {'bristle':>10} {'other':>10} {'ratio':>7} {'limit':>8} {'':<7} other program; error"


def _time(seconds: float) -> str:
    if seconds < 1e-6:
        return f"{1e9 * seconds:.2f} ns"
    if seconds < 1e-3:
        return f"{1e6 * seconds:.1f} µs"
    return f"{1e3 * seconds:.1f} ms" if seconds < 1.0 else f"{seconds:.2f} s"


def wall(work: Callable[[], object]) -> float:
    """Return the wall time of a call [s]."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def side_by_side(
    ours: Callable[[], object], theirs: Callable[[], object], runs: int
) -> tuple[float, float, float]:
    """Return the medians of both sides [s] and the median of the ratios, pair by pair, after one warm-up."""
    ours()
    theirs()
    pairs = [(wall(ours), wall(theirs)) for _ in range(runs)]
    return (
        statistics.median(a for a, _ in pairs),
        statistics.median(b for _, b in pairs),
        statistics.median(a / b for a, b in pairs),
    )


def busy_side_by_side(
    ours: Callable[[], object], theirs: Callable[[], object], runs: int
) -> tuple[float, float, float]:
    """Return the least time that all cores spend on either side [s], and the ratio, after one warm-up.

    What else the machine does is no part of it: for calls so short that a turn of another program is longer.
    """
    ours()
    theirs()
    pairs = [(_busy(ours), _busy(theirs)) for _ in range(runs)]
    a, b = (min(times) for times in zip(*pairs, strict=True))
    return a, b, a / b


def _busy(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def python(code: str, **environment: str) -> Callable[[], object]:
    """Return the run of some Python in a process of its own."""
    return command(sys.executable, "-c", code, **environment)


def command(*words: str, **environment: str) -> Callable[[], object]:
    """Return the run of a command; it must succeed.

    Modules are compiled once, as those of a package are that was installed.
    """
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    compiled = {"PYTHONPYCACHEPREFIX": str(Path(tempfile.gettempdir()) / "bristle-benchmarks")}
    return lambda: subprocess.run(
        words, check=True, capture_output=True, env=kept | compiled | environment
    )
