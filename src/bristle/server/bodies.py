"""What a request brings, taken piece by piece: up to a limit, and from nobody who is silent for long."""

import asyncio
import json
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from starlette.requests import ClientDisconnect, Request

from bristle.core.content import size_in_words
from bristle.core.errors import InputError


class RefusedRequestError(InputError):
    """A request that is not answered; `status` is that of HTTP."""

    def __init__(self, status: int, message: str, **facts: Any) -> None:
        self.status = status
        super().__init__(message, **facts)


async def stored(request: Request, target: Path, most: int, silence: float) -> int:
    """Write the body of a request into a new file and return its size [byte]."""
    size = 0
    try:
        with target.open("xb") as file:
            async for piece in _pieces(request, most, silence):
                size += len(piece)
                await asyncio.to_thread(file.write, piece)
    except BaseException:
        target.unlink(missing_ok=True)
        raise
    return size


async def json_of(request: Request, most: int, silence: float) -> dict[str, Any]:
    """Return the body of a request as the JSON object that it must be."""
    text = b"".join([piece async for piece in _pieces(request, most, silence)])
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        data = None
    if not isinstance(data, dict):
        raise RefusedRequestError(400, "must be a JSON object", path="request")
    return data


async def _pieces(request: Request, most: int, silence: float) -> AsyncIterator[bytes]:
    announced = request.headers.get("content-length", "0")
    too_large = RefusedRequestError(
        413,
        "is larger than is taken",
        path="file",
        allowed=f"up to {size_in_words(most)}",
        mend='Cut the log, or start again with BRISTLE_SIZE_LIMIT="2 GB" in the environment',
    )
    if announced.isdecimal() and int(announced) > most:
        raise too_large
    size, stream = 0, request.stream()
    try:
        while True:
            try:
                piece = await asyncio.wait_for(anext(stream), silence)
            except StopAsyncIteration:
                return
            size += len(piece)
            if size > most:
                raise too_large
            yield piece
    except TimeoutError:
        raise RefusedRequestError(408, f"has said nothing for {silence:g} s", path="request") from None
    except ClientDisconnect:
        raise RefusedRequestError(400, "was broken off", path="request") from None
