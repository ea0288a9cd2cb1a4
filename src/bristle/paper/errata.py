"""What in the paper cannot stand as printed, or not in every reading: what is right, and the test that shows it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple

from bristle.files.toml import read_toml
from bristle.report.latex import as_latex

Kind = Literal["misprint", "gap", "reading", "remark"]


class Erratum(NamedTuple):
    """One place of the paper."""

    kind: Kind
    location: str
    printed: str
    correct: str
    test: str


def errata_of(kind: Kind) -> list[Erratum]:
    """Return the errata of a kind, in the order of the paper."""
    return [erratum for erratum in ERRATA if erratum.kind == kind]


_DATA = read_toml(Path(__file__).with_suffix(".toml")).data
ERRATA = tuple(Erratum(**row) for row in _DATA["erratum"])
KINDS: dict[Kind, str] = _DATA["kinds"]


ERRATA_FILE = "errata.tex"
# For each column: its head, and its share of the width. A column that no erratum fills is left out.
COLUMNS = {"location": ("Place", 0.14), "kind": ("Kind", 0.12), "printed": ("As printed", 0.4), "correct": ("Correct", 0.34)}
HEAD = r"""% What in the source paper cannot stand as printed, or not in every reading. In your preamble:
%   \usepackage{array,longtable}
% and where the table is to stand: \input{errata}
"""


def errata_tex(errata: Sequence[Erratum] = ERRATA) -> str:
    """Return the errata as a table that goes on over pages, its head repeated on each."""
    columns = [name for name in COLUMNS if any(getattr(erratum, name, "") for erratum in errata)]
    total = sum(COLUMNS[name][1] for name in columns)
    widths = [
        rf">{{\raggedright\arraybackslash}}p{{\dimexpr {COLUMNS[name][1] / total:.3f}\linewidth-2\tabcolsep\relax}}" for name in columns
    ]
    kinds = " ".join(f"{kind.capitalize()}: {meaning[0].lower()}{meaning[1:]}" for kind, meaning in KINDS.items())
    heads = " & ".join(rf"\textbf{{{COLUMNS[name][0]}}}" for name in columns)
    rows = [" & ".join(as_latex(str(getattr(erratum, name, ""))) for name in columns) for erratum in errata]
    return "\n".join(
        [
            HEAD + r"\begin{longtable}{" + "\n  " + "\n  ".join(widths) + "}",
            rf"  \caption{{What the source paper prints, and what is right. {as_latex(kinds)}}}\label{{tab:errata}}\\",
            r"  \hline",
            rf"  {heads} \\ \hline",
            r"  \endfirsthead",
            r"  \hline",
            rf"  {heads} \\ \hline",
            r"  \endhead",
            r"  \hline",
            r"  \endlastfoot",
            # A bracket right behind the end of a row would be taken for its height.
            *(rf"  {{}}{row} \\[3pt]" for row in rows),
            r"\end{longtable}",
            "",
        ]
    )
