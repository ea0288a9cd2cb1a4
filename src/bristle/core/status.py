"""What can happen while computing: codes that kernels return, for they never raise, with a sentence for people."""

from enum import IntEnum


class Status(IntEnum):
    """Outcome of a computation; codes other than `OK` rank by severity."""

    OK = 0
    SOLVE_INACCURATE = 1
    TOLERANCE_MISSED = 2
    MEMORY_OVERFLOW = 3
    NOT_FINITE = 4

    @property
    def sentence(self) -> str:
        """The code in words."""
        return SENTENCES[self]


SENTENCES = {
    Status.OK: "completed",
    Status.SOLVE_INACCURATE: ("the implicit step did not converge to its tolerance at least once; use a smaller step (more substeps)"),
    Status.TOLERANCE_MISSED: (
        "the adaptive step reached its smallest length before its error was small enough; "
        "ask for a larger tolerance, or look for what jumps"
    ),
    Status.MEMORY_OVERFLOW: ("the memory of turning points overflowed and forgot its innermost pair; raise its capacity"),
    Status.NOT_FINITE: "the simulation left the finite numbers: the loop or the model is unstable",
}
