"""The equations of the paper, (1) to (23): how each stands here, what computes it, what tests it, how to see it."""

from pathlib import Path
from typing import Literal, NamedTuple

from bristle.files import read_toml

Stands = Literal["as printed", "corrected", "completed"]


class Equation(NamedTuple):
    """One equation of the paper."""

    number: int
    title: str
    printed: str
    stands: Stands
    formula: str
    file: str
    test: str
    run: str
    gives: str = ""


_DATA = read_toml(Path(__file__).with_suffix(".toml")).data
EQUATIONS = tuple(Equation(**row) for row in _DATA["equation"])
SETUP = tuple(_DATA["setup"])  # lines of Python before those in `run`
