"""What a page draws of elements that stick and slip: the memory of their model, and where each of them slips."""

from __future__ import annotations

from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.typography import typeset
from bristle.core.variable import unit_of
from bristle.friction import gms, maxwell_slip, maxwell_stribeck
from bristle.lab.passivity import inner_of

__all__ = ["elements_of"]

# What the memory keeps of each element, and of which parameters its limit is made: a product over another one. Where
# friction falls with speed, the limit is that of rest.
MEMORIES = {
    maxwell_slip.Parameters: ("length", ["nu_i", "F_C"], ["k_i"]),
    maxwell_stribeck.Parameters: ("force", ["nu_i", "F_S"], []),
    gms.Parameters: ("force", ["nu_i", "F_S"], []),
}


def elements_of(model: Model, memory_size: int) -> dict[str, Any] | None:
    """Return what is drawn of the elements of a model, if it has some: the first numbers of its memory."""
    kind, _ = inner_of(model.parameters)
    if type(kind) not in MEMORIES or memory_size == 0:
        return None
    quantity, times, over = MEMORIES[type(kind)]
    names = model.component.variables

    def of_side(side: str) -> dict[str, list[str]]:
        rows = {"times": times, "over": over}
        return {word: [name + side if name + side in names else name for name in row] for word, row in rows.items()}

    return {
        "numbers": int(np.size(kind.k_i)),
        "word": {"length": "deflection", "force": "force"}[quantity],
        "unit": typeset(unit_of(quantity, model.kind)),
        "limits": [of_side("_neg"), of_side("_pos")],
    }
