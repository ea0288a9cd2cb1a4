"""The equations of the paper, (1) to (23): their status, code, test, and a command that shows them."""

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
SETUP = tuple(_DATA["setup"])  # Python code before that in `run`
