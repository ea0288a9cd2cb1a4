"""Analysis of a loop before it is built: poles, margins, error budget, and possible gains."""

from typing import TYPE_CHECKING

from bristle.loading import loaded_from
from bristle.loop.design import design

if TYPE_CHECKING:
    from bristle.loop.assessment import Assessment, Verdict, WorkingPoint, assess, runnable
    from bristle.loop.budget import Budget, error_budget
    from bristle.loop.design import Circle, Design, run_circles
    from bristle.loop.tuning import Delays, Proposal, delays_of, proposals_for

__getattr__ = loaded_from(__name__)
