"""Where results come from: version, files with their checksums, the command that repeats it."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from bristle.logs.tables import located

__all__ = ["provenance", "provenance_of_all"]


def provenance(command: str, **files: Path | None) -> dict[str, str]:
    """Return where results come from.

    Parameters
    ----------
    command : str
        The command that repeats it.
    **files : Path or None
        The files that went in, by what they are: name and SHA-256 of each are noted.
    """
    return provenance_of_all(command, **{what: () if path is None else (path,) for what, path in files.items()})


def provenance_of_all(command: str, **files: Sequence[Path]) -> dict[str, str]:
    """Return where results come from, where there may be several files of one kind: the second log is ``log_2``."""
    found = {"bristle": version("bristle")}
    for kind, paths in files.items():
        for number, path in enumerate(paths, 1):
            what = kind if number == 1 else f"{kind}_{number}"
            file, table = located(path)
            found[what] = file.name if table is None else f"{file.name}::{table}"
            found[f"{what}_sha256"] = hashlib.sha256(file.read_bytes()).hexdigest()
    return found | {"command": command}
