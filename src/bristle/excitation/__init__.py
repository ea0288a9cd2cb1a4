"""Motions to record, and what they will identify."""

from bristle.excitation.foresight import Foresight, foreseen, prior_of
from bristle.excitation.plan import Experiment, Frame, Plan, frame_of, planned

__all__ = ["Experiment", "Foresight", "Frame", "Plan", "foreseen", "frame_of", "planned", "prior_of"]
