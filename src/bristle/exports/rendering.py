"""Templates of the files that are written."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import jinja2

__all__ = ["rendered", "version"]


def rendered(template: str, facts: dict[str, Any]) -> str:
    """Return the text that a template gives with some facts."""
    return _environment().get_template(template).render(facts)


def version() -> str:
    """Return the version of bristle."""
    from bristle import __version__

    return __version__


@cache
def _environment() -> jinja2.Environment:
    import jinja2

    return jinja2.Environment(
        loader=jinja2.PackageLoader("bristle.exports"), autoescape=False, undefined=jinja2.StrictUndefined, keep_trailing_newline=True
    )
