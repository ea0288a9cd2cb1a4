"""Studies: thousands of runs of an experiment, drawn, labelled, kept whole, and gone on with after an interruption."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bristle.study.dataset import read_study
    from bristle.study.plan import Study
    from bristle.study.read import read_study_file
    from bristle.study.run import run_study

__all__ = ["Study", "read_study", "read_study_file", "run_study"]

_FROM = {"Study": "plan", "read_study": "dataset", "read_study_file": "read", "run_study": "run"}


def __getattr__(name: str) -> Any:
    if name in _FROM:
        return getattr(importlib.import_module(f"bristle.study.{_FROM[name]}"), name)
    raise AttributeError(f"module 'bristle.study' has no attribute {name!r}")
