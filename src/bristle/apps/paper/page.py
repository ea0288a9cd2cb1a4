"""The report of the paper: each figure with the statement of the paper, the result, and the reason for any difference."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from markupsafe import Markup

from bristle.apps.paper.equations import EQUATIONS
from bristle.apps.paper.errata import ERRATA, KINDS
from bristle.apps.paper.reproduced import Reproduced, in_micrometres
from bristle.apps.paper.tracking import BEFORE, COMPENSATED, IN_PAPER, NAMES, PRINTED, with_spread
from bristle.report.cards import Card, Step
from bristle.report.compensation import change_text
from bristle.report.figures.loop_rows import errors_by_loop
from bristle.report.page import Block, Front, Picture, Ruling, Section, about, page_of, picture
from bristle.report.table import Table, length_text

HEADING = "The source paper, reproduced figure by figure"
STANDS = {
    "found": ("independent of the setup", "holds here, independently of the setup"),
    "built in": ("built into the rig", "follows from the construction of the rig"),
    "calibrated": ("calibrated", "holds here by calibration"),
    "found in part": ("holds in part, independent of the setup", "holds here in part"),
    "built in in part": (
        "one half independent, the other built into the rig",
        "holds here; one half is built into the rig",
    ),
    "refuted": ("does not hold", "does not hold here"),
}
"""Status of claims: in a list, and of a single claim."""
REPORTED = {BEFORE: "the paper, no compensator", COMPENSATED: "the paper, its compensator"}


def paper_ruling(figures: Sequence[Reproduced]) -> Ruling:
    """Return the number of claims that hold here, and the claims that fail or hold in part."""
    tested = [figure for figure in figures if figure.verdict != "shown"]
    if not tested:
        return Ruling("with_care", "The figure makes no testable claim")
    held = sum(figure.verdict == "found" for figure in tested)
    reasons = []
    for verdict, (stands, _) in STANDS.items():
        group = [
            f"{figure.words.short} ({figure.number})"
            for figure in tested
            if figure.verdict == verdict
        ]
        if group:
            reasons.append(f"{stands}: {len(group)}, {', '.join(group)}")
    words = f"{held} of {len(tested)} claims of the paper hold here, independently of the setup"
    if len(tested) == 1:
        words = f"Its claim {STANDS[tested[0].verdict][1]}"
    if held == len(tested):
        return Ruling("usable", words, tuple(reasons))
    if all(figure.verdict == "refuted" for figure in tested):
        return Ruling("no", words, tuple(reasons))
    return Ruling("with_care", words, tuple(reasons))


def paper_front(figures: Sequence[Reproduced]) -> Front:
    """Return the first page of the reproduced figures."""
    loop = next((figure for figure in figures if figure.number == 12), None)
    count = f"{len(figures)} figures"
    if len(figures) == 1:
        count = "1 figure"
    facts = about("simulated rig", count)
    step = Step.of("try your own axis: `bristle identify log.csv --axis axis.toml`")
    # The section of the claims has the reasons, which are long.
    front = Front(HEADING, facts, paper_ruling(figures)._replace(reasons=()), next=step)
    if loop is None:
        return front
    return front._replace(
        title=_title(loop),
        basis="(simulated rig)",
        cards=_cards(figures, loop),
        figures=[_picture(loop)],
    )


def _title(loop: Reproduced) -> str:
    """Return the following error without a compensator and with that of the paper."""
    peaks = loop.numbers["peak_to_peak"]
    change = change_text(
        peaks[BEFORE], peaks[PRINTED], partial(length_text, kind="translational"), "peak to peak"
    )
    return f"Compensator of the paper: {change}"


def _cards(figures: Sequence[Reproduced], loop: Reproduced) -> list[Card]:
    """Return the number of claims that hold, and the errors here, each with that of the paper."""
    tested = [figure for figure in figures if figure.verdict != "shown"]
    cards = [
        Card(
            "Claims that hold",
            f"{sum(figure.verdict == 'found' for figure in tested)} of {len(tested)}",
        )
    ]
    peaks = loop.numbers["peak_to_peak"]
    spreads = loop.numbers["peak_to_peak_spread"]
    for label, name, published in (
        ("No compensator", BEFORE, BEFORE),
        ("Its compensator", PRINTED, COMPENSATED),
    ):
        cards.append(
            Card(
                label,
                f"{with_spread(1e6 * peaks[name], 1e6 * spreads.get(name, 0.0))}\u00a0µm",
                f"paper: {1e6 * IN_PAPER[published]:.2f}\u00a0µm",
            )
        )
    return cards


def _picture(loop: Reproduced) -> Picture:
    """Return the following error of each loop, and that of the paper."""
    peaks, spreads = (loop.numbers[name] for name in ("peak_to_peak", "peak_to_peak_spread"))
    names = {name: NAMES.get(name, name) for name in peaks}
    best = min(peaks, key=peaks.get)
    by_label = ((names, peaks), (names, spreads), (REPORTED, IN_PAPER))
    bars = [
        {labels[name]: 1e6 * length for name, length in lengths.items()}
        for labels, lengths in by_label
    ]
    alternative = "Following error of each loop, peak to peak, and that of the paper"
    caption = f"The least: {in_micrometres(peaks[best], 2)}, {names[best]}."
    return picture(
        "paper-first",
        lambda: errors_by_loop(*bars, "Following error [µm], peak to peak"),
        alternative,
        caption,
        file="figure-00",
        published=f"{alternative}. {caption} {SIMULATED}",
    )


TITLE = "Pre-sliding friction control using the sliding mode controller with hysteresis friction compensator"
BANNER = "The rig in these figures is simulated; no data come from a machine."
RIG = (
    "The rig consists of thirty spring-slider elements with Stribeck limits that are larger forward than backward and "
    "scatter from reversal to reversal. The compensator named identified is of the same kind: eighteen elements without "
    "these three properties. The others are of other kinds."
)
SIMULATED = "The rig is simulated."
REBUILT = f"""{TITLE}: bristle rebuilds each figure as an experiment, compares it with the claim of the paper, and explains any
difference. The experiments are files: `bristle paper --write DIR` copies them, and `bristle paper --from DIR` runs your changed copies."""
PRINTED_EQUATIONS = """Each equation of the paper: whether it is correct as printed, and the code that computes it. The lines of Python
use the definitions at the beginning of docs/reference/equations.md, which has every equation in full."""
PRINTED_ERRORS = """Equations and statements of the paper that are wrong or ambiguous as printed, and remarks on others. Every correction
is tested."""


def claim_table(figures: Sequence[Reproduced]) -> Table:
    """Return the status of the claims of the paper, figure by figure."""
    rows = [
        (str(figure.number), figure.words.title, figure.words.claim, figure.verdict)
        for figure in figures
    ]
    return Table(
        "Claims of the paper, and their status here", ("Figure", "Shows", "Claim", "Here"), rows
    )


def paper_report(
    figures: Sequence[Reproduced], *, command: str, provenance: Mapping[str, str]
) -> str:
    """Return the report as one HTML page; `command` is the command line that writes it again."""
    front = paper_front(figures)
    wide = ("long shared",)  # classes of a table
    equations = Table(
        "The equations of the paper",
        ("Equation", "Title", "Here", "Computed by", "Run"),
        [
            (f"({equation.number})", equation.title, equation.stands, equation.file, equation.run)
            for equation in EQUATIONS
        ],
    )
    errata = Table(
        "Printed text, correction, and test.  "
        + " ".join(
            f"{kind.capitalize()}: {meaning[0].lower()}{meaning[1:]}"
            for kind, meaning in KINDS.items()
        ),
        ("Place", "Kind", "As printed", "Correct", "Test"),
        [
            (
                erratum.location,
                erratum.kind,
                erratum.printed,
                erratum.correct,
                erratum.test.partition("::")[2],
            )
            for erratum in ERRATA
        ],
    )
    claims = [REBUILT, RIG, Block("items", paper_ruling(figures).reasons), claim_table(figures)]
    sections = [
        Section("claims", "Claims of the paper", claims, "Claims"),
        *map(_section, figures),
        Section("equations", "Equations", [PRINTED_EQUATIONS, Block("table", equations, wide)]),
        Section("errata", "Errata", [PRINTED_ERRORS, Block("table", errata, wide)]),
    ]
    return page_of(front, sections, command=command, provenance=provenance, banner=BANNER)


def _section(figure: Reproduced) -> Section:
    """Return a figure of the paper: its statement, the picture, the results, and the reason for any difference."""
    words = figure.words
    number = figure.number
    file = f"figure-{number:02d}"
    published = " ".join([f"{words.title}.", f"{words.alternative}.", *figure.found, SIMULATED])
    caption = f"Figure {number}. {words.alternative}."
    drawn = picture(
        f"paper-{number}", figure.draw, words.alternative, caption, file=file, published=published
    )
    further = []
    for name, (draw, alternative, caption) in figure.extras.items():
        published = f"{caption} {SIMULATED}"
        further.append(
            picture(
                f"paper-{number}-{name}",
                draw,
                alternative,
                caption,
                file=f"{file}-{name}",
                published=published,
            )
        )
    blocks = [
        Markup("<blockquote><p>{}</p></blockquote>").format(words.quotation),
        drawn._replace(id=f"fig-{number}"),
        Markup("<p><strong>Found.</strong></p>"),
        Block("items", figure.found),
        *figure.tables,
        *further,
        Markup("<p><strong>Why it differs.</strong> {}</p>").format(words.differs),
        Markup(
            '<p class="note">Claim: {} <strong>Here: {}.</strong> Experiment: <code>{}</code>.</p>'
        ).format(words.claim, figure.verdict, figure.origin.name),
    ]
    return Section(f"figure-{number}", f"Figure {number}: {words.title}", blocks, "Figures")


def paper_summary(
    figures: Sequence[Reproduced], *, provenance: Mapping[str, str]
) -> dict[str, Any]:
    """Return the figures in numbers, in SI: travels of the table in m, torques of the screw in N*m.

    Parameters
    ----------
    figures : sequence of Reproduced
        The figures.
    provenance : mapping of str to str
        Versions, files, checksums.
    """
    entries = {
        str(figure.number): {
            "title": figure.words.title,
            "claim": figure.words.claim,
            "verdict": figure.verdict,
        }
        | {"found": figure.found, "numbers": figure.numbers, "experiment": figure.origin.name}
        for figure in figures
    }
    return {
        "paper": TITLE,
        "verdict": paper_ruling(figures).as_data(),
        "figures": entries,
        "provenance": provenance,
    }
