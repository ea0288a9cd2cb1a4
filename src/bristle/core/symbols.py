"""Typeset names of parameters as symbols: F_C_pos becomes an F with the subscript C+."""

import re

from markupsafe import Markup, escape

NAMES = "alpha beta gamma delta epsilon zeta eta kappa lambda mu nu rho sigma tau phi psi omega"
# Letters by their names in code.
GREEK: dict[str, str] = dict(zip(NAMES.split(), "αβγδεζηκλµνρστφψω", strict=True))
SIDES = {"_pos": "+", "_neg": "\u2212"}
_ALONE = re.compile(rf"(?<!\w)(?:F([+\u2212])(?!\w)|({'|'.join(GREEK)}|[A-Za-z])(?= [±≈] ))")
_NAME = re.compile(
    rf"(?<![\w`])({'|'.join(GREEK)}|[A-Za-z])_([A-Za-z0-9]{{1,3}})(_pos|_neg)?(?![\w`+])"
)


def symbolic(text: str) -> Markup:
    """Escape text and typeset names of parameters as symbols, except in backticks.

    Examples
    --------
    >>> symbolic("F_C_pos and sigma_0 of stribeck_free")
    Markup('<i>F</i><sub>C+</sub> and <i>σ</i><sub>0</sub> of stribeck_free')
    """
    named = _NAME.sub(
        lambda name: (
            f"<i>{GREEK.get(name[1], name[1])}</i><sub>{name[2]}{SIDES.get(name[3], '')}</sub>"
        ),
        str(escape(text)),
    )
    return Markup(
        _ALONE.sub(
            lambda at: (
                f"<i>{GREEK.get(at[2], at[2])}</i>" if at[2] else f"<i>F</i><sub>{at[1]}</sub>"
            ),
            named,
        )
    )
