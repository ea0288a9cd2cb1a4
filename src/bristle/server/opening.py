"""`Opening`: how a browser that is opened gets the token, which no process may have in its arguments: all see those.

The browser is opened with a file that only this user can read. It leads to an entrance of the server, with the token
behind the ``#``. The entrance is there once and for a short time, and so is the file.
"""

from __future__ import annotations

import os
import secrets
import threading
from pathlib import Path

from bristle.server.gate import ENTRANCE, LOOPBACK

__all__ = ["Opening"]

FILE = "open.html"
OFFERED = 60.0  # [s] within which a browser begins, on a slow machine too
LEADS_ON = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>bristle</title><meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={address}"></head><body></body></html>
"""


class Opening:
    """The way in for a browser that is opened."""

    def __init__(self, folder: Path, port: int, token: str) -> None:
        self._file, self._ticket = folder / FILE, ""
        self._base, self._token = f"http://{LOOPBACK}:{port}{ENTRANCE}", token

    def offer(self, seconds: float = OFFERED) -> Path:
        """Return the file to open a browser with; it is gone once that has come, or after a time [s]."""
        ticket = secrets.token_urlsafe(32)
        with os.fdopen(os.open(self._file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="ascii") as file:
            file.write(LEADS_ON.format(address=f"{self._base}{ticket}#{self._token}"))
        self._ticket = ticket
        timer = threading.Timer(seconds, self.end)
        timer.daemon = True
        timer.start()
        return self._file

    def redeem(self, ticket: str) -> bool:
        """Return whether this is the ticket of the file, which serves once."""
        fits = bool(self._ticket) and secrets.compare_digest(ticket.encode(), self._ticket.encode())
        if fits:
            self.end()
        return fits

    def end(self) -> None:
        """Remove the file; its ticket is worth nothing then."""
        self._ticket = ""
        self._file.unlink(missing_ok=True)
