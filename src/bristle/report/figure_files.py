"""The figures of a report as files of their own, with their captions for LaTeX and the numbers that they draw."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from bristle.core.errors import InputError, InputWarning, place_in_own_code, told_by
from bristle.core.typography import typeset_sentence
from bristle.report.latex import as_latex, roman
from bristle.report.page import Plate, plates

if TYPE_CHECKING:
    from bristle.report.results import ResultsFolder

__all__ = ["CAPTIONS", "FOLDER", "captions", "figure_files"]

FOLDER = "figures"
CAPTIONS = "captions.tex"
FOR_LATEX, NUMBERS = ("pdf", "png"), "csv"
HEAD = r"""% The figures of a report of bristle, with their captions. In the preamble of your document:
%   \usepackage{graphicx}
%   \graphicspath{{figures/}}  % where they lie
%   \input{figures/captions}
% Then each has a command. Its figure is as wide as the page; with [figure] as wide as one column.
"""
WITHOUT_FILES = "% pdflatex takes figures in pdf or png: write them with --format pdf.\n"


@contextmanager
def figure_files(folder: ResultsFolder | None, formats: Iterable[str] | None) -> Iterator[None]:
    """Write each figure that is drawn for a report in this block into a folder of results; as csv the numbers that it draws."""
    endings = tuple(dict.fromkeys(str(ending) for ending in formats or ()))
    if folder is None and endings:
        raise InputError("needs a folder to write into", path="--format", mend="Add --out DIR")
    with plates() as collected:
        yield
    if folder is None:
        return
    written = [plate for plate in collected if _is_written(folder, plate, endings)]
    drawn = [ending for ending in endings if ending != NUMBERS]
    if drawn and written:
        folder.write(f"{FOLDER}/{CAPTIONS}", captions(written, drawn))


def _is_written(folder: ResultsFolder, plate: Plate, endings: Sequence[str]) -> bool:
    """Write a figure as files; return whether that was done, which one of a user's own may prevent for itself."""
    try:
        for ending in endings:
            if ending == NUMBERS:
                _write_numbers(folder, plate)
            else:
                _write_figure(folder, plate, ending)
    except OSError:
        raise  # no room on the disk, and no fault of the figure
    except (Exception, SystemExit) as error:  # (what a user's code may raise has no common type)
        if not plate.own:
            raise
        reason = f"{type(error).__name__}: {told_by(error)}".rstrip(": ")
        warnings.warn(
            f"{place_in_own_code(error) or plate.name}: the figure {plate.name} is not written as a file: {reason}",
            InputWarning,
            stacklevel=2,
        )
        return False
    return True


def _write_figure(folder: ResultsFolder, plate: Plate, form: str) -> None:
    from bristle.figures import figure_file, fits_as_png

    if form == "png" and not fits_as_png(plate.figure):
        warnings.warn(f"the figure {plate.name} would have too many pixels as png, and is written as pdf", InputWarning, stacklevel=2)
        form = "pdf"
    folder.write(f"{FOLDER}/{plate.name}.{form}", figure_file(plate.figure, form, plate.alternative))


def _write_numbers(folder: ResultsFolder, plate: Plate) -> None:
    from bristle.figures import as_csv, numbers_of

    panels = numbers_of(plate.figure)
    for number, panel in enumerate(panels, 1):
        behind = f"-panel-{number}" if len(panels) > 1 else ""
        folder.write(f"{FOLDER}/{plate.name}{behind}.csv", as_csv(panel))


def captions(collected: Sequence[Plate], formats: Sequence[str] = FOR_LATEX) -> str:
    """Return the figures for a document of LaTeX: a command for each, with its caption and its label."""
    return "\n".join([HEAD + ("" if set(formats) & set(FOR_LATEX) else WITHOUT_FILES), *map(_command, collected)])


def _command(plate: Plate) -> str:
    # A name of a command has letters only.
    name = re.sub(r"\d+", lambda digits: roman(int(digits[0])), plate.name)
    letters = re.sub(r"[^A-Za-z]", "", name)
    return rf"""\newcommand{{\bristle{letters}}}[1][figure*]{{%
  \begin{{#1}}
    \centering
    \includegraphics[width=\linewidth]{{{plate.name}}}
    \caption[{{{as_latex(plate.alternative)}}}]{{{as_latex(typeset_sentence(plate.caption))}}}
    \label{{fig:{plate.name}}}
  \end{{#1}}}}
"""
