"""The source paper as experiments: every figure reproduced, every claim tested, every error corrected with a test."""

from bristle.paper.page import paper_report, paper_summary
from bristle.paper.reproduce import FIGURES, reproduce
from bristle.paper.setting import EXPERIMENTS, write_experiments

__all__ = ["EXPERIMENTS", "FIGURES", "paper_report", "paper_summary", "reproduce", "write_experiments"]
