"""Options shared by several commands, and the objects behind them: folders, figures, readers, user code."""

from __future__ import annotations

import inspect
import os
import re
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import MISSING, dataclass, fields, is_dataclass
from enum import StrEnum
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, get_type_hints

import typer
from typer.core import TyperCommand

from bristle.cli.terminal import complain, progress, show

if TYPE_CHECKING:
    from bristle.core import Content, Experiment, Origin
    from bristle.report.figures import ReportFigure
    from bristle.report.table import Table

LOG_FILE = "a text file (also from TwinCAT or LabVIEW), or a format that bristle log --help lists. FILE::TABLE selects one table of a file."
SEPARATORS = f"{os.sep}{os.altsep or ''}"
SIZE_SETTING = "BRISTLE_SIZE_LIMIT"


class Format(StrEnum):
    """Format of figures, or of the numbers behind them."""

    svg = "svg"
    pdf = "pdf"
    png = "png"
    csv = "csv"


class Listing(TyperCommand):
    """Command whose help shows a list above its example. The list is made on request."""

    heads: tuple[str, str]
    rows: Callable[[], list[tuple[str, str]]]

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Write the list above the example."""
        with formatter.section(f"{self.heads[0]}s"):
            formatter.write_dl(self.rows())
        super().format_epilog(ctx, formatter)


def folder_named(text: str | Path) -> Path:
    """Return the folder for results. Refuse an empty name, such as that of an unset variable."""
    if isinstance(text, str) and not text.strip():
        raise typer.BadParameter(
            "the name of the folder is empty. Name a new folder, or leave the option out"
        )
    return Path(text)


def dir_option(flag: str, help: str) -> Any:
    """Return an option that names a folder."""
    return typer.Option(flag, metavar="DIR", parser=folder_named, help=help)


AxisFile = Annotated[Path | None, typer.Option("--axis", metavar="AXIS.toml", help="Axis file.")]
AxisFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--axis", metavar="AXIS.toml", help="Axis file: one for all logs, or one per log."
    ),
]
Out = Annotated[Path | None, dir_option("--out", "Write the results to this new folder.")]
Force = Annotated[bool, typer.Option("--force", help="Replace existing results in DIR.")]
Json = Annotated[bool, typer.Option("--json", help="Print only one JSON object.")]
Quiet = Annotated[
    bool,
    typer.Option(
        "--quiet", "-q", help="Print only a verdict and warnings: no progress, no tables."
    ),
]
Verbose = Annotated[
    bool, typer.Option("--verbose", "-v", help="Print all tables, warnings and notes.")
]
AllowCode = Annotated[
    bool,
    typer.Option(
        "--allow-code",
        help="Allow the Python models named in the input file to run. Read their code first.",
    ),
]
Readers = Annotated[
    list[Path] | None,
    typer.Option(
        "--reader",
        metavar="READER.py",
        help="Python file with your reader for another log format; repeatable.",
    ),
]
Formats = Annotated[
    list[Format] | None,
    typer.Option(
        "--format",
        metavar="svg|pdf|png|csv",
        case_sensitive=False,
        help="Also write each figure, for publication, or its numbers (csv) to DIR/figures; repeatable.",
    ),
]
FigureFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--figure",
        metavar="FIGURE.py",
        help="Python file with your figure for the report; repeatable.",
    ),
]


@dataclass(frozen=True)
class Output:
    """Options for the output of a command."""

    context: typer.Context
    out: Out = None
    formats: Formats = None
    force: Force = False
    as_json: Json = False
    quiet: Quiet = False

    @property
    def command(self) -> str:
        """The command line, as in the results."""
        return self.context.obj

    @contextmanager
    def opened(
        self, words: str, reads: Iterable[Any] = (), *, draws: bool = True
    ) -> Iterator[tuple[Any, Callable[[float, str], None]]]:
        """Give the folder of results, or None without --out, and the callback for progress."""
        if self.out and draws:
            # A broken matplotlib configuration ends a command before its work.
            import_module("bristle.report.figures")
        from bristle.files import results_folder
        from bristle.report.results import figure_files

        if self.out:
            place = results_folder(self.out, force=self.force, reads=list(reads))
        else:
            place = nullcontext()
        with (
            place as folder,
            progress(words, quiet=self.quiet) as report,
            figure_files(folder, self.formats),
        ):
            yield folder, report

    def tell(
        self,
        summary: Any,
        *parts: str | Table | None,
        warnings: Iterable[str] = (),
        files: str = "",
    ) -> None:
        """Print a summary as JSON, or as paragraphs, tables and warnings. Report the folder of the results."""
        if self.as_json:
            print_json(summary)
        else:
            if not self.quiet:
                show(*parts)
            for warning in warnings:
                complain(warning)
        if self.out and not self.quiet:
            wrote = f"wrote {self.out}; open {self.out / 'report.html'} in a browser"
            if files:
                wrote = f"wrote {self.out}: {files}"
            complain(wrote)


def print_json(data: Any) -> None:
    """Write plain data as one JSON object to the standard output."""
    from bristle.files import as_json

    sys.stdout.write(as_json(data))


def as_command(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a command with one option for each field of its option groups."""
    hints = get_type_hints(function, include_extras=True)
    groups = {}
    parameters = {}
    for name, parameter in inspect.signature(function).parameters.items():
        group = hints[name]
        if is_dataclass(group):
            groups[name] = group
            of_group = get_type_hints(group, include_extras=True)
            options = {field.name: (of_group[field.name], field.default) for field in fields(group)}
        else:
            options = {name: (group, parameter.default)}
        for option, (kind, default) in options.items():
            if default is MISSING:
                default = inspect.Parameter.empty
            parameters[option] = inspect.Parameter(
                option, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind
            )

    def command(**values: Any) -> Any:
        grouped = {
            name: group(**{field.name: values[field.name] for field in fields(group)})
            for name, group in groups.items()
        }
        arguments = values | grouped
        return function(
            **{name: arguments[name] for name in inspect.signature(function).parameters}
        )

    command.__doc__ = function.__doc__
    command.__name__ = function.__name__
    command.__annotations__ = {name: parameter.annotation for name, parameter in parameters.items()}
    command.__signature__ = inspect.Signature(list(parameters.values()))  # type: ignore[attr-defined]
    return command


def size_limit() -> int:
    """Return the largest size of a log [byte], from the environment or by default."""
    from bristle.core import SIZE_LIMIT, size_of

    text = os.environ.get(SIZE_SETTING)
    if text:
        return size_of(text, SIZE_SETTING)
    return SIZE_LIMIT


def refuse(options: dict[str, Any], message: str, mend: str = "") -> None:
    """Refuse the first given option of these."""
    option = next((option for option, value in options.items() if value), None)
    if option is not None:
        from bristle.core import InputError

        raise InputError(message, path=option, mend=mend or f"Leave {option} out")


def toml_content(file: Path | None) -> Any:
    """Return the contents of a TOML file, or None without a file."""
    from bristle.core import content_of
    from bristle.files import TOML_LIMIT

    if file is None:
        return None
    return content_of(file, limit=TOML_LIMIT)


def code_in(file: str | Path) -> Content:
    """Return the contents of a code file."""
    from bristle.core import content_of
    from bristle.files import CODE_LIMIT

    return content_of(file, limit=CODE_LIMIT)


def loaded_code(
    files: Sequence[str | Path], load: Callable[[Content], Any]
) -> tuple[list[Any], list[Content]]:
    """Load user code. Return its objects and the contents of the files; naming the files allows their code."""
    from bristle.files import allow

    contents = [code_in(file) for file in files]
    loaded = [load(content) for content in contents]
    for content in contents:
        allow(content)
    return loaded, contents


def own_readers(files: list[Path] | None) -> AbstractContextManager[None]:
    """Return a context in which user formats of logs can be read."""
    if not files:
        return nullcontext()
    from bristle.files import load_reader_file
    from bristle.logs import reading

    return reading(*loaded_code(files, load_reader_file)[0])


class OwnFigures(NamedTuple):
    """User figures, and the files that define them."""

    figures: tuple[ReportFigure, ...] = ()
    origins: tuple[Origin, ...] = ()


def own_figures(files: list[Path] | None, command: str, *, has_folder: bool) -> OwnFigures:
    """Return the figures in user files, and those files."""
    if not files:
        return OwnFigures()
    from bristle.report.figures.own import load_figure_file, refuse_unfit

    refuse({"--figure": not has_folder}, "needs a folder to write into", "Add --out DIR")
    figures, contents = loaded_code(files, load_figure_file)
    for figure, file in zip(figures, files, strict=True):
        refuse_unfit(figure, command, figures, str(file))
    return OwnFigures(tuple(figures), tuple(content.origin for content in contents))


def holds_own(name: str) -> bool:
    """Return whether a name contains a file of a model or a slot, ``my_model.py+asymmetry`` or ``lugre+my_slot.py``."""
    return any(part.endswith(".py") for part in name.split("+"))


def own_model(name: str, path: str) -> Any:
    """Return the friction model of a name that contains files. Run, test and then allow their code."""
    from bristle.contract import admit
    from bristle.files import allow, friction_named

    contents: list[Content] = []

    def read(file: str, path: str) -> Content:
        contents.append(code_in(file))
        return contents[-1]

    chosen = friction_named(name, path, read)
    admit(chosen)
    for content in contents:
        allow(content)
    return chosen


def experiment_in(
    path: Path, *, allow_code: bool, progress: Callable[[float, str], None] | None = None
) -> Experiment:
    """Return the experiment in a file after a test of its friction. Identify its models if their results are missing."""
    from bristle.core import content_of
    from bristle.files import TOML_LIMIT, read_experiment
    from bristle.report.prepared import prepare

    content = content_of(path, limit=TOML_LIMIT, path="experiment", what="an experiment file")
    for model in prepare(
        content, allow_code=allow_code, size_limit=size_limit(), progress=progress
    ):
        if model.best is None:
            complain(f"{model.name}: identified earlier; see {model.folder}")
        else:
            error = f"{model.best.name}, error {model.best.error_percent:.3g} %"
            complain(f"{model.name}: identified ({error}); see {model.folder / 'report.html'}")
    return read_experiment(content, allow_code=allow_code, size_limit=size_limit())


def command_text(arguments: Iterable[str], separators: str = SEPARATORS) -> str:
    """Return a printable command line, with files named without their folders.

    Examples
    --------
    >>> command_text(["identify", "/home/anna/axis 1.csv", "--axis=../x/axis.toml", "--cutoff", "100 Hz"])
    "bristle identify 'axis 1.csv' --axis=axis.toml --cutoff '100 Hz'"
    """
    words = [_without_folders(argument, separators) for argument in arguments]
    if not all(word.isprintable() for word in words):
        # The names of files are bytes, and the next program may decode them differently.
        from bristle.core import escaped

        words = [
            "".join(letter if letter.isprintable() else "?" for letter in escaped(word))
            for word in words
        ]
    return shlex.join(["bristle", *words])


def _without_folders(argument: str, separators: str) -> str:
    option, equals, value = argument.partition("=")
    if equals and option.startswith("--"):
        return f"{option}={_without_folders(value, separators)}"
    return ",".join(
        re.split(f"[{re.escape(separators)}]", part.rstrip(separators))[-1]
        for part in argument.split(",")
    )
