"""Files that people write and results that bristle writes: axes, models and experiments in TOML."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.core.lazy import loaded_from

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

__getattr__ = loaded_from(
    __name__,
    {
        "read_log": "arguments",
        "read_axis": "axis",
        "read_curves": "curves",
        "read_experiment": "experiment",
        "read_model": "model",
        "write_model": "model",
        "Proposal": "proposal",
        "propose_axis": "proposal",
        "load_code": "user_model",
        "load_slot_file": "user_model",
        "load_model_file": "user_model",  # former name of load_code, until the next release
    },
)
