"""A page from a template: everything in one file, everything escaped but the figures drawn here.

What a person wrote is shown as it is, but for characters that no page may hold: names of files can have any.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import jinja2
from markupsafe import Markup, escape

from bristle.core.typography import typeset_sentence
from bristle.report.symbols import worded

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bristle.report.further import FurtherFigure

__all__ = ["Picture", "Plate", "picture", "plates", "render"]

SHORT, LONGEST = 12, 40  # letters of a name that is never broken, and of one that takes one line


class Picture(NamedTuple):
    """A figure of a page: its identifier, the drawing, and a caption that says what to see."""

    id: str
    svg: Markup
    caption: str


class Plate(NamedTuple):
    """A figure of a page as it is published by itself: its name for a file, the drawing, what it is and its caption.

    What draws one of a user's `own` may still fail as it is saved.
    """

    name: str
    figure: Figure
    alternative: str
    caption: str
    own: bool = False


_plates: ContextVar[list[Plate] | None] = ContextVar("plates", default=None)


@contextmanager
def plates() -> Iterator[list[Plate]]:
    """Give a list that every figure drawn for a page in this block is added to."""
    collected: list[Plate] = []
    before = _plates.set(collected)
    try:
        yield collected
    finally:
        _plates.reset(before)


def picture(
    name: str, draw: Callable[[], Figure], alternative: str, caption: str, *, file: str = "", published: str = "", own: bool = False
) -> Picture:
    """Return a figure for a page."""
    from bristle.figures import inline_svg

    figure = draw()
    svg = Markup(inline_svg(figure, name, alternative))
    if (collected := _plates.get()) is not None:
        collected.append(Plate(file or name, figure, alternative, published or caption, own))
    return Picture(f"figure-{name}", svg, caption)


def render(
    template: str, *, provenance: Mapping[str, str], command: str, banner: str | None, further: Sequence[FurtherFigure] = (), **content: Any
) -> str:
    """Return the page of a template."""
    from bristle.figures.lettering import printable

    page = _environment().get_template(template)
    return printable(page.render(provenance=provenance, command=command, banner=banner, further=further, **content))


def _breakable(text: str) -> Markup:
    """Return text in which long names, such as those of tests, may go on in the next line behind an underscore."""
    words = (escape(word).replace("_", Markup("_<wbr>")) if len(word) > SHORT else word for word in text.split(" "))
    return Markup(" ").join(words)


@lru_cache(maxsize=1)
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("bristle.report"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["typeset"] = typeset_sentence
    environment.filters["worded"] = worded
    environment.filters["breakable"] = _breakable
    # Names that would stretch a table: they are broken anywhere instead.
    environment.tests["long"] = lambda text: len(text) > LONGEST
    environment.tests["unbroken"] = lambda text: any(len(word) > LONGEST for word in text.split())
    return environment
