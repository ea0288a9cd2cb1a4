"""Conditions between parameters in a form that a page can look at while they move."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from bristle.core.contracts import Component
from bristle.report.symbols import symbolic

__all__ = ["conditions_of", "shares_of"]

_CONDITION = re.compile(r"([\w.]+(?: \* [\w.]+)*) (>=|>|<) ([\w.]+(?: \* [\w.]+)*)")
_SHARES = re.compile(r"sum of (\w+) = 1")
SIDES = ("_pos", "_neg")


def conditions_of(component: Component) -> list[dict[str, Any]]:
    """Return conditions that compare two products, by direction where parameters are; others are left out."""
    conditions = []
    for relation in component.relations:
        if match := _CONDITION.fullmatch(relation.condition):
            left, sign, right = match[1].split(" * "), match[2], match[3].split(" * ")
            # What stands behind a semicolon is for Python.
            mend = str(symbolic(relation.mend.partition(";")[0]))
            pairs = [_on(side, left, right, component.variables) for side in SIDES]
            conditions += [
                {"left": first, "sign": sign, "right": second, "mend": mend, "advisory": relation.advisory}
                for first, second in (pairs[:1] if pairs[0] == pairs[1] else pairs)
            ]
    return conditions


def shares_of(component: Component) -> list[str]:
    """Return the names of arrays whose numbers are shares of a whole."""
    matches = (_SHARES.fullmatch(relation.condition) for relation in component.relations)
    return [match[1] for match in matches if match]


def _on(side: str, left: list[str], right: list[str], variables: Mapping[str, Any]) -> tuple[list[str], list[str]]:
    """Return both products with the parameters of one direction."""
    named = [[name + side if name + side in variables else name for name in product] for product in (left, right)]
    return named[0], named[1]
