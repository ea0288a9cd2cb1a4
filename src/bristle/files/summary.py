"""Results as JSON, and their provenance: version, files with checksums, and the command to repeat them."""

import json
import math
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from bristle.core import Origin, escaped, printable


def as_json(data: Mapping[str, Any]) -> str:
    r"""Return data as a JSON object in ASCII, with a line end.

    Examples
    --------
    >>> print(as_json({"rms": float("nan"), "unit": "µm"}), end="")
    {
      "rms": null,
      "unit": "\u00b5m"
    }
    """
    return json.dumps(plain(data), indent=2, allow_nan=False) + "\n"


def plain(value: Any) -> Any:
    """Convert a value to the types of JSON: text, finite numbers, lists, tables; numbers that are not finite become None."""
    if isinstance(value, Mapping):
        return {escaped(str(key)): plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):  # arrays and numbers of numpy
        return plain(value.tolist())
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, (int, bool)) or value is None:
        return value
    return escaped(str(value))


def provenance(command: str, **files: Any) -> dict[str, str]:
    """Return the provenance of results; each of `files` is an `Origin`, an object with an origin, a list of these, or None."""
    record = {"bristle": version("bristle")}
    for kind, sources in files.items():
        listed = (
            () if sources is None else sources if isinstance(sources, (list, tuple)) else (sources,)
        )
        for number, source in enumerate(listed, 1):
            key = kind if number == 1 else f"{kind}_{number}"
            origin = source if isinstance(source, Origin) else source.origin
            record |= {key: printable(origin.name), f"{key}_sha256": origin.checksum}
            if part := getattr(source, "part", ""):
                record[f"{key}_part"] = printable(part)
    return record | {"command": command}
