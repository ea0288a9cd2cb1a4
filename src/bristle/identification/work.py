"""The progress of work as a share of its time, from which the remaining time follows."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from time import perf_counter

from bristle.core.edge import Progress


@dataclass
class Work:
    """Tasks, one after the other; `ahead` is the duration of all tasks after the present one [s], infinite while it is unknown."""

    progress: Progress
    ahead: float = inf
    begun: float = field(default_factory=perf_counter)
    after_fits: float = inf  # duration of the tasks after all fits [s]
    # Duration of each fit so far, per parameter of its model [s]
    paces: list[float] = field(default_factory=list)

    def lasting(self, parameters: int) -> float:
        """Return the expected duration of fits of models with so many parameters together [s]."""
        # The first models are mostly the slowest, and few take several times as long as others: a third was faster than this pace.
        return parameters * sorted(self.paces or [0.0])[(len(self.paces) - 1) // 3]

    def task(self, text: str = "", expected: float = inf) -> Callable[..., None]:
        """Begin a task that is `expected` to last some seconds, else as long as its share of the time tells; return its report."""
        begun = perf_counter()

        def report(share: float, remark: str = "") -> None:
            now = perf_counter()
            # The measured duration replaces the expected one little by little.
            lasts = (
                (now - begun) / share
                if expected == inf and share
                else now - begun + (1.0 - share) * expected
            )
            done, left = now - self.begun, self.ahead + (1.0 - share) * lasts
            self.progress(
                done / (done + left) if left else 1.0, ", ".join(filter(None, (text, remark)))
            )

        return report
