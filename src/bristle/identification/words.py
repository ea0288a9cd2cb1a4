"""Numbers as people say them: a value with its unit, in three digits."""

from __future__ import annotations

import math

from bristle.core.variable import Kind, unit_of

__all__ = ["with_unit"]

PREFIXES = {-9: "n", -6: "u", -3: "m", 0: "", 3: "k", 6: "M"}


def with_unit(value: float, quantity: str, kind: Kind = "translational") -> str:
    """Return a value with its unit, with a prefix where the unit begins with a plain symbol.

    Parameters
    ----------
    value : float
        In SI of the kind of axis.
    quantity : str
        Generalised quantity, such as ``"length/time"``.
    kind : {"translational", "rotational"}
        The kind of axis.

    Examples
    --------
    >>> with_unit(0.02, "length/time"), with_unit(95.1089, "mass"), with_unit(7e-6, "length", "rotational")
    ('20 mm/s', '95.1 kg', '7 urad')
    """
    unit = unit_of(quantity, kind)
    if unit == "1":
        return f"{value:.3g}"
    if value == 0.0 or not math.isfinite(value) or unit.startswith(("kg", "1/", "K")):
        return f"{value:.3g} {unit}"
    exponent = 3 * math.floor(math.log10(abs(value)) / 3.0 + 1e-12)
    if unit.startswith(("m", "rad", "s")):
        exponent = min(exponent, 0)
    exponent = min(max(exponent, -9), 6)
    return f"{value / 10.0**exponent:.3g} {PREFIXES[exponent]}{unit}"
