"""What an experiment file identifies, before a command reads it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from bristle.cli.terminal import complain

if TYPE_CHECKING:
    from bristle.core.experiment import Experiment

__all__ = ["experiment_in"]


def experiment_in(path: Path, *, allow_code: bool, size_limit: int, progress: Callable[[float, str], None] | None = None) -> Experiment:
    """Return the experiment in a file; what it identifies is identified where it is not there, and said."""
    from bristle.core.content import content_of
    from bristle.files.experiment import read_experiment
    from bristle.files.toml import TOML_LIMIT
    from bristle.workflow.pipeline import prepare

    content = content_of(path, limit=TOML_LIMIT, path="experiment", what="an experiment file")
    for model in prepare(content, allow_code=allow_code, size_limit=size_limit, progress=progress):
        if model.best is None:
            complain(f"{model.name}: as identified before, {model.folder}")
        else:
            error = f"{model.best.name}, error {model.best.error_percent:.3g} %"
            complain(f"{model.name}: identified ({error}); see {model.folder / 'report.html'}")
    return read_experiment(content, allow_code=allow_code, size_limit=size_limit)
