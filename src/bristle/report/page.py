"""The skeleton of every report: a self-contained HTML page with a first screen, sections and figures.

Each kind of report supplies facts, a first page and sections. Figures come from `bristle.report.figures.on_reports`. Text is escaped.
"""

from __future__ import annotations

import datetime
import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, NamedTuple

from markupsafe import Markup, escape

from bristle.core import InputWarning, error_text, place_in_own_code, symbolic, typeset
from bristle.core.palette import colour_variables
from bristle.report.assets import environment as environment_of, hash_of, joined
from bristle.report.table import Table

if TYPE_CHECKING:
    import jinja2
    from matplotlib.figure import Figure

    from bristle.report.cards import Card, Step
    from bristle.report.figures.report_figure import Facts, ReportFigure
    from bristle.report.living import Living

SHORT, LONGEST = 12, 40  # letters of a name without line breaks, and of a name that fits a line


class Ruling(NamedTuple):
    """The verdict of a report, with its reasons."""

    level: str
    words: str
    reasons: tuple[str, ...] = ()

    def as_data(self) -> dict[str, Any]:
        """Return the verdict for JSON."""
        return self._asdict()

    @property
    def beyond_title(self) -> Ruling:
        """The verdict without its first reason, if the title states that reason."""
        return self._replace(reasons=self.reasons[1:])


class Picture(NamedTuple):
    """A figure of a page: identifier, drawing, caption and log."""

    id: str
    svg: Markup
    caption: str
    log: str = ""
    macro = "figure"


class Plate(NamedTuple):
    """A figure as a separate file: file name, drawing, alternative text and caption.

    Saving a figure of the user (`own`) may raise an error.
    """

    name: str
    figure: Figure
    alternative: str
    caption: str
    own: bool = False


class Front(NamedTuple):
    """The first screen of a report; without a ruling only heading and facts.

    `title` is the sentence over the large picture, `basis` the log or run behind it, `next` the next step, and `table` stands
    beside the large picture, and `feedforward` is whether a feedforward is safe to try.
    """

    heading: str
    facts: str
    ruling: Ruling | None = None
    title: str = ""
    basis: str = ""
    cards: Sequence[Card] = ()
    next: Step | None = None
    csv: str = ""
    figures: Sequence[Picture] = ()
    beside: Sequence[Picture] = ()
    table: Table | None = None
    feedforward: str = ""

    @property
    def has_more(self) -> bool:
        """Whether the verdict has more reasons than the first screen shows."""
        return self.ruling is not None and len(self.ruling.reasons) > 1


class Block(NamedTuple):
    """A block of a section: a macro of the templates and its content; empty blocks are left out."""

    macro: str
    content: Any
    further: Sequence[Any] = ()


class Figures(NamedTuple):
    """A place for the figures of a section of `bristle.report.figures.on_reports`; the default place is the end of that section."""

    section: str


class Section(NamedTuple):
    """A section of a page, with its name in `bristle.report.figures.on_reports`; empty sections are left out.

    Sections with the same `tab` share a tab; without a name, the heading is the name of the tab.

    Its blocks are paragraphs of text, markup, `Table`, `Block`, `Picture`, `Figures` and `Living`; None is left out.
    """

    id: str
    heading: str
    blocks: Sequence[Any]
    tab: str = ""


_plates: ContextVar[list[Plate] | None] = ContextVar("plates", default=None)


@contextmanager
def plates() -> Iterator[list[Plate]]:
    """Collect every figure drawn for a page in this block in a list."""
    collected: list[Plate] = []
    before = _plates.set(collected)
    try:
        yield collected
    finally:
        _plates.reset(before)


def about(*facts: str) -> str:
    """Return the line under the heading: the date and further facts."""
    return " · ".join((datetime.date.today().isoformat(), *filter(None, facts)))


def picture(
    name: str,
    draw: Callable[[], Figure],
    alternative: str,
    caption: str,
    *,
    file: str = "",
    published: str = "",
    own: bool = False,
) -> Picture:
    """Return a figure for a page."""
    from bristle.report.figures import inline_svg

    figure = draw()
    svg = Markup(inline_svg(figure, name, alternative))
    if (collected := _plates.get()) is not None:
        collected.append(Plate(file or name, figure, alternative, published or caption, own))
    return Picture(f"figure-{name}", svg, caption)


def report_page(
    kind: str,
    facts: Facts,
    front: Front,
    sections: Sequence[Section],
    *,
    figures: Sequence[ReportFigure] = (),
    **options: Any,
) -> str:
    """Return the page of a kind of report, with its figures and those of the user; options as of `page_of`."""
    pictures, remarks = _pictures(kind, facts)
    own = [*remarks, *(block for figure in figures for block in _own_blocks(figure, facts))]
    filled = [
        *(_filled(section, pictures) for section in sections),
        Section("further", "Further figures", own),
    ]
    return page_of(
        front._replace(figures=pictures.get("front", ()), beside=pictures.get("beside", ())),
        filled,
        **options,
    )


def page_of(
    front: Front,
    sections: Sequence[Section],
    *,
    command: str,
    provenance: Mapping[str, str],
    banner: str | None = None,
    living: Living | None = None,
) -> str:
    """Return the page of a first screen and sections."""
    from bristle.report.figures.drawing import printable

    tabs: dict[str, list[Section]] = {}
    for section in (_filled(section, {}) for section in sections):
        if section.blocks:
            tabs.setdefault(section.tab or section.heading, []).append(section)
    facts = {
        "command": command,
        "provenance": provenance,
        "banner": banner,
        "living": living,
        "front": front,
        "tabs": tabs,
    }
    script = joined(("plots.js",), "bristle.report")
    common = {
        "palette": Markup(colour_variables()),
        "plots": Markup(script),
        "plots_hash": hash_of(script),
    }
    return printable(_environment().get_template("page.html").render(**common, **facts))


def _pictures(kind: str, facts: Facts) -> tuple[dict[str, list[Picture]], list[Markup]]:
    """Return the figures of a kind of report by section, and a remark on each figure that failed."""
    from bristle.report.figures.on_reports import REPORTS

    pictures: dict[str, list[Picture]] = {place.section: [] for place in REPORTS.get(kind, ())}
    remarks: list[Markup] = []
    for place in REPORTS.get(kind, ()):
        try:
            if not place.is_taken(facts):
                continue
            figure, arguments = place.figure, place.figure.arguments(facts)
            alternative, caption = (
                text if isinstance(text, str) else text(*arguments)
                for text in (figure.alternative, figure.caption)
            )
            drawing = picture(figure.name, partial(figure.draw, *arguments), alternative, caption)
            # A prediction may be of another log than the report.
            own, log = (
                facts.get("log_name", ""),
                facts["prediction"].log
                if "prediction" in figure.needs
                else facts.get("log_name", ""),
            )
            # The title of the first screen names its log.
            log = "" if place.section in ("front", "beside") and log == own else log
            pictures[place.section].append(drawing._replace(log=log))
        except Exception as error:  # noqa: BLE001  (a fault of a figure costs no results)
            remark = f"the figure {place.name} is not drawn: {type(error).__name__}: {error_text(error)}".rstrip(
                ": "
            )
            warnings.warn(
                FaultWarning(f"{remark}. The other results are complete", error), stacklevel=2
            )
            remarks.append(Markup("<p>{}.</p>").format(remark))
    return pictures, remarks


def _filled(section: Section, pictures: Mapping[str, Sequence[Picture]]) -> Section:
    """Return a section with its figures in place, by default at its end, and without empty blocks."""
    filled = (
        block
        for block in section.blocks
        if block and (not isinstance(block, Block) or block.content)
    )
    blocks = [block for block in filled if not isinstance(block, Table) or block.rows]
    if not any(isinstance(block, Figures) for block in blocks):
        blocks.append(Figures(section.id))
    groups = (
        pictures.get(block.section, ()) if isinstance(block, Figures) else (block,)
        for block in blocks
    )
    return section._replace(blocks=[block for group in groups for block in group])


def _own_blocks(figure: ReportFigure, facts: Facts) -> list[Any]:
    """Return a figure of the user under its title; a failure gives a warning and a remark on the page."""
    from bristle.report.figures.own import draw_own

    place = ""
    try:
        if missing := figure.missing(facts):
            reason = f"this report has no {' and no '.join(missing)}"
        else:
            name, texts = (
                f"own-{figure.name.replace('_', '-')}",
                (str(figure.alternative), str(figure.caption)),
            )
            drawing = picture(
                name, lambda: draw_own(figure, facts), *texts, file=figure.name, own=True
            )
            return [Markup("<h3>{}</h3>").format(figure.title), drawing]
    # Code of the user may raise any exception or call exit(); the results must survive.
    except (Exception, SystemExit) as error:  # noqa: BLE001
        reason, place = (
            f"{type(error).__name__}: {error_text(error)}".rstrip(": "),
            place_in_own_code(error),
        )
    remark = f"{place or figure.name}: the figure {figure.name} is not drawn: {reason}"
    warnings.warn(f"{remark}. The other results are complete", InputWarning, stacklevel=2)
    return [Markup("<h3>{}</h3><p>{}.</p>").format(figure.title, remark)]


@lru_cache(maxsize=1)
def _environment() -> jinja2.Environment:
    environment = environment_of("bristle.report")

    def breakable(text: str) -> Markup:
        # Long names, such as those of tests, may break after an underscore.
        words = (
            escape(word).replace("_", Markup("_<wbr>")) if len(word) > SHORT else word
            for word in text.split(" ")
        )
        return Markup(" ").join(words)

    environment.filters |= {"typeset": typeset_sentence, "worded": worded, "breakable": breakable}
    # Names that would stretch a table may break anywhere.
    environment.tests |= {
        "long": lambda text: len(text) > LONGEST,
        "unbroken": lambda text: any(len(word) > LONGEST for word in text.split()),
        "prose": lambda block: isinstance(block, str) and not isinstance(block, Markup),
    }
    return environment


def macro(name: str) -> Callable[..., Markup]:
    """Return a macro of the templates."""
    return getattr(_environment().get_template("parts.html").module, name)


class FaultWarning(InputWarning):
    """A fault of bristle that loses a part of the results; the command line reports the error at its end."""

    def __init__(self, message: str, error: BaseException) -> None:
        super().__init__(message)
        self.__cause__ = error


def worded(text: str) -> Markup:
    """Return a sentence for a page: units and symbols typeset, text in backticks as code; markup is unchanged.

    Examples
    --------
    >>> worded('F_C is 5 N*m, see `k_v = "2 N*m"`')
    Markup('<i>F</i><sub>C</sub> is 5 N·m, see <code>k_v = &#34;2 N*m&#34;</code>')
    """
    if isinstance(text, Markup):
        return text
    pieces = re.split(r"`([^`]+)`", text)
    return Markup().join(
        Markup("<code>{}</code>").format(piece) if place % 2 else symbolic(typeset_sentence(piece))
        for place, piece in enumerate(pieces)
    )


def typeset_sentence(text: str) -> str:
    """Return a sentence with typeset units after its numbers."""
    return re.sub(
        r"(?<=\d )[A-Za-z]+(?:[A-Za-z*/^0-9]|\.(?=\d)|\([A-Za-z*^0-9.]+\))*",
        lambda match: typeset(match[0]),
        text,
    )
