"""What a golden case is, and where its numbers lie."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

FROZEN = Path(__file__).parent / "frozen"


@dataclass(frozen=True)
class Case:
    """One piece of work with fixed input.

    Parameters
    ----------
    name : str
        Of the case, and of its file.
    work : callable
        Returns what it found as plain data.
    fast : bool
        Whether it runs among the tests; else with ``python -m tests.golden check`` only.
    measured : bool
        Whether it reads logs from the folder named in BRISTLE_DATA.
    """

    name: str
    work: Callable[[], dict[str, Any]]
    fast: bool
    measured: bool

    @property
    def file(self) -> Path:
        """Where the numbers lie."""
        return FROZEN / f"{self.name}.json"


CASES: dict[str, Case] = {}


def golden(*, fast: bool = False, measured: bool = False) -> Callable[[Callable[[], Any]], Callable[[], Any]]:
    """Register a function as a case under its own name."""

    def register(work: Callable[[], Any]) -> Callable[[], Any]:
        name = work.__name__
        assert name not in CASES, name
        CASES[name] = Case(name, work, fast, measured)
        return work

    return register
