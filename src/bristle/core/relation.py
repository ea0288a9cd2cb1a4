"""Conditions between parameters: what a model needs, and what no log can tell."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

__all__ = ["Redundancy", "Relation"]


class Relation(NamedTuple):
    """A condition between parameters, such as F_S >= F_C.

    One that is `advisory` is warned of, not refused. One that is `structural`, such as arrays of one length, keeps
    kernels within their arrays: it holds even where values are not validated.
    """

    condition: str
    holds: Callable[[Any], bool]
    mend: str
    advisory: bool = False
    structural: bool = False


class Redundancy(NamedTuple):
    """A parameter that only shows as a factor of others: no measurement tells it alone."""

    name: str
    factor_of: tuple[str, ...]
