"""What decides over the last bits of a number: the processor, and the libraries that know several of them.

Elsewhere the last bits differ, a search that stops by a tolerance makes them into the seventh digit, and a parameter
that a log hardly tells may end at the other side of a verdict. So numbers are compared where they were frozen.
"""

from __future__ import annotations

import json
from importlib.metadata import version
from pathlib import Path

import scipy.linalg  # noqa: F401  (it brings a library of its own, which must be there to be told)
from llvmlite.binding import get_host_cpu_name
from threadpoolctl import threadpool_info

MADE_ON = Path(__file__).parent / "made_on.json"


def here() -> dict[str, str]:
    """Return processor and libraries, by name."""
    blas = sorted(f"{one['version']} {one['architecture']}" for one in threadpool_info() if one["user_api"] == "blas")
    libraries = {name: version(name) for name in ("numpy", "scipy", "numba")}
    return {"processor": get_host_cpu_name(), "blas": ", ".join(blas), **libraries}


def elsewhere() -> str:
    """Return what is not as it was where the numbers were frozen, in words; nothing where all is."""
    was, now = json.loads(MADE_ON.read_text(encoding="utf-8")), here()
    return "; ".join(f"{name} {was.get(name)}, here {one}" for name, one in now.items() if was.get(name) != one)
