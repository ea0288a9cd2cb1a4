"""Connections of clients that say nothing, or read nothing, are closed: they must not use up all that there are.

Anybody on this machine can connect, also who has no token. So those who have not shown it hold a few connections at
most, for a short time, and the oldest of them makes room for a new one: what a person asks for comes at once, whoever
else is there.
"""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

from bristle.server.gate import HAS_TOKEN
from bristle.server.limits import Limits

__all__ = ["protocol_with_limits"]

ARRIVES = 0.1  # [s] within which what was sent with a connection is read


def protocol_with_limits(limits: Limits) -> type[H11Protocol]:
    """Return the protocol of a connection that ends it where no request is whole within a time."""

    class PatientProtocol(H11Protocol):
        """HTTP/1.1 with a watch over the time in which no request is being answered."""

        def connection_made(self, transport: Any) -> None:
            super().connection_made(transport)
            self._begun = self._connected_at = self.loop.time()
            self._watch()
            self.loop.call_later(ARRIVES, self._make_room)

        def connection_lost(self, exc: Exception | None) -> None:
            self._timer.cancel()
            super().connection_lost(exc)

        def on_response_complete(self) -> None:
            self._begun = self.loop.time()
            super().on_response_complete()

        def _has_token(self) -> bool:
            """Return whether the last request had the token."""
            return self.scope is not None and HAS_TOKEN in self.scope.get("state", {})

        def _make_room(self) -> None:
            """Drop the oldest connections without the token where there are too many."""
            strangers = [protocol for protocol in self.connections if isinstance(protocol, PatientProtocol) and not protocol._has_token()]
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

    return PatientProtocol
