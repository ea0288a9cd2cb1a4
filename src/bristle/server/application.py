"""The application: what answers, behind what lets in."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from bristle.server.bodies import RefusedRequestError
from bristle.server.cases import Cases
from bristle.server.gate import Gate
from bristle.server.limits import Limits
from bristle.server.opening import Opening
from bristle.server.page import server_page
from bristle.server.routes import Routes

__all__ = ["application"]


def application(folder: Path, token: str, port: int, limits: Limits = Limits()) -> Starlette:  # noqa: B008  (frozen)
    """Return the application."""
    page, policy = server_page(limits)
    cases, opening = Cases(folder, limits), Opening(folder, port, token)
    routes = Routes(cases, opening, limits, page, policy)

    @asynccontextmanager
    async def lifespan(_: Starlette) -> AsyncIterator[None]:
        yield
        await routes.end()

    gate = Middleware(Gate, token=token, port=port, silence_seconds=limits.silence_seconds)
    app = Starlette(routes=routes.all(), middleware=[gate], exception_handlers={RefusedRequestError: _refused}, lifespan=lifespan)
    app.state.cases, app.state.opening = cases, opening
    return app


async def _refused(_: Request, error: Exception) -> Response:
    """Tell why a request is not answered; the rest of its body is not waited for."""
    assert isinstance(error, RefusedRequestError)
    return JSONResponse({"message": str(error)}, error.status, headers={"connection": "close"})
