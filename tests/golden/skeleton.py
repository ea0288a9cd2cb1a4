"""The skeleton of a result: its keys, and the values on which programs depend: names, units and statuses."""

from __future__ import annotations

import json
from typing import Any

# Below them no text is kept.
OF_THE_PLACE = {"provenance", "file", "files", "checksum", "written", "identify"}
LONGEST = 40  # characters of a name
NAME = "name"
ABSENT = "absent"


def skeleton(value: Any, key: str = "", *, bare: bool = False) -> Any:
    """Return plain data with a word for each value: what it is, or itself where it is a name.

    Items of a list are told apart by their names; where they have none, they become one with what each of them has.
    """
    bare = bare or key in OF_THE_PLACE
    if isinstance(value, dict):
        return {name: skeleton(item, name, bare=bare) for name, item in value.items()}
    if isinstance(value, list):
        return _of_list(value, key, bare=bare)
    if isinstance(value, str):
        return f"= {value}" if not bare and _is_name(value, key) else "text"
    if isinstance(value, bool):
        return f"= {json.dumps(value)}"
    return "nothing" if value is None else "number"


def _is_name(value: str, key: str) -> bool:
    if key == "status":  # a sentence; what it counts is no name
        return not any(map(str.isdigit, value))
    return 0 < len(value) <= LONGEST and " " not in value


def _of_list(value: list[Any], key: str, *, bare: bool) -> Any:
    names = [item.get(NAME) if isinstance(item, dict) else item for item in value]
    if (
        names
        and all(isinstance(item, str) and _is_name(item, key) for item in names)
        and len(set(names)) == len(names)
    ):
        return {
            f"[{name}]": skeleton(item, bare=bare) for name, item in zip(names, value, strict=True)
        }
    result: Any = "empty"
    for item in value:
        result = _joined(result, skeleton(item, key, bare=bare))
    return {"[]": result}


def _joined(item: Any, other: Any) -> Any:
    """Return what two items of a list have between them; of words that differ, each that was seen."""
    if item in (other, "empty"):
        return other
    if (
        isinstance(item, dict)
        and isinstance(other, dict)
        and not (_is_seen(item) or _is_seen(other))
    ):
        return {
            name: _joined(item.get(name, ABSENT), other.get(name, ABSENT)) for name in item | other
        }
    return {f"seen: {word}": "" for word in sorted({*_words(item), *_words(other)})}


def _is_seen(result: dict[str, Any]) -> bool:
    return any(name.startswith("seen: ") for name in result)


def _words(result: Any) -> list[str]:
    if isinstance(result, dict):
        return [name.removeprefix("seen: ") for name in result] if _is_seen(result) else ["table"]
    return [result]
