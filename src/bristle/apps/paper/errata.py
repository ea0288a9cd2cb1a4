"""Errors, gaps and remarks on the printed paper: the correction, and the test that proves it."""

from pathlib import Path
from typing import Literal, NamedTuple

from bristle.files import read_toml

Kind = Literal["misprint", "gap", "reading", "remark"]


class Erratum(NamedTuple):
    """One passage of the paper."""

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
