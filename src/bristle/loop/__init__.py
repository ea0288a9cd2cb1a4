"""The loop of an experiment before it is built: poles and margins, what it errs by, and which gains it allows."""

from bristle.loop.assessment import Assessment, Verdict, WorkingPoint, assess
from bristle.loop.budget import Budget, error_budget
from bristle.loop.circle import Circle, run_circles
from bristle.loop.design import Design, design
from bristle.loop.proposals import Proposal, proposals_for
from bristle.loop.tuning import UNSTATED, Delays, delays_of
from bristle.loop.verdict import PHASE_ENOUGH, doubts_of, runnable, verdict_of

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
