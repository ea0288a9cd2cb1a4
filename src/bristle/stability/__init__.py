"""Sampled loops as linear systems: poles, margins, and what they say before anything is simulated."""

from bristle.stability.assessment import Assessment, Friction, Motions, Verdict, WorkingPoint, assess, top_speed
from bristle.stability.linear_friction import NO_FRICTION
from bristle.stability.margins import Margins, margins_of
from bristle.stability.sampled_loop import SampledLoop
from bristle.stability.verdict import PHASE_ENOUGH, doubts_of, runnable, verdict_of

__all__ = [
    "NO_FRICTION",
    "PHASE_ENOUGH",
    "Assessment",
    "Friction",
    "Margins",
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
