"""Whether the effort of a log has the right sign: friction takes energy out, it never puts any in."""

from __future__ import annotations

from bristle.core.edge import guarded, instance
from bristle.logs.check.sign import work_share
from bristle.logs.check.thresholds import DEFAULT
from bristle.logs.log_data import LogData

__all__ = ["REVERSED", "sign_of_effort"]

REVERSED = (
    "the sign of effort seems reversed: over closed motion, friction would put energy in; "
    "turn its sign in the axis file (sign = -1 where it has none or 1, else 1)"
)


@guarded(log=instance(LogData, "a log", "Write read_log(...)"))
def sign_of_effort(log: LogData) -> str | None:
    """Return a warning if the effort of `log` seems to have the wrong sign, else None."""
    if log.effort is None:
        return None
    return REVERSED if work_share(log) < -DEFAULT.reversed_work else None
