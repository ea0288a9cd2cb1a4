"""The application: routes behind a gate."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from markupsafe import Markup
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from uvicorn.protocols.http.h11_impl import H11Protocol

from bristle import __version__
from bristle.apps.lab.page import PACKAGE
from bristle.apps.lab.server.cases import Cases
from bristle.apps.lab.server.gate import HAS_TOKEN, Gate, Opening
from bristle.apps.lab.server.limits import Limits
from bristle.apps.lab.server.loop import controller_fields
from bristle.apps.lab.server.routes import Routes
from bristle.apps.targets.page.packing import as_json
from bristle.core import InputError
from bristle.core.palette import colour_variables
from bristle.exports import TARGETS
from bristle.models.friction import DEFAULT_MODELS, MODELS, find
from bristle.report.assets import environment, hash_of, joined


def application(folder: Path, token: str, port: int, limits: Limits = Limits()) -> Starlette:  # noqa: B008  (frozen)
    """Return the application."""
    cases, opening = Cases(folder, limits), Opening(folder, port, token)
    routes = Routes(cases, opening, limits, _html(*server_page(limits)), _html(*ENTER))

    @asynccontextmanager
    async def lifespan(_: Starlette) -> AsyncIterator[None]:
        yield
        await routes.end()

    gate = Middleware(Gate, token=token, port=port, silence_seconds=limits.silence_seconds)
    app = Starlette(
        routes=routes.all(),
        middleware=[gate],
        exception_handlers={InputError: _refused},
        lifespan=lifespan,
    )
    app.state.cases, app.state.opening = cases, opening
    return app


def _html(page: str, policy: str) -> Response:
    return Response(page, media_type="text/html", headers={"content-security-policy": policy})


async def _refused(_: Request, error: Exception) -> Response:
    """Answer a refused request with the reason; do not wait for the rest of its body."""
    return JSONResponse(
        {"message": str(error)}, getattr(error, "status", 400), headers={"connection": "close"}
    )


OF_LAB = ("paths.js", "plot.js", "controls.js")
SCRIPTS = (
    "asking.js",
    "tables.js",
    "curves.js",
    "columns.js",
    "excitation.js",
    "loop.js",
    "steps.js",
    "tune.js",
    "server.js",
)
TO_PAGE = 'location.replace("/" + location.hash)'
# The page that redirects to the main page and keeps the fragment, with its content security policy.
ENTER = (
    f'<!DOCTYPE html><html lang="en"><title>bristle</title><script>{TO_PAGE}</script></html>',
    f"default-src 'none'; script-src {hash_of(TO_PAGE)}; frame-ancestors 'none'",
)


def server_page(limits: Limits) -> tuple[str, str]:
    """Return the page, and its content security policy."""
    first = DEFAULT_MODELS.split(",")
    names = dict.fromkeys([*first, *MODELS])
    models = [
        {"name": name, "description": find(name).description, "first": name in first}
        for name in names
    ]
    targets = [
        {
            "name": name,
            "title": target.title or name,
            "description": target.description,
            "first": name == "table",
        }
        for name, target in TARGETS.items()
        if not target.needs
    ]
    data = as_json(
        {
            "models": models,
            "targets": targets,
            "controllers": controller_fields(),
            "file_size": limits.file_size,
            "jobs": limits.jobs,
        }
    )
    script = joined(OF_LAB, PACKAGE) + joined(SCRIPTS, "bristle.apps.lab.server")
    style = (
        colour_variables()
        + joined(("lab.css", "controls.css"), PACKAGE)
        + joined(("server.css",), "bristle.apps.lab.server")
    )
    template = environment("bristle.apps.lab.server").get_template("server.html")
    page = template.render(
        style=Markup(style), script=Markup(script), data=Markup(data), version=__version__
    )
    # It may run its script, use its style, talk to its server and show a report.
    policy = (
        f"default-src 'none'; script-src {hash_of(script)}; style-src {hash_of(style)}; img-src data:; "
        "connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
    return page, policy


def protocol_with_limits(limits: Limits) -> type[H11Protocol]:
    """Return a protocol that closes a connection without a complete request in a given time."""

    class PatientProtocol(H11Protocol):
        """HTTP/1.1 with a limit on the time between requests."""

        def connection_made(self, transport: Any) -> None:
            super().connection_made(transport)
            self._begun = self._connected_at = self.loop.time()
            self._watch()
            # Time to read the first bytes of a connection [s]
            self.loop.call_later(0.1, self._make_room)

        def connection_lost(self, exc: Exception | None) -> None:
            self._timer.cancel()
            super().connection_lost(exc)

        def on_response_complete(self) -> None:
            self._begun = self.loop.time()
            self._had_token = self._has_token_now()
            super().on_response_complete()

        def _has_token(self) -> bool:
            """Return whether the request or the answered request before it had the token: the gate has not judged a new one yet."""
            return self._had_token or self._has_token_now()

        def _has_token_now(self) -> bool:
            return self.scope is not None and HAS_TOKEN in self.scope.get("state", {})

        def _make_room(self) -> None:
            """Drop the oldest connections without the token if there are too many."""
            strangers = [
                protocol
                for protocol in self.connections
                if isinstance(protocol, PatientProtocol) and not protocol._has_token()
            ]
            strangers.sort(key=lambda protocol: protocol._connected_at)
            for oldest in strangers[: max(0, len(strangers) - limits.strangers)]:
                oldest.transport.abort()

        def _watch(self) -> None:
            answering = self.cycle is not None and not self.cycle.response_complete
            if self.transport.is_closing() and self._closing:
                self.transport.abort()
                return
            self._closing = self.transport.is_closing()
            patience = limits.silence_seconds if self._has_token() else limits.stranger_seconds
            if not answering and self.loop.time() - self._begun >= patience:
                self.transport.abort()
                return
            self._timer: asyncio.TimerHandle = self.loop.call_later(patience / 4.0, self._watch)

        _closing = False
        _had_token = False

    return PatientProtocol
