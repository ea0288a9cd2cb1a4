"""The contract of a report figure, built-in or a user's: drawings of small results for both kinds of axis."""

from __future__ import annotations

import copy
import sys
from collections.abc import Callable, Collection, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.contract import Check, Fact, UnmetError, outcomes
from bristle.core import KINDS, Kind, cached_property, unit_of
from bristle.engine import interpreted
from bristle.files import Sources, experiment_from
from bristle.identification import identify
from bristle.logs import Log
from bristle.prediction import predict
from bristle.prediction.comparison import compare
from bristle.report.apps import part
from bristle.simulation import simulate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bristle.report.figures.report_figure import Facts, ReportFigure

SAMPLES, STEP = 6000, 1e-3  # of the synthetic log [s]
DRAWS = 40  # of the study
FORMS = ("svg", "pdf", "png")
ADVICE = "Draw the given results with bristle.report.figures.style.panels, and return its figure"


@cache
def _example(kind: Kind, name: str) -> Any:
    return EXAMPLES[name](kind)


def example_facts(kind: Kind, names: Collection[str] = ()) -> Facts:
    """Return small results of a synthetic axis of this kind, as in reports: all of them, or those of some names."""
    return {name: _example(kind, name) for name in EXAMPLES if name in names or not names}


def _log(kind: Kind, seed: int, off: float) -> Any:
    """Return a log of one motion with a constant following error while it slides [m or rad]."""
    t, noise = STEP * np.arange(SAMPLES), np.random.default_rng(seed).normal(size=(2, SAMPLES))
    reference = 0.02 * np.sin(3.0 * t) + 0.01 * np.sin(12.0 * t)
    velocity = np.gradient(reference, t)
    effort = (
        12.0 * np.gradient(velocity, t) + 5.0 * np.sign(velocity) + 80.0 * velocity + 0.2 * noise[0]
    )
    columns = {
        "time": t,
        "reference": reference,
        "position": reference - off * np.sign(velocity) + 1e-6 * noise[1],
        "effort": effort,
    }
    return Log.from_columns(columns, kind=kind)


def _experiment(kind: Kind) -> Any:
    """Return a loop with and without friction feedforward."""
    friction = {"model": "coulomb_viscous", "F_C": 5.0, "F_v": 80.0}
    described = {
        "schema": 1,
        "kind": kind,
        "name": "example",
        "plant": {"model": "inertia", "M": 12.0},
        "friction": friction,
        "controller": {
            "model": "cascade",
            "k_p": 40.0,
            "k_v": 2000.0,
            "feedforward": {"friction": friction},
        },
        "sensor": {"resolution": 1e-6},
        "reference": {"model": "sine", "amplitude": 0.01, "frequency": 2.0},
        "run": {"duration": 1.25, "sample_time": STEP, "settle": 0.25},
        "compare": {"uncompensated": {"controller": {"feedforward": {"friction": "none"}}}},
    }
    return experiment_from(described, Path("example.toml"), Sources(Path()))


def _study(kind: Kind) -> Any:
    """Return the runs of a study in the form of its folder."""
    force, length = (unit_of(quantity, kind) for quantity in ("force", "length"))
    columns = {
        "run": {"role": "run", "unit": ""},
        "friction.F_C": {"role": "drawn", "unit": force},
        "following_error.rms": {
            "role": "metric",
            "unit": length,
            "description": "following error, root mean square",
        },
        "status": {"role": "run", "unit": ""},
        "reason": {"role": "run", "unit": ""},
    }
    described = {
        "name": "example",
        "kind": kind,
        "runs": DRAWS,
        "draws": DRAWS,
        "seed": 1,
        "sampling": "latin_hypercube",
        "grid": {},
        "sobol_indices": False,
        "metrics": ["following_error.rms"],
        "columns": columns,
    }
    level = np.random.default_rng(1).normal(5.0, 0.5, DRAWS)
    numbers = {"run": np.arange(DRAWS), "friction.F_C": level, "following_error.rms": 1e-6 * level}
    return part("runs")(
        described, numbers | {"status": np.full(DRAWS, "ok"), "reason": np.full(DRAWS, "")}
    )


EXAMPLES: dict[str, Callable[[Kind], Any]] = {
    "identification": lambda kind: identify(
        _example(kind, "log"), "viscous,coulomb_viscous", draws=0
    ),
    "log": lambda kind: _log(kind, 1, 0.0),
    "simulation": lambda kind: interpreted()(simulate)(_experiment(kind)),
    "prediction": lambda kind: predict(
        _example(kind, "identification").best.plant,
        _example(kind, "identification").best.friction,
        _example(kind, "log"),
        None,
        "inverse",
    ),
    "design": lambda kind: interpreted()(part("design"))(_experiment(kind)),
    "comparison": lambda kind: compare(
        [(_log(kind, 1, 2e-5), None)], [(_log(kind, 2, 1e-5), None)]
    ),
    "study": _study,
}


def check_figure(figure: ReportFigure) -> list[Check]:
    """Run the contract suite on a figure of a user's own.

    Parameters
    ----------
    figure : ReportFigure
        The figure.

    Returns
    -------
    list of Check
        One for each demand, in order; if the figure cannot be drawn, the others are skipped.
    """
    return outcomes(FIGURE_CHECKS, _Trial(figure), FORM, ADVICE)


class _Trial:
    """A figure, and its drawings for each kind of axis."""

    def __init__(self, figure: ReportFigure) -> None:
        self.figure, self.takes = figure, (*figure.needs, *figure.may_take)

    @cached_property
    def drawn(self) -> Mapping[Kind, Figure]:
        """The figures, by kind of axis."""
        return {kind: self.draw(kind) for kind in KINDS}

    def draw(self, kind: Kind) -> Figure:
        """Draw the figure again for this kind of axis."""
        from bristle.report.figures.own import draw_own

        return draw_own(self.figure, example_facts(kind, self.takes))

    def refuse(self, faults_of: Callable[[Figure], list[str]], advice: str) -> None:
        """Refuse the first fault in the drawings."""
        for kind, drawing in self.drawn.items():
            for fault in faults_of(drawing):
                raise UnmetError(f"{fault} ({kind} axis)", advice)


def described_figure(trial: _Trial) -> Fact:
    """Give a title, a caption, and a description for people who cannot see the figure."""
    for text in ("title", "alternative"):
        if "\n" in getattr(trial.figure, text).strip():
            raise UnmetError(f"{text} has several lines", "Write it in one line")
    if not str(trial.figure.caption).rstrip().endswith((".", "!", "?")):
        raise UnmetError("the caption is not a sentence", "Describe the content in whole sentences")
    return Fact(f"takes {', '.join(trial.figure.needs)}")


def draws_each_kind(trial: _Trial) -> Fact:
    """Draw the results of both kinds of axis without changing them."""
    return Fact(f"{sum(len(drawing.axes) for drawing in trial.drawn.values())} panels")


def shows_numbers(trial: _Trial) -> Fact:
    """Show numbers: lines, points or areas in the units of the axes, which are also written as CSV."""
    from bristle.report.figures import numbers_of

    counts = {
        kind: sum(
            int(np.isfinite(stroke).all(axis=1).sum())
            for panel in numbers_of(drawing)
            for _, drawn in panel.drawn
            for stroke in drawn.strokes
        )
        for kind, drawing in trial.drawn.items()
    }
    for kind, count in counts.items():
        if count < 2:
            raise UnmetError(
                f"the drawing is empty ({kind} axis)", "Plot into the axes of the returned figure"
            )
    return Fact(f"{sum(counts.values())} points")


def labelled_axes(trial: _Trial) -> Fact:
    """Label each axis with its quantity and its unit, which depends on the kind of axis."""
    from bristle.report.figures.legibility import unlabelled_axes

    trial.refuse(
        unlabelled_axes, "Use scale.label(word) of bristle.report.figures.style: Position [mm]"
    )
    return Fact()


def legible_texts(trial: _Trial) -> Fact:
    """Let no texts overlap or leave the figure."""
    from bristle.report.figures.legibility import illegible_texts

    trial.refuse(
        illegible_texts, "Give style.panels more height or a wider margin, or shorten the text"
    )
    return Fact()


def same_figure_twice(trial: _Trial) -> Fact:
    """Draw the same figure again, to the byte."""
    from bristle.report.figures import inline_svg

    first, again = (
        inline_svg(drawing, "trial", "")
        for drawing in (trial.drawn[KINDS[0]], trial.draw(KINDS[0]))
    )
    if first != again:
        raise UnmetError(
            "the second drawing differs", "Draw no random number, no date, and no unordered set"
        )
    return Fact(f"{len(first)} bytes")


def saved_in_each_form(trial: _Trial) -> Fact:
    """Can be saved in every format for publication."""
    from bristle.report.figures import figure_file

    sizes = {
        form: len(figure_file(trial.drawn[KINDS[0]], form, trial.figure.title)) for form in FORMS
    }
    return Fact(", ".join(f"{form} {size} bytes" for form, size in sizes.items()))


def nothing_left_open(trial: _Trial) -> Fact:
    """Close every figure: pyplot keeps its figures until they are closed."""
    from bristle.report.figures import style

    before = _open_figures()
    style.styled(trial.figure.draw)(
        *copy.deepcopy(trial.figure.arguments(example_facts(KINDS[0], trial.takes)))
    )
    left = _open_figures() - before
    if left:
        for number in left:
            sys.modules["matplotlib.pyplot"].close(number)
        raise UnmetError(
            "pyplot keeps the figure",
            "Make it with bristle.report.figures.style.panels, not with pyplot",
        )
    return Fact()


def _open_figures() -> set[int]:
    pyplot = sys.modules.get("matplotlib.pyplot")
    return set() if pyplot is None else set(pyplot.get_fignums())


FORM = (described_figure, draws_each_kind)
FIGURE_CHECKS = (
    *FORM,
    shows_numbers,
    labelled_axes,
    legible_texts,
    same_figure_twice,
    saved_in_each_form,
    nothing_left_open,
)
