"""Where results come from: version, files with their checksums, the command that repeats it."""

from __future__ import annotations

import hashlib
from importlib.metadata import version
from pathlib import Path

from bristle.logs.tables import located

__all__ = ["provenance"]


def provenance(command: str, **files: Path | None) -> dict[str, str]:
    """Return where results come from.

    Parameters
    ----------
    command : str
        The command that repeats it.
    **files : Path or None
        The files that went in, by what they are: name and SHA-256 of each are noted.
    """
    found = {"bristle": version("bristle")}
    for what, path in files.items():
        if path is not None:
            file, table = located(path)
            found[what] = file.name if table is None else f"{file.name}::{table}"
            found[f"{what}_sha256"] = hashlib.sha256(file.read_bytes()).hexdigest()
    return found | {"command": command}
