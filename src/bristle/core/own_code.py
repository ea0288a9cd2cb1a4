"""Where in a file of a user's own something went wrong: its modules are known by their names."""

from __future__ import annotations

import traceback
from pathlib import Path

__all__ = ["OWN_CODE", "place_in_own_code"]

OWN_CODE = "bristle_user_"
"""What the name of a module begins with that was made of a file of a user's own."""


def place_in_own_code(error: BaseException) -> str:
    """Return the file and the last line of a user's own on the way to an error; nothing where there is none.

    Files are told by name, for what is told may be mailed.
    """
    for frame, line in reversed(list(traceback.walk_tb(error.__traceback__))):
        if str(frame.f_globals.get("__name__", "")).startswith(OWN_CODE):
            return f"{Path(frame.f_code.co_filename).name}, line {line}"
    return ""
