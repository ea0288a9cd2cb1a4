"""Sampled loops as linear systems: poles, margins, and what they say before anything is simulated."""

from bristle.stability.assessment import Assessment, Friction, Motions, Verdict, WorkingPoint, assess, top_speed
from bristle.stability.margins import margins_of
from bristle.stability.sampled_loop import SampledLoop
from bristle.stability.verdict import PHASE_ENOUGH, doubts_of, runnable, verdict_of

__all__ = [
    "PHASE_ENOUGH",
    "Assessment",
    "Friction",
    "Motions",
    "SampledLoop",
    "Verdict",
    "WorkingPoint",
    "assess",
    "doubts_of",
    "margins_of",
    "runnable",
    "top_speed",
    "verdict_of",
]
