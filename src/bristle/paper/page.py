"""The report of the paper: each figure beside what the paper says, what was found, and why it differs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from bristle.paper.equations import EQUATIONS
from bristle.paper.errata import ERRATA, KINDS
from bristle.paper.front import paper_front, paper_ruling
from bristle.paper.reproduced import Reproduced
from bristle.report.page import Picture, picture, render
from bristle.report.table import Table

__all__ = ["claim_table", "equation_table", "paper_report", "paper_summary"]

TITLE = "Pre-sliding friction control using the sliding mode controller with hysteresis friction compensator"
BANNER = "The rig in these figures is simulated; nothing here was measured on a machine."
RIG = (
    "The rig is thirty spring-slider elements with Stribeck limits, larger forward than backward, that scatter from "
    "reversal to reversal. The compensator called identified is of the same kind, eighteen elements without these "
    "three; the others are not."
)
SIMULATED = "The rig is simulated."


class Section(NamedTuple):
    """A figure of the report with what belongs to it."""

    reproduced: Reproduced
    figure: Picture
    extras: list[Picture]


def claim_table(figures: Sequence[Reproduced]) -> Table:
    """Return what became of the claims of the paper, figure by figure."""
    rows = [(str(figure.number), figure.words.title, figure.words.claim, figure.verdict) for figure in figures]
    return Table("What the paper claims, and what became of it", ("Figure", "Shows", "Claim", "Here"), rows)


def equation_table() -> Table:
    """Return the equations of the paper: how each stands, and what computes it."""
    rows = [(f"({equation.number})", equation.title, equation.stands, equation.file, equation.run) for equation in EQUATIONS]
    return Table("The equations of the paper", ("Equation", "What", "Here", "Computed by", "Run"), rows)


def paper_report(figures: Sequence[Reproduced], *, command: str, provenance: Mapping[str, str]) -> str:
    """Return the report as one HTML page.

    Parameters
    ----------
    figures : sequence of Reproduced
        The figures.
    command : str
        The command that repeats it.
    provenance : mapping of str to str
        Versions, files, checksums.
    """
    return render(
        "paper.html",
        provenance=provenance,
        command=command,
        banner=BANNER,
        title=TITLE,
        rig=RIG,
        front=paper_front(figures),
        claims=claim_table(figures),
        sections=[_section(figure) for figure in figures],
        equations=equation_table(),
        errata=Table(
            "What is printed, what is right, and where that is tested. "
            + " ".join(f"{kind.capitalize()}: {meaning[0].lower()}{meaning[1:]}" for kind, meaning in KINDS.items()),
            ("Place", "Kind", "As printed", "Correct", "Test"),
            [(erratum.location, erratum.kind, erratum.printed, erratum.correct, erratum.test.partition("::")[2]) for erratum in ERRATA],
        ),
    )


def _section(figure: Reproduced) -> Section:
    words, file = figure.words, f"figure-{figure.number:02d}"
    drawn = picture(
        f"paper-{figure.number}",
        figure.draw,
        words.alternative,
        f"Figure {figure.number}. {words.alternative}.",
        file=file,
        published=" ".join([f"{words.title}.", f"{words.alternative}.", *figure.found, SIMULATED]),
    )
    extras = [
        picture(f"paper-{figure.number}-{name}", draw, alternative, caption, file=f"{file}-{name}", published=f"{caption} {SIMULATED}")
        for name, (draw, alternative, caption) in figure.extras.items()
    ]
    return Section(figure, drawn._replace(id=f"fig-{figure.number}"), extras)


def paper_summary(figures: Sequence[Reproduced], *, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return the figures in numbers, in SI: travels of the table in m, torques of the screw in N*m.

    Parameters
    ----------
    figures : sequence of Reproduced
        The figures.
    provenance : mapping of str to str
        Versions, files, checksums.
    """
    return {
        "paper": TITLE,
        "verdict": paper_ruling(figures).as_data(),
        "figures": {
            str(figure.number): {
                "title": figure.words.title,
                "claim": figure.words.claim,
                "verdict": figure.verdict,
                "found": figure.found,
                "numbers": figure.numbers,
                "experiment": figure.origin.name,
            }
            for figure in figures
        },
        "provenance": provenance,
    }
