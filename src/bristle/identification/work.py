"""The progress of an identification, in durations of the fit of a model with a state."""

from dataclasses import dataclass

from bristle.core.edge import Progress
from bristle.identification.least_squares import Report

PREPARING = 4.0  # before the first fit, measured on logs of 10 s to 30 s at 1 kHz


@dataclass
class Work:
    """The progress of an identification: work `done` up to the end of the present task, and work `ahead` [fits]."""

    progress: Progress | None
    ahead: float
    completed: float = PREPARING
    reported: float = 0.0
    before: str = ""  # text in front of each task

    def task(self, weight: float, text: str) -> Report:
        """Begin a task, and return its report."""
        begun, task = self.completed, f"{self.before}{text}"
        self.completed += weight
        self.ahead = max(self.ahead - weight, 0.0)

        def report(share: float, remark: str = "") -> None:
            if self.progress is not None:
                self.reported = max((begun + weight * share) / (self.completed + self.ahead), self.reported)
                self.progress(self.reported, f"{task}{remark and f', {remark}'}")

        return report
