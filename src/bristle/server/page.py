"""The page of the application: one file, in the looks of the lab, its script and style named by their hashes."""

from __future__ import annotations

import json
from importlib import resources
from typing import Any

from markupsafe import Markup

from bristle.exports.described import version
from bristle.exports.targets import TARGETS
from bristle.friction import DEFAULT_MODELS, MODELS, find
from bristle.lab.page import hash_of, joined
from bristle.server.limits import Limits

__all__ = ["entrance", "server_page"]

OF_LAB = ("paths.js", "plot.js", "controls.js")
SCRIPTS = ("asking.js", "tables.js", "curves.js", "columns.js", "excitation.js", "steps.js", "server.js")
FIRST_TARGET = "table"
TO_PAGE = 'location.replace("/" + location.hash)'


def server_page(limits: Limits) -> tuple[str, str]:
    """Return the page, and the policy under which a browser runs it."""
    import jinja2

    script = joined(OF_LAB) + joined(SCRIPTS, "bristle.server")
    style = joined(("lab.css", "controls.css")) + joined(("server.css",), "bristle.server")
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(_template), autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    page = environment.get_template("server.html").render(
        style=Markup(style), script=Markup(script), data=Markup(_data(limits)), version=version()
    )
    return page, _policy(script, style)


def entrance() -> tuple[str, str]:
    """Return what leads on to the page with the fragment as it is, and the policy under which a browser runs it."""
    page = f'<!DOCTYPE html><html lang="en"><title>bristle</title><script>{TO_PAGE}</script></html>'
    return page, f"default-src 'none'; script-src {hash_of(TO_PAGE)}; frame-ancestors 'none'"


def _template(name: str) -> str:
    return resources.files("bristle.server").joinpath("templates", name).read_text(encoding="utf-8")


def _policy(script: str, style: str) -> str:
    """Return what the page may do: run its script, use its style, speak to its server and show a report of it."""
    return (
        f"default-src 'none'; script-src {hash_of(script)}; style-src {hash_of(style)}; img-src data:; "
        "connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )


def _data(limits: Limits) -> str:
    first = DEFAULT_MODELS.split(",")
    models: list[dict[str, Any]] = [
        {"name": name, "description": find(name).description, "first": name in first} for name in dict.fromkeys([*first, *MODELS])
    ]
    targets = [
        {"name": name, "title": target.title or name, "description": target.description, "first": name == FIRST_TARGET}
        for name, target in TARGETS.items()
        if not target.needs
    ]
    data = {"models": models, "targets": targets, "file_size": limits.file_size, "jobs": limits.jobs}
    return json.dumps(data).replace("<", "\\u003c")
