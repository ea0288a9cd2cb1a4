"""The source paper as experiments: every figure reproduced, every claim tested, every error corrected with a test."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.apps.paper.page import paper_report, paper_summary
    from bristle.apps.paper.reproduction import FIGURES, reproduce
    from bristle.apps.paper.setting import EXPERIMENTS, write_experiments

__getattr__ = loaded_from(__name__)

__all__ = [
    "EXPERIMENTS",
    "FIGURES",
    "paper_report",
    "paper_summary",
    "reproduce",
    "write_experiments",
]
