"""Options that several commands share."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

if TYPE_CHECKING:
    from bristle.core.content import Origin
    from bristle.figures import ReportFigure

__all__ = [
    "LOG_FILE",
    "AllowCode",
    "AxisFile",
    "AxisFiles",
    "Data",
    "FigureFiles",
    "Figures",
    "Force",
    "Formats",
    "Json",
    "Out",
    "OwnFigures",
    "Readers",
    "SizeLimit",
    "bytes_asked",
    "folder_named",
    "own_figures",
    "own_readers",
]

LOG_FILE = (
    "text, traces of TwinCAT, LabVIEW and SINUMERIK, JSON, MAT, TDMS, Parquet, HDF5, NPZ, MF4 or MCAP; FILE::TABLE names a table in it."
)


class Format(StrEnum):
    """A format of figures."""

    svg = "svg"
    pdf = "pdf"
    png = "png"


class Numbers(StrEnum):
    """A format of the numbers of figures."""

    csv = "csv"


def folder_named(text: str | Path) -> Path:
    """Return the folder for results; an empty name, as of a variable that is not set, is none."""
    if isinstance(text, str) and not text.strip():
        raise typer.BadParameter("the name of the folder is empty: name a new one, or leave the option away")
    return Path(text)


def bytes_asked(text: str | None) -> int:
    """Return a size that a person typed, in bytes; the usual limit where none was typed."""
    from bristle.core.content import SIZE_LIMIT, size_of

    return SIZE_LIMIT if text is None else size_of(text, "--size-limit")


def own_readers(files: list[Path] | None) -> AbstractContextManager[None]:
    """Return while which logs of formats of a person's own are read, too; naming their code allows it."""
    if not files:
        return nullcontext()
    from bristle.core.content import content_of
    from bristle.files.permission import CODE_LIMIT, allow
    from bristle.files.user_model import load_reader_file
    from bristle.logs.formats import reading

    contents = [content_of(file, limit=CODE_LIMIT) for file in files]
    formats = [load_reader_file(content) for content in contents]
    for content in contents:
        allow(content)
    return reading(*formats)


class OwnFigures(NamedTuple):
    """Figures of a person's own, and the files that define them."""

    figures: tuple[ReportFigure, ...] = ()
    origins: tuple[Origin, ...] = ()


def own_figures(files: list[Path] | None, command: str, *, has_folder: bool) -> OwnFigures:
    """Return the figures that files of a person's own define, and those files; naming their code allows it."""
    if not files:
        return OwnFigures()
    from bristle.core.content import content_of
    from bristle.core.errors import InputError
    from bristle.figures.own import load_figure_file, refuse_unfit
    from bristle.files.permission import CODE_LIMIT, allow

    if not has_folder:
        raise InputError("needs a folder to write into", path="--figure", mend="Add --out DIR")
    contents = [content_of(file, limit=CODE_LIMIT) for file in files]
    figures = tuple(load_figure_file(content) for content in contents)
    for content in contents:
        allow(content)
    for figure, file in zip(figures, files, strict=True):
        refuse_unfit(figure, command, figures, str(file))
    return OwnFigures(figures, tuple(content.origin for content in contents))


AxisFile = Annotated[Path | None, typer.Option("--axis", metavar="AXIS.toml", help="The file that describes the axis.")]
AxisFiles = Annotated[
    list[Path] | None,
    typer.Option("--axis", metavar="AXIS.toml", help="The file that describes the axis; one for all logs, or each its own."),
]
Out = Annotated[Path | None, typer.Option("--out", metavar="DIR", parser=folder_named, help="Write the results into this new folder.")]
Force = Annotated[bool, typer.Option("--force", help="Replace results that are in DIR already.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
AllowCode = Annotated[bool, typer.Option("--allow-code", help="Run models of your own that a file names. Read their code first.")]
SizeLimit = Annotated[str | None, typer.Option("--size-limit", metavar="SIZE", help="Largest log, such as '2 GB'; 512 MiB by default.")]
Readers = Annotated[
    list[Path] | None,
    typer.Option("--reader", metavar="READER.py", help="A reader of your own for logs of another format; may be repeated."),
]
Formats = Annotated[
    list[Format] | None,
    typer.Option(
        "--format",
        metavar="svg|pdf|png",
        case_sensitive=False,
        help="Write each figure into DIR/figures too, to be published; may be given several times.",
    ),
]
Data = Annotated[
    Numbers | None,
    typer.Option("--data", metavar="csv", case_sensitive=False, help="Write the numbers that each figure draws into DIR/figures."),
]
FigureFiles = Annotated[
    list[Path] | None, typer.Option("--figure", metavar="FIGURE.py", help="A figure of your own for the report; may be repeated.")
]
Figures = tuple[list[Format] | None, Numbers | None]
"""How figures are asked for as files: formats, and the format of their numbers."""
