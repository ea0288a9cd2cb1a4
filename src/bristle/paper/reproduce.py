"""All figures of the paper, or some of them, from their experiments."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from bristle.core.errors import InputError
from bristle.paper.drift import figure_2, figure_3
from bristle.paper.experiment_files import EXPERIMENTS
from bristle.paper.loops import figure_5, figure_6
from bristle.paper.plane import figure_4
from bristle.paper.pre_sliding import figure_1, figure_8, figure_9, figure_10
from bristle.paper.reproduced import Reproduced
from bristle.paper.setting import Setting, read_setting

__all__ = ["FIGURES", "reproduce"]

Progress = Callable[[float, str], None]

CONTACTS: dict[int, Callable[[Setting], Reproduced]] = {
    1: figure_1, 2: figure_2, 3: figure_3, 4: figure_4, 5: figure_5, 6: figure_6, 8: figure_8, 9: figure_9,
    10: figure_10,
}  # fmt: skip
FIGURES = tuple(sorted(CONTACTS))


def reproduce(
    numbers: Iterable[int] = FIGURES, *, folder: Path = EXPERIMENTS, progress: Progress | None = None
) -> list[Reproduced]:
    """Reproduce figures of the paper.

    Parameters
    ----------
    numbers : iterable of int
        Which ones.
    folder : Path
        Where the experiments are: those of the package, or a changed copy of them.
    progress : callable, optional
        Called with the share done and what comes next.

    Returns
    -------
    list of Reproduced
        The figures in order.

    Raises
    ------
    InputError
        If the paper has no such figure, or an experiment does not fit.
    """
    wanted = sorted(set(numbers))
    for number in wanted:
        if number not in FIGURES:
            raise InputError("the paper has no such figure", path="--figure", value=number, allowed="1 to 14")
    found = []
    for index, number in enumerate(wanted):
        if progress is not None:
            progress(index / len(wanted), f"figure {number}")
        make = CONTACTS[number]
        if progress is not None and make is figure_6:
            make = partial(figure_6, progress=_within(progress, index, len(wanted)))
        found.append(make(read_setting(folder / f"fig_{number:02d}.toml")))
    return found


def _within(progress: Progress, index: int, count: int) -> Callable[[float], None]:
    """Return what the measuring of branches reports to, as a part of the whole."""
    return lambda share: progress((index + share) / count, "figure 6, measuring branches")
