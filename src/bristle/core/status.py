"""Outcomes of a computation: kernels return these codes instead of exceptions; each code has a sentence."""

from enum import IntEnum


class Status(IntEnum):
    """Outcome of a computation; a larger code is more severe."""

    OK = 0
    SOLVE_INACCURATE = 1
    TOLERANCE_MISSED = 2
    MEMORY_OVERFLOW = 3
    NOT_FINITE = 4

    @property
    def sentence(self) -> str:
        """Sentence for the code."""
        return SENTENCES[self]


SENTENCES = {
    Status.OK: "completed",
    Status.SOLVE_INACCURATE: (
        "the implicit step did not converge to its tolerance at least once; use a smaller step (more substeps)"
    ),
    Status.TOLERANCE_MISSED: (
        "the adaptive step reached its smallest length before its error was small enough; "
        "increase the tolerance, or look for jumps in the input"
    ),
    Status.MEMORY_OVERFLOW: (
        "the memory of turning points overflowed and lost its innermost pair; increase its capacity"
    ),
    Status.NOT_FINITE: "the simulation gave numbers that are not finite: the loop or the model is unstable",
}
