"""The figures of a report as files of their own, with their captions and the numbers that they draw."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from bristle.core.errors import FaultWarning, InputError, InputWarning, place_in_own_code, told_by
from bristle.core.typography import typeset_sentence
from bristle.report.page import Plate, plates

if TYPE_CHECKING:
    from bristle.report.results import ResultsFolder

FOLDER = "figures"
CAPTIONS = "captions.txt"
NUMBERS = "csv"


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
    if written and set(endings) - {NUMBERS}:
        folder.write(f"{FOLDER}/{CAPTIONS}", captions(written))


def _is_written(folder: ResultsFolder, plate: Plate, endings: Sequence[str]) -> bool:
    """Write a figure as files; return whether that was done, which an error in its code may prevent."""
    from bristle.figures import as_csv, figure_file, fits_as_png, numbers_of

    try:
        for ending in endings:
            if ending == NUMBERS:
                panels = numbers_of(plate.figure)
                for number, panel in enumerate(panels, 1):
                    behind = f"-panel-{number}" if len(panels) > 1 else ""
                    folder.write(f"{FOLDER}/{plate.name}{behind}.csv", as_csv(panel))
                continue
            form = ending
            if ending == "png" and not fits_as_png(plate.figure):
                remark = f"the figure {plate.name} would have too many pixels as png, and is written as pdf"
                warnings.warn(remark, InputWarning, stacklevel=2)
                form = "pdf"
            folder.write(f"{FOLDER}/{plate.name}.{form}", figure_file(plate.figure, form, plate.alternative))
    except OSError:
        raise  # no room on the disk, and no fault of the figure
    except (Exception, SystemExit) as error:  # noqa: BLE001  (what a user's code may raise has no common type)
        reason = f"{type(error).__name__}: {told_by(error)}".rstrip(": ")
        remark = f"{place_in_own_code(error) or plate.name}: the figure {plate.name} is not written as a file: {reason}"
        warnings.warn(InputWarning(remark) if plate.own else FaultWarning(remark, error), stacklevel=2)
        return False
    return True


def captions(collected: Sequence[Plate]) -> str:
    """Return the figures by the names of their files, each with its caption below it."""
    return "\n".join(f"{plate.name}\n  {typeset_sentence(' '.join(plate.caption.split()))}\n" for plate in collected)
