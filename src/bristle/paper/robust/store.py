"""The folder of a trial: each part a file, whole or not there, with what it was made from, for a second start."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bristle.files.growing import Growing, growing_folder

__all__ = ["Store", "opened"]

PARTS, FIGURES = "parts", "figures"
WRITTEN = ("summary.json", "report.html")


class Store:
    """The folder while this process writes into it."""

    def __init__(self, grown: Growing) -> None:
        self.grown, self.path = grown, grown.path

    def write(self, name: str, content: str | bytes) -> Path:
        """Write a file; it appears whole under its name, in the place of one that was written before."""
        return self.grown.write(name, content)

    def take(self, name: str, source: Mapping[str, Any]) -> Any:
        """Return what a part holds; None where it is not there or was made from something else."""
        content = self.grown.read(f"{PARTS}/{name}.json")
        part = None if content is None else json.loads(content)
        return part["content"] if part and part["made_from"] == dict(source) else None

    def keep(self, name: str, source: Mapping[str, Any], content: Any) -> None:
        """Write a part."""
        self.write(f"{PARTS}/{name}.json", json.dumps({"made_from": dict(source), "content": content}) + "\n")


@contextmanager
def opened(path: str | Path) -> Iterator[Store]:
    """Give a folder to write into, new or begun by an earlier trial, to this process alone."""
    with growing_folder(path, "robust trial", made_anew=_is_part, used=_is_used) as (grown, damaged):
        grown.set_all_aside(damaged)
        yield Store(grown)


def _is_part(name: str) -> bool:
    return name.startswith(f"{PARTS}/")


def _is_used(name: str) -> bool:
    return name in WRITTEN or name.partition("/")[0] in (PARTS, FIGURES)
