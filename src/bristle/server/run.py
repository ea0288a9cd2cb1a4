"""`serve`: the application on this machine, until it is ended."""

from __future__ import annotations

import secrets
import socket
import threading
import webbrowser
from collections.abc import Callable
from importlib.util import find_spec

from bristle.core.errors import InputError, MissingExtraError
from bristle.server.limits import Limits

__all__ = ["serve"]

LOOPBACK = "127.0.0.1"
BACKLOG, KEEP_ALIVE, FAREWELL = 128, 5, 1  # connections waiting; [s] each


def serve(
    *, port: int = 0, opens: bool = True, limits: Limits | None = None, announce: Callable[[str], None] = print
) -> None:
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
    import uvicorn

    from bristle.server.application import application
    from bristle.server.patience import protocol_with_limits

    bounds = limits or Limits()
    listening = _listening(port)
    taken: int = listening.getsockname()[1]
    token = secrets.token_urlsafe(32)
    address = f"http://{LOOPBACK}:{taken}/#{token}"
    config = uvicorn.Config(
        application(token, taken, bounds), http=protocol_with_limits(bounds.silence_seconds), ws="none",
        lifespan="on", log_config=None, access_log=False, server_header=False, proxy_headers=False,
        limit_concurrency=bounds.connections, backlog=BACKLOG, timeout_keep_alive=KEEP_ALIVE,
        timeout_graceful_shutdown=FAREWELL,
    )  # fmt: skip
    announce(address)
    if opens:
        threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
    with listening:
        uvicorn.Server(config).run(sockets=[listening])


def _listening(port: int) -> socket.socket:
    """Return a socket that hears this machine only."""
    if not 0 <= port < 2**16:
        raise InputError("is no port", path="--port", value=port, allowed="0 to 65535, 0 for one that is free")
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listening.bind((LOOPBACK, port))
    except OSError as error:
        listening.close()
        raise InputError(f"cannot be listened to: {error.strerror}", path="--port", value=port,
                         mend="Leave --port away: a free one is taken") from None  # fmt: skip
    listening.set_inheritable(False)
    return listening
