"""`serve`: the application on this machine, until it is ended."""

from __future__ import annotations

import secrets
import socket
import threading
import webbrowser
from collections.abc import Callable
from importlib.util import find_spec
from typing import TYPE_CHECKING

from bristle.core.errors import InputError, MissingExtraError
from bristle.server.limits import Limits
from bristle.server.own_folder import own_folder

if TYPE_CHECKING:
    from starlette.types import ASGIApp
    from uvicorn import Server

LOOPBACK = "127.0.0.1"
BACKLOG = 128  # connections waiting; [s] each


def serve(*, port: int = 0, opens: bool = True, limits: Limits | None = None, announce: Callable[[str], None] = print) -> None:
    """Serve the lab to browsers of this machine until the process is ended.

    Parameters
    ----------
    port : int
        Where to listen; 0 for one that is free.
    opens : bool
        Whether a browser is opened.
    limits : Limits, optional
        How much of anything a browser may ask for.
    announce : callable
        Called once with the address, which holds the token.

    Raises
    ------
    MissingExtraError
        If what serves is not installed.
    InputError
        If the port is not free.
    """
    for package in ("starlette", "uvicorn"):
        if find_spec(package) is None:
            raise MissingExtraError.of("lab --serve", "lab")
    from bristle.server.application import application

    bounds, token = limits or Limits(), secrets.token_urlsafe(32)
    with listening_on(port) as listening, own_folder() as folder:
        free_port: int = listening.getsockname()[1]
        app = application(folder, token, free_port, bounds)
        announce(f"http://{LOOPBACK}:{free_port}/#{token}")
        if opens:
            file = app.state.opening.offer()
            threading.Thread(target=webbrowser.open, args=(file.as_uri(),), daemon=True).start()
        server_of(app, bounds).run(sockets=[listening])


def server_of(app: ASGIApp, limits: Limits) -> Server:
    """Return what serves an application to a socket, and has no patience with clients that are silent."""
    import uvicorn

    from bristle.server.application import protocol_with_limits

    config = uvicorn.Config(
        app,
        http=protocol_with_limits(limits),
        ws="none",
        lifespan="on",
        log_config=None,
        access_log=False,
        server_header=False,
        proxy_headers=False,
        backlog=BACKLOG,
        timeout_keep_alive=5,
        timeout_graceful_shutdown=1,
    )
    return uvicorn.Server(config)


def listening_on(port: int) -> socket.socket:
    """Return a socket that hears this machine only."""
    if not 0 <= port < 2**16:
        raise InputError("is no port", path="--port", value=port, allowed="0 to 65535, 0 for one that is free")
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listening.bind((LOOPBACK, port))
        listening.listen(BACKLOG)  # a browser that is faster than the server waits for it
    except OSError as error:
        listening.close()
        raise InputError(
            f"cannot be listened to: {error.strerror}", path="--port", value=port, mend="Leave --port away: a free one is taken"
        ) from None
    listening.set_inheritable(False)
    return listening
