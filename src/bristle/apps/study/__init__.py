"""Studies: thousands of runs of an experiment with drawn values, stored with labels, resumable after an interruption."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.apps.study.plan import Study
    from bristle.apps.study.read import read_study_file
    from bristle.apps.study.run import run_study
    from bristle.apps.study.store import read_study

__getattr__ = loaded_from(__name__)

__all__ = ["Study", "read_study", "read_study_file", "run_study"]
