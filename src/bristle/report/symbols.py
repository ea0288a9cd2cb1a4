"""Names of parameters set as the symbols of equations: F_C_pos becomes an F with the subscript C+."""

from __future__ import annotations

import re

from markupsafe import Markup, escape

__all__ = ["symbolic"]

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "zeta": "ζ", "eta": "η", "kappa": "κ",
    "lambda": "λ", "mu": "µ", "nu": "ν", "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ", "psi": "ψ", "omega": "ω",
}  # fmt: skip
SIDES = {"_pos": "+", "_neg": "\u2212"}
_NAME = re.compile(rf"(?<![\w`])({'|'.join(GREEK)}|[A-Za-z])_([A-Za-z0-9]{{1,3}})(_pos|_neg)?(?![\w`+])")


def symbolic(text: str) -> Markup:
    """Return text, escaped, in which names of parameters are symbols; what stands in backticks is left alone.

    Examples
    --------
    >>> symbolic("F_C_pos and sigma_0 of stribeck_free")
    Markup('<i>F</i><sub>C+</sub> and <i>σ</i><sub>0</sub> of stribeck_free')
    """
    return Markup(_NAME.sub(_symbol, str(escape(text))))


def _symbol(match: re.Match[str]) -> str:
    base, below, side = match.groups()
    return f"<i>{GREEK.get(base, base)}</i><sub>{below}{SIDES.get(side, '')}</sub>"
