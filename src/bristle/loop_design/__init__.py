"""The design of a loop: what limits it, what it errs by, and what to change."""

from bristle.loop_design.budget import Budget, Entry, error_budget
from bristle.loop_design.circle import Circle, run_circles
from bristle.loop_design.delays import Delays, delays_of
from bristle.loop_design.design import Design, design
from bristle.loop_design.proposals import Proposal, proposals_for
from bristle.loop_design.tuning import tuned

__all__ = [
    "Budget",
    "Circle",
    "Delays",
    "Design",
    "Entry",
    "Proposal",
    "delays_of",
    "design",
    "error_budget",
    "proposals_for",
    "run_circles",
    "tuned",
]
