"""The report of the paper: each figure beside what the paper says, what was found, and why it differs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from bristle.paper.equations import EQUATIONS
from bristle.paper.errata import ERRATA, KINDS
from bristle.paper.reproduced import Reproduced
from bristle.report.page import Picture, picture, render
from bristle.report.table import Table

__all__ = ["claim_table", "equation_table", "paper_report", "paper_summary"]

TITLE = "Pre-sliding friction control using the sliding mode controller with hysteresis friction compensator"
BANNER = (
    "The rig in these figures is simulated; nothing here was measured on a machine. It is thirty spring-slider "
    "elements with Stribeck limits, larger forward than backward, that scatter from reversal to reversal. The "
    "compensator called identified is of the same kind, eighteen elements without these three; the others are not."
)
SIMULATED = "The rig is simulated."


class Section(NamedTuple):
    """A figure of the report with what belongs to it."""

    one: Reproduced
    figure: Picture
    extras: list[Picture]


def claim_table(found: Sequence[Reproduced]) -> Table:
    """Return what became of the claims of the paper, figure by figure."""
    rows = [(str(one.number), one.words.title, one.words.claim, one.verdict) for one in found]
    return Table("What the paper claims, and what became of it", ("Figure", "Shows", "Claim", "Here"), rows)


def equation_table() -> Table:
    """Return the equations of the paper: how each stands, and what computes it."""
    rows = [(f"({one.number})", one.what, one.stands, one.file, one.run) for one in EQUATIONS]
    return Table("The equations of the paper", ("Equation", "What", "Here", "Computed by", "Run"), rows)


def paper_report(found: Sequence[Reproduced], *, command: str, provenance: Mapping[str, str]) -> str:
    """Return the report as one HTML page.

    Parameters
    ----------
    found : sequence of Reproduced
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
        claims=claim_table(found),
        sections=[_section(one) for one in found],
        equations=equation_table(),
        errata=Table(
            "What is printed, what is right, and where that is tested. "
            + " ".join(f"{kind.capitalize()}: {what[0].lower()}{what[1:]}" for kind, what in KINDS.items()),
            ("Place", "Kind", "As printed", "Correct", "Test"),
            [(one.place, one.kind, one.printed, one.correct, one.test.partition("::")[2]) for one in ERRATA],
        ),
    )  # fmt: skip


def _section(one: Reproduced) -> Section:
    file = f"figure-{one.number:02d}"
    drawn = picture(
        f"paper-{one.number}", one.draw, one.words.alternative, f"Figure {one.number}. {one.words.alternative}.",
        file=file, published=" ".join([f"{one.words.title}.", f"{one.words.alternative}.", *one.found, SIMULATED]),
    )  # fmt: skip
    extras = [
        picture(
            f"paper-{one.number}-{name}",
            draw,
            alternative,
            caption,
            file=f"{file}-{name}",
            published=f"{caption} {SIMULATED}",
        )
        for name, (draw, alternative, caption) in one.extras.items()
    ]
    return Section(one, drawn._replace(id=f"fig-{one.number}"), extras)


def paper_summary(found: Sequence[Reproduced], *, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return the figures in numbers, in SI: travels of the table in m, torques of the screw in N*m.

    Parameters
    ----------
    found : sequence of Reproduced
        The figures.
    provenance : mapping of str to str
        Versions, files, checksums.
    """
    return {
        "paper": TITLE,
        "figures": {
            str(one.number): {
                "title": one.words.title,
                "claim": one.words.claim,
                "verdict": one.verdict,
                "found": one.found,
                "numbers": one.numbers,
                "experiment": one.origin.name,
            }
            for one in found
        },
        "provenance": provenance,
    }
