"""A figure of a report: what it takes, what draws it, and what a reader is told of it; ours, or a user's."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

Facts = Mapping[str, Any]  # what a report rests on, by name; None, or no entry, for what it has not

# What figures of a user's own may take, by the command whose report has it; some of it only where there is a loop.
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
        What it is called as a file: small letters, digits and underscores.
    takes : str or tuple of str
        The results that it is drawn from, in the order in which `draw` takes them. Of a user's own figure:
        ``"identification"``, an `Identification`; ``"simulation"``, a `SimulationResult`; ``"prediction"``, a
        `Prediction`; ``"log"``, a `Log`; ``"design"``, a `Design`; ``"comparison"``, a `Comparison`; ``"study"``, the
        `Runs` of a study.
    draw : callable
        Returns a `matplotlib.figure.Figure`, as `bristle.figures.style.panels` makes one.
    caption : str or callable
        What to see in it; where it depends on the results, what returns it from the same.
    alternative : str or callable
        What it is, for people who cannot see it; likewise.
    title : str
        The heading that a figure of a user's own stands under.
    may_take : tuple of str
        Further results, behind the others; None where there are none.
    applies : callable or None
        Whether it is drawn of these results; by default wherever all that it takes is there.
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
        """The names of what it takes."""
        return (self.takes,) if isinstance(self.takes, str) else tuple(self.takes)

    def missing(self, facts: Facts) -> tuple[str, ...]:
        """Return what it takes and a report has not."""
        return tuple(name for name in self.needs if facts.get(name) is None)

    def arguments(self, facts: Facts) -> tuple[Any, ...]:
        """Return what it is drawn from."""
        return tuple(facts.get(name) for name in (*self.needs, *self.may_take))

    def applies_to(self, facts: Facts) -> bool:
        """Return whether a report has it."""
        return not self.missing(facts) and (self.applies is None or self.applies(*self.arguments(facts)))
