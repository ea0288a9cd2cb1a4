"""Where results come from: version, files with their checksums, the command that repeats it.

Reports are mailed: files are told by name, never by the folders that they lie in.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from typing import Protocol

from bristle.core.content import Origin
from bristle.core.typography import printable

__all__ = ["Traced", "provenance"]


class Traced(Protocol):
    """What knows the file that it comes from."""

    @property
    def origin(self) -> Origin:
        """Name and checksum of the file."""
        ...


def provenance(command: str, **files: Traced | Sequence[Traced | Origin] | None) -> dict[str, str]:
    """Return where results come from."""
    record = {"bristle": version("bristle")}
    for kind, sources in files.items():
        listed = () if sources is None else sources if isinstance(sources, Sequence) else (sources,)
        for number, source in enumerate(listed, 1):
            key = kind if number == 1 else f"{kind}_{number}"
            origin = source if isinstance(source, Origin) else source.origin
            record |= {key: printable(origin.name), f"{key}_sha256": origin.checksum}
            if part := getattr(source, "part", ""):
                record[f"{key}_part"] = printable(part)
    return record | {"command": command}
