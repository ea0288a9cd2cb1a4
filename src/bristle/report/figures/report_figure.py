"""A figure of a report: its inputs, its function and its texts; built-in or user-defined."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from matplotlib.figure import Figure

from bristle.report.figures.style import styled

Facts = Mapping[str, Any]  # results of a report, by name; None, or no entry, for missing results

# Inputs of user-defined figures, by the command of the report; some need a loop.
FACTS: dict[str, tuple[str, ...]] = {
    "identify": ("identification", "log", "simulation", "prediction"),
    "predict": ("prediction", "log"),
    "run": ("simulation",),
    "design": ("design",),
    "compare": ("comparison",),
    "study": ("study",),
}


@dataclass(frozen=True, kw_only=True)
class ReportFigure:
    """A figure of a report.

    Parameters
    ----------
    name : str
        File name: lower-case letters, digits and underscores.
    takes : str or tuple of str
        The results that `draw` takes, in its order. For a user-defined figure:
        ``"identification"``, an `Identification`; ``"simulation"``, a `SimulationResult`; ``"prediction"``, a
        `Prediction`; ``"log"``, a `Log`; ``"design"``, a `Design`; ``"comparison"``, a `Comparison`; ``"study"``, the
        `Runs` of a study.
    draw : callable
        Returns a `matplotlib.figure.Figure`, such as that of `bristle.report.figures.style.panels`.
    caption : str or callable
        Text below the figure, or a function of the same results that returns the text.
    alternative : str or callable
        Description for people who cannot see the figure, or a function of the same results that returns it.
    title : str
        Heading above a user-defined figure.
    may_take : tuple of str
        Further results that `draw` takes after the others; it receives None for a missing result.
    applies : callable or None
        Condition on these results for the figure to appear; by default, all its inputs must exist.
    """

    name: str
    takes: str | tuple[str, ...]
    draw: Callable[..., Figure]
    caption: str | Callable[..., str]
    alternative: str | Callable[..., str]
    title: str = ""
    may_take: tuple[str, ...] = ()
    applies: Callable[..., bool] | None = None

    @property
    def needs(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return (self.takes,) if isinstance(self.takes, str) else tuple(self.takes)

    def missing(self, facts: Facts) -> tuple[str, ...]:
        """Return the names of the inputs that a report lacks."""
        return tuple(name for name in self.needs if facts.get(name) is None)

    def arguments(self, facts: Facts) -> tuple[Any, ...]:
        """Return the inputs of the figure from the results of a report."""
        return tuple(facts.get(name) for name in (*self.needs, *self.may_take))

    def applies_to(self, facts: Facts) -> bool:
        """Return whether a report with these results has the figure."""
        return not self.missing(facts) and (
            self.applies is None or self.applies(*self.arguments(facts))
        )


FIGURES: dict[str, ReportFigure] = {}  # the figures of reports, by module and file name


def shown(
    name: str,
    takes: str | tuple[str, ...],
    alternative: str | Callable[..., str],
    caption: str | Callable[..., str] = "",
    *,
    draw: Callable[..., Figure] | None = None,
    may_take: tuple[str, ...] = (),
    applies: Callable[..., bool] | None = None,
) -> Callable[[Callable[..., Figure]], Callable[..., Figure]]:
    """Offer a function, in the style of all figures, as a figure of reports; `draw` takes it, and the results for its arguments."""

    def offered(function: Callable[..., Figure]) -> Callable[..., Figure]:
        drawn, key = styled(function), f"{function.__module__.rpartition('.')[2]}.{name}"
        given = drawn if draw is None else partial(draw, drawn)
        FIGURES[key] = ReportFigure(
            name=name,
            takes=takes,
            draw=given,
            caption=caption,
            alternative=alternative,
            may_take=may_take,
            applies=applies,
        )
        return drawn

    return offered
