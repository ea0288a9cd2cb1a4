"""Blocks of a study on another machine: what is called there, of the plan that came with the call.

Nothing of the cluster is imported here, and no file of the study is read: the plan holds what was read of them.
"""

from __future__ import annotations

import hashlib
import pickle
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from bristle.core.cores import cores_for_simulations
from bristle.core.locks import LOADING
from bristle.study.block import Simulator
from bristle.study.plan import Block
from bristle.study.worker import outcome_of

__all__ = ["LIBRARIES", "UNFIT", "checksum_of_code", "described", "simulated"]

LIBRARIES = ("numpy", "scipy", "numba")
UNFIT = "unfit"
LETTERS = 12
KEPT = 4  # studies, the last ones

_simulators: dict[str, Simulator] = {}


@cache
def described() -> dict[str, str]:
    """Return what computes in this process: version and code of bristle, versions of its libraries."""
    names = {name: version(name) for name in ("bristle", *LIBRARIES)}
    return names | {"code": checksum_of_code(Path(__file__).parents[1])}


def checksum_of_code(root: Path) -> str:
    """Return the first letters of a SHA-256 over the Python below a folder: two copies may say the same version."""
    digest = hashlib.sha256()
    for name in sorted(file.relative_to(root).as_posix() for file in root.rglob("*.py")):
        content = (root / name).read_bytes().replace(b"\r\n", b"\n")
        digest.update(f"{name} {hashlib.sha256(content).hexdigest()} ".encode())
    return digest.hexdigest()[:LETTERS]


def simulated(plan: bytes, checksum: str, code: str, first: int, last: int) -> tuple[str, Any]:
    """Return what is kept of a block, as a worker of this machine tells it; of a bristle that is unfit, that it is."""

    def columns() -> dict[str, Any]:
        with cores_for_simulations():
            return _simulator(plan, checksum).columns(Block(first, last))

    return outcome_of(columns) if described()["code"] == code else (UNFIT, None)


def _simulator(plan: bytes, checksum: str) -> Simulator:
    """Return the simulator of a study, made once in this process."""
    with LOADING:
        if checksum not in _simulators:
            if hashlib.sha256(plan).hexdigest() != checksum:
                raise ValueError("the study did not arrive as it was sent")
            while len(_simulators) >= KEPT:
                del _simulators[next(iter(_simulators))]
            _simulators[checksum] = Simulator(pickle.loads(plan))
        return _simulators[checksum]
