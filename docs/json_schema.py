"""The JSON schema of what commands print with `--json`, from the frozen results of the tests: ``python docs/generate.py`` writes it."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
FROZEN = ROOT / "tests" / "golden" / "frozen"
PAGE = ROOT / "docs" / "reference" / "json.md"
TYPES = {
    "number": "number",
    "nothing": "null",
    "text": "string",
    "= true": "boolean",
    "= false": "boolean",
}
IGNORED = {"empty", "absent", "table"}


def json_schema() -> str:
    """Return the schemas of all commands, one definition each."""
    text = PAGE.read_text(encoding="utf-8")
    definitions = {}
    for program, command in re.findall(
        r"^## (bristle|python -m benchmarks) (\w+)$", text, flags=re.MULTILINE
    ):
        section = text.split(f"\n## {program} {command}\n")[1].split("\n## ")[0]
        maps = {prefix.replace("[]", "") for prefix in re.findall(r"`([\w.…\[\]]+)\.…", section)}
        files = [
            file
            for file in sorted(FROZEN.glob(f"json_{command}*.json"))
            if re.fullmatch(rf"json_{command}(_\w+)?\.json", file.name)
        ]
        found = [json.loads(file.read_text(encoding="utf-8")).get("json") for file in files]
        if found:
            definitions[command] = _schema(
                [result for result in found if isinstance(result, dict)], "", maps
            )
    heads = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "bristle COMMAND --json",
    }
    return json.dumps(heads | {"$defs": definitions}, indent=1, ensure_ascii=False) + "\n"


def _schema(seen: list[Any], path: str, maps: set[str]) -> dict[str, Any]:
    """Return the schema of values in the words of the skeletons of `tests.golden`."""
    words = {word for item in seen for word in _words(item)} - IGNORED
    types = {TYPES.get(word, "string") for word in words}
    types |= {"null"} if types else set()  # a value that is missing is null
    tables = [item for item in seen if isinstance(item, dict) and not _is_union(item)]
    lists = [item for item in tables if any(name.startswith("[") for name in item)]
    objects = [item for item in tables if item not in lists]
    result: dict[str, Any] = {}
    if lists:
        types.add("array")
        items = _schema([value for item in lists for value in item.values()], path, maps)
        result |= {"items": items} if items else {}
    if objects:
        types.add("object")
        result |= _object(objects, path, maps)
    return (
        {"type": sorted(types) if len(types) > 1 else next(iter(types))} if types else {}
    ) | result


def _object(objects: list[dict[str, Any]], path: str, maps: set[str]) -> dict[str, Any]:
    names = list(dict.fromkeys(name for item in objects for name in item))
    if path in maps:
        return {
            "additionalProperties": _schema(
                [value for item in objects for value in item.values()], f"{path}.…", maps
            )
        }
    of_name = {name: [item[name] for item in objects if name in item] for name in names}
    optional = {
        name
        for name, values in of_name.items()
        if len(values) < len(objects) or any("absent" in _words(value) for value in values)
    }
    properties = {
        name: _schema(values, f"{path}.{name}".lstrip("."), maps)
        for name, values in of_name.items()
    }
    return {"properties": properties, "required": [name for name in names if name not in optional]}


def _is_union(item: dict[str, Any]) -> bool:
    return any(name.startswith("seen: ") for name in item)


def _words(item: Any) -> Iterable[str]:
    if isinstance(item, dict):
        return [name.removeprefix("seen: ") for name in item] if _is_union(item) else []
    return [item]
