"""The loop of an experiment before it is built: poles and margins, what it errs by, and which gains it allows."""

from bristle.loop.assessment import PHASE_ENOUGH, Assessment, Verdict, WorkingPoint, assess, doubts_of, runnable, verdict_of
from bristle.loop.budget import Budget, error_budget
from bristle.loop.design import Circle, Design, design, run_circles
from bristle.loop.tuning import UNSTATED, Delays, Proposal, delays_of, proposals_for

__all__ = [
    "PHASE_ENOUGH",
    "UNSTATED",
    "Assessment",
    "Budget",
    "Circle",
    "Delays",
    "Design",
    "Proposal",
    "Verdict",
    "WorkingPoint",
    "assess",
    "delays_of",
    "design",
    "doubts_of",
    "error_budget",
    "proposals_for",
    "run_circles",
    "runnable",
    "verdict_of",
]
