"""Files that people write and results that bristle writes: axes, models and experiments in TOML."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bristle.files.arguments import read_log
    from bristle.files.axis import read_axis
    from bristle.files.curves import read_curves
    from bristle.files.experiment import read_experiment
    from bristle.files.model import read_model, write_model
    from bristle.files.proposal import Proposal, propose_axis
    from bristle.files.user_model import load_code, load_slot_file

__all__ = [
    "Proposal",
    "load_code",
    "load_slot_file",
    "propose_axis",
    "read_axis",
    "read_curves",
    "read_experiment",
    "read_log",
    "read_model",
    "write_model",
]

_FROM = {
    "Proposal": "proposal",
    "propose_axis": "proposal",
    "load_code": "user_model",
    "load_model_file": "user_model",  # former name of load_code, until the next release
    "load_slot_file": "user_model",
    "read_axis": "axis",
    "read_curves": "curves",
    "read_experiment": "experiment",
    "read_log": "arguments",
    "read_model": "model",
    "write_model": "model",
}


def __getattr__(name: str) -> Any:
    if name in _FROM:
        return getattr(importlib.import_module(f"bristle.files.{_FROM[name]}"), name)
    raise AttributeError(f"module 'bristle.files' has no attribute {name!r}")
