"""The keys that the reference of the JSON documents, and where a result has them."""

import re
from typing import Any

from tests.docs.conftest import ROOT

PAGE = ROOT / "docs" / "reference" / "json.md"


def documented(command: str) -> list[str]:
    """Return the keys in the section of a command, abbreviated ones in full: a.b, .c is a.b, a.c."""
    section = (
        PAGE.read_text(encoding="utf-8").split(f"\n## bristle {command}\n")[1].split("\n## ")[0]
    )
    keys: list[str] = []
    for line in re.findall(r"^\| (`.*?) \|", section, flags=re.MULTILINE):
        for key in re.findall(r"`([^`]+)`", line):
            keys.append(key if not key.startswith(".") else keys[-1].rpartition(".")[0] + key)
    return keys


def is_found(skeleton: Any, key: str) -> bool:
    """Return whether a key leads to something in the skeleton of a result; an ellipsis takes any name, [] any item."""
    for part in key.split("."):
        name, items = part.removesuffix("[]"), part.endswith("[]")
        if _is_list(skeleton):
            skeleton = next(iter(skeleton.values()))
        if not isinstance(skeleton, dict) or (
            name not in skeleton and (name != "…" or not skeleton)
        ):
            return False
        skeleton = skeleton[name] if name != "…" else next(iter(skeleton.values()))
        if items and not _is_list(skeleton):
            return False
    return True


def _is_list(skeleton: Any) -> bool:
    return isinstance(skeleton, dict) and any(name.startswith("[") for name in skeleton)
