"""Studies: thousands of runs of an experiment with drawn values, stored with labels, resumable after an interruption."""

from typing import TYPE_CHECKING

from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.study.plan import Study
    from bristle.study.read import read_study_file
    from bristle.study.run import run_study
    from bristle.study.store import read_study

__getattr__ = loaded_from(__name__)

__all__ = ["Study", "read_study", "read_study_file", "run_study"]
