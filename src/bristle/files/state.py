"""What bristle remembers of a person from one command to the next, in a folder of that person's own."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["state_folder"]


def state_folder(name: str) -> Path:
    """Return a folder to remember something in, made where there is none; nobody else can look into it.

    ``BRISTLE_STATE_DIR`` overrides the place.
    """
    import platformdirs

    chosen = os.environ.get("BRISTLE_STATE_DIR")
    root = Path(chosen) if chosen else Path(platformdirs.user_state_dir("bristle", appauthor=False))
    folder = root / name
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    return folder
