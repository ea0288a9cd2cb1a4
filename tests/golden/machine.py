"""The parts of a machine that change the last bits of a number: the processor, and libraries with several kernels.

On another machine the last bits differ, and a search that stops at a tolerance may then change the fifth digit. So each
case has a smaller tolerance on the machine on which it was frozen.
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
    blas = sorted(
        f"{item['version']} {item['architecture']}"
        for item in threadpool_info()
        if item["user_api"] == "blas"
    )
    libraries = {name: version(name) for name in ("numpy", "scipy", "numba")}
    return {"processor": get_host_cpu_name(), "blas": ", ".join(blas), **libraries}


def elsewhere(case: str) -> str:
    """Return what is not as it was where a case was frozen, in words; nothing where all is."""
    was, now = json.loads(MADE_ON.read_text(encoding="utf-8")).get(case, {}), here()
    return "; ".join(
        f"{name} {was.get(name)}, here {item}"
        for name, item in now.items()
        if was.get(name) != item
    )


def note(case: str) -> None:
    """Note that a case was frozen here."""
    made = json.loads(MADE_ON.read_text(encoding="utf-8")) | {case: here()}
    lines = [f" {json.dumps(name)}: {json.dumps(facts)}" for name, facts in sorted(made.items())]
    MADE_ON.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
