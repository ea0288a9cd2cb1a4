"""Access control, before any other code sees a request.

A page of another site can send requests to a server on this machine, and can point its host name to this machine
(DNS rebinding). Therefore ``Host`` must name this machine, and ``Origin``, if sent, must be this server. Every request
except the one for the page needs the token. The token is in the fragment of the address: browsers never send fragments,
and other sites cannot read them.
"""

import asyncio
import os
import secrets
import threading
from pathlib import Path

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

LOOPBACK = "127.0.0.1"
TOKEN = "x-bristle-token"  # the header that carries the token
HAS_TOKEN = "bristle.has_token"  # key in the state of a request with the token
ENTRANCE = "/opened/"  # entry for a browser opened with a file: cross-site, once, with a ticket
# Paths without a token, like the page, which contains no data: reports and the entrance, once for each ticket.
HEADERS = {
    "cache-control": "no-store",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "content-security-policy": "default-src 'none'; frame-ancestors 'none'",
}


class Gate:
    """Let requests of the page pass, and limit the time of clients that do not read."""

    def __init__(self, app: ASGIApp, *, token: str, port: int, silence_seconds: float) -> None:
        self._app, self._token, self._patience = app, token.encode("ascii"), silence_seconds
        self._hosts = {f"{name}:{port}" for name in (LOOPBACK, "localhost")}
        self._origins = {f"http://{host}" for host in self._hosts}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or pass it on."""
        if scope["type"] != "http":
            if scope["type"] == "lifespan":
                await self._app(scope, receive, send)
            return

        async def send_in_time(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await asyncio.wait_for(send(message), self._patience)

        refusal = self._refusal(scope)
        if refusal is None and not _takes_no_token(scope["path"]):
            scope.setdefault("state", {})[HAS_TOKEN] = True
        await (refusal or self._app)(scope, receive, send_in_time)

    def _refusal(self, scope: Scope) -> JSONResponse | None:
        headers = Headers(scope=scope)
        if len(hosts := headers.getlist("host")) != 1 or hosts[0] not in self._hosts:
            return _refused(421, "Host: is not this machine. Open the address printed by bristle")
        if any(origin not in self._origins for origin in headers.getlist("origin")):
            return _refused(403, "Origin: belongs to another site")
        sites = () if scope["path"].startswith(ENTRANCE) else headers.getlist("sec-fetch-site")
        if any(site not in ("same-origin", "none") for site in sites):
            return _refused(
                403,
                "Sec-Fetch-Site: the request comes from another site. Type the address into the browser",
            )
        if _takes_no_token(scope["path"]):
            return None
        tokens = headers.getlist(TOKEN)
        if len(tokens) != 1 or not secrets.compare_digest(tokens[0].encode("latin-1"), self._token):
            return _refused(
                401, "the token is missing or old. Open the latest address printed by bristle"
            )
        return None


def _takes_no_token(path: str) -> bool:
    return path == "/" or path.startswith(("/shown/", ENTRANCE))


def _refused(status: int, message: str) -> JSONResponse:
    return JSONResponse({"message": message}, status, headers={"connection": "close"})


LEADS_ON = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>bristle</title><meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={address}"></head><body></body></html>
"""


class Opening:
    """The entrance for a browser started by bristle."""

    def __init__(self, folder: Path, port: int, token: str) -> None:
        self._file, self._ticket = folder / "open.html", ""
        self._base, self._token = f"http://{LOOPBACK}:{port}{ENTRANCE}", token

    def offer(self, seconds: float = 60.0) -> Path:
        """Return the file to open a browser with. bristle removes it after its use, or after a time [s]."""
        ticket = secrets.token_urlsafe(32)
        with os.fdopen(
            os.open(self._file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="ascii"
        ) as file:
            file.write(LEADS_ON.format(address=f"{self._base}{ticket}#{self._token}"))
        self._ticket = ticket
        timer = threading.Timer(seconds, self.end)
        timer.daemon = True
        timer.start()
        return self._file

    def redeem(self, ticket: str) -> bool:
        """Return whether this is the unused ticket of the file."""
        fits = bool(self._ticket) and secrets.compare_digest(ticket.encode(), self._ticket.encode())
        if fits:
            self.end()
        return fits

    def end(self) -> None:
        """Remove the file and invalidate its ticket."""
        self._ticket = ""
        self._file.unlink(missing_ok=True)
