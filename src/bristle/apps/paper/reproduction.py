"""All or some figures of the paper, from their experiments."""

from collections.abc import Callable, Iterable
from pathlib import Path

from bristle.apps.paper.drift import figure_2, figure_3
from bristle.apps.paper.following import figure_11, figure_12, figure_13, figure_14
from bristle.apps.paper.loops import figure_5, figure_6
from bristle.apps.paper.paths import figure_1, figure_8, figure_9, figure_10
from bristle.apps.paper.plane import figure_4
from bristle.apps.paper.reproduced import Reproduced
from bristle.apps.paper.setting import EXPERIMENTS, Setting, read_setting
from bristle.apps.paper.tracking import BEFORE, Sound, Tracked, figure_7
from bristle.core import InputError, Progress

CONTACTS: dict[int, Callable[[Setting], Reproduced]] = {
    1: figure_1,
    2: figure_2,
    3: figure_3,
    4: figure_4,
    5: figure_5,
    8: figure_8,
    9: figure_9,
    10: figure_10,
}
LOOPS: dict[int, Callable[[Tracked], Reproduced]] = {11: figure_11, 13: figure_13, 14: figure_14}
FIGURES = tuple(sorted({*CONTACTS, *LOOPS, 6, 7, 12}))
ALL_LOOPS = (*LOOPS, 12)


def reproduce(
    numbers: Iterable[int] = FIGURES,
    *,
    folder: Path = EXPERIMENTS,
    allow_code: bool = False,
    progress: Progress | None = None,
) -> list[Reproduced]:
    """Reproduce figures of the paper.

    Parameters
    ----------
    numbers : iterable of int
        Numbers of the figures.
    folder : Path
        Folder of the experiments: those of the package, or a changed copy.
    allow_code : bool
        Whether user models in the experiments may run without earlier permission.
    progress : callable, optional
        Called with the share of the work and the next step.

    Returns
    -------
    list of Reproduced
        The figures in order.

    Raises
    ------
    InputError
        If the paper has no such figure, or an experiment has unsuitable values.
    """
    distinct = sorted(set(numbers))
    for number in distinct:
        if number not in FIGURES:
            raise InputError(
                "the paper has no such figure", path="--figure", value=number, allowed="1 to 14"
            )
    figures = []
    tracked = Tracked(folder / "set_a.toml", allow_code)
    for index, number in enumerate(distinct):
        part = _part_of(progress, index / len(distinct), 1.0 / len(distinct), f"figure {number}")
        part(0.0, "")
        tracked.report = part
        setting = None
        if number not in ALL_LOOPS:
            setting = read_setting(folder / f"fig_{number:02d}.toml", allow_code=allow_code)
        if number == 12:  # first its own loop, then the additional loops
            tracked.report, at_loop, at_levels = (
                _part_of(part, third / 3.0, 1.0 / 3.0) for third in range(3)
            )
            loop = Tracked(folder / "set_c.toml", allow_code, (BEFORE,), at_loop)
            levels = Tracked(folder / "set_a_break_away.toml", allow_code, (), at_levels)
            figures.append(figure_12(tracked, Sound(loop, levels)))
        elif setting is None:
            figures.append(LOOPS[number](tracked))
        elif number == 6:
            figures.append(figure_6(setting, part))
        elif number == 7:
            figures.append(figure_7(tracked, setting))
        else:
            figures.append(CONTACTS[number](setting))
    return figures


def _part_of(progress: Progress | None, start: float, share: float, name: str = "") -> Progress:
    """Return the progress callback for a part of the work."""

    def report(completed: float, text: str) -> None:
        if progress is not None:
            progress(start + share * completed, ", ".join(filter(None, (name, text))))

    return report
