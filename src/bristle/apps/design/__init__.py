"""Analysis of a loop before it is built: poles, margins, error budget, and possible gains."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.apps.design.analysis import Circle, Design, design, run_circles
    from bristle.apps.design.budget import Budget, error_budget
    from bristle.simulation import (
        Assessment,
        Delays,
        Proposal,
        Verdict,
        WorkingPoint,
        assess,
        delays_of,
        proposals_for,
        runnable,
    )

__getattr__ = loaded_from(__name__)
