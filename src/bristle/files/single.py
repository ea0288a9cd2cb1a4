"""Write a single file that the user named; an existing file is replaced completely or not at all."""

import os
import secrets
from contextlib import suppress
from pathlib import Path

from bristle.core.errors import InputError

_NO_LINKS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


def write_whole(path: str | os.PathLike[str], content: str | bytes, *, new: bool = False) -> Path:
    """Write a file, text in UTF-8 with LF line ends; characters that cannot be encoded are escaped."""
    file = Path(path)
    data = content if isinstance(content, bytes) else content.encode("utf-8", "backslashreplace")
    replaces = os.path.lexists(file) and not new
    place, begun = (
        file.with_name(f".{file.name}.{secrets.token_hex(8)}") if replaces else file,
        False,
    )
    try:
        opened = os.open(place, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _NO_LINKS, 0o666)
        begun = True
        with os.fdopen(opened, "wb") as target:
            target.write(data)
            target.flush()
            os.fsync(target.fileno())
        if replaces:
            os.replace(place, file)
    except BaseException as error:
        if begun:
            with suppress(OSError):
                os.unlink(place)
        if not isinstance(error, OSError):
            raise
        reason = (error.strerror or str(error)).lower()
        raise InputError(
            f"cannot be written: {reason}", path=str(file), mend="Name a file in a writable folder"
        ) from None
    return file
