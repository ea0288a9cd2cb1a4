"""Friction models with uncertainty from a log."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.identification.axis_lines import axis_with, proposed_lines
    from bristle.identification.estimate import OPEN, Estimate, half_width
    from bristle.identification.explain import explain
    from bristle.identification.explanation import Explanation
    from bristle.identification.identify import identify
    from bristle.identification.known_truth import Determined
    from bristle.identification.request import models_of, prior_knowledge_of, refuse_options
    from bristle.identification.result import (
        Bands,
        Fit,
        HeldOut,
        Identification,
        ProposedLine,
        SecondPass,
    )
    from bristle.identification.settings import Settings
    from bristle.identification.work import Work

__getattr__ = loaded_from(__name__)
