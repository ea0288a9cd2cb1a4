"""A golden case, and the file of its frozen results."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import scipy.linalg  # noqa: F401  (it brings a library of its own, which must be there to be limited)
from tests.golden.comparison import ELSEWHERE, RELATIVE, Difference, differences, frozen_text
from tests.golden.machine import elsewhere
from threadpoolctl import threadpool_limits

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

    def found(self) -> dict[str, Any]:
        """Do the work, with one thread for linear algebra: several add up in another order, machine by machine."""
        with threadpool_limits(1, user_api="blas"):
            return json.loads(frozen_text(self.work()))  # as it comes out of the file

    @property
    def file(self) -> Path:
        """Where the numbers lie."""
        return FROZEN / f"{self.name}.json"


CASES: dict[str, Case] = {}


def register(
    name: str, work: Callable[[], dict[str, Any]], *, fast: bool, measured: bool = False
) -> None:
    """Add a case."""
    assert name not in CASES, name
    CASES[name] = Case(name, work, fast, measured)


def golden(
    *, fast: bool = False, measured: bool = False
) -> Callable[[Callable[[], Any]], Callable[[], Any]]:
    """Add a function as a case under its own name."""

    def added(work: Callable[[], Any]) -> Callable[[], Any]:
        register(work.__name__, work, fast=fast, measured=measured)
        return work

    return added


def tolerance_for(case: Case) -> float:
    """Return by which share numbers may differ from those frozen: more where these are of another machine."""
    return ELSEWHERE if elsewhere(case.name) else RELATIVE


def differences_of(case: Case, relative: float) -> list[Difference]:
    """Do the work of a case, and return how what is found differs from what was frozen; numbers by a share."""
    return list(
        differences(json.loads(case.file.read_text(encoding="utf-8")), case.found(), relative)
    )
