"""Hysteresis operators, one a file: what comes out depends on the path of the input, not on its speed.

Each name is a descriptor: call it with parameters to have an operator, and run it with `bristle.response`.

Examples
--------
>>> import bristle as br
>>> operator = br.hysteresis.preisach(kernel="reformed_dahl_exact", s="125 mN*m/rad", f_p="150 mN*m")
>>> br.response(operator, [1.0, 0.5, 1.0]).round(6)
array([0.056552, 0.008571, 0.056552])
"""

from __future__ import annotations

from bristle.core.contracts import HysteresisOperator
from bristle.hysteresis.preisach import MODEL as preisach

OPERATORS: dict[str, HysteresisOperator] = {operator.name: operator for operator in (preisach,)}

__all__ = ["OPERATORS", "preisach"]
