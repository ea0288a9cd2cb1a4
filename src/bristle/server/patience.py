"""Connections of clients that say nothing, or read nothing, are closed: they must not use up all that there are."""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

__all__ = ["protocol_with_limits"]


def protocol_with_limits(silence_seconds: float) -> type[H11Protocol]:
    """Return the protocol of a connection that ends it where no request is whole within this time.

    Parameters
    ----------
    silence_seconds : float
        Time for the lines of a request, for the rest of one that was answered already, and for the last bytes to be
        read once the connection is closing [s].
    """

    class PatientProtocol(H11Protocol):
        """HTTP/1.1 with a watch over the time in which no request is being answered."""

        def connection_made(self, transport: Any) -> None:
            super().connection_made(transport)
            self._begun = self.loop.time()
            self._watch()

        def connection_lost(self, exc: Exception | None) -> None:
            self._timer.cancel()
            super().connection_lost(exc)

        def on_response_complete(self) -> None:
            self._begun = self.loop.time()
            super().on_response_complete()

        def _watch(self) -> None:
            answering = self.cycle is not None and not self.cycle.response_complete
            if self.transport.is_closing() and self._closing:
                self.transport.abort()
                return
            self._closing = self.transport.is_closing()
            if not answering and self.loop.time() - self._begun >= silence_seconds:
                self.transport.abort()
                return
            self._timer: asyncio.TimerHandle = self.loop.call_later(silence_seconds / 4.0, self._watch)

        _closing = False

    return PatientProtocol
