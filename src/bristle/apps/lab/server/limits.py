"""`Limits`: largest resources for requests of a browser, and the refusal of a request."""

from dataclasses import dataclass
from typing import Any

from bristle.core import SIZE_LIMIT, InputError

# Jobs that may write on a machine: they end themselves, when the machine is restored.
RESTORING = ("plan", "tune", "undo")


@dataclass(frozen=True)
class Limits:
    """Limits of requests, so that a browser cannot exhaust the machine.

    Parameters
    ----------
    file_size : int
        Largest file [byte].
    total_size : int
        Largest total size of the files of all analyses [byte].
    body_size : int
        Largest message other than a file [byte].
    files : int
        Largest number of files in one analysis.
    cases : int
        Largest number of open analyses.
    jobs : int
        Largest number of jobs that run at the same time.
    job_seconds : float
        Longest time of a job [s]. An identification ends before this time with its best result.
    grace_seconds : float
        Time that a job has between the request to end and its forced end [s].
    job_memory : int
        Largest address space of a job [byte].
    silence_seconds : float
        Longest time within a request in which a client neither sends nor reads data [s].
    strangers : int
        Largest number of connections without the token, or without a request so far. For a new one, the server drops the oldest.
    stranger_seconds : float
        Longest time that such a connection has for a request [s].
    """

    file_size: int = SIZE_LIMIT
    total_size: int = 4 * SIZE_LIMIT
    body_size: int = 2**20
    files: int = 32
    cases: int = 16
    jobs: int = 2
    job_seconds: float = 3600.0
    grace_seconds: float = 60.0
    job_memory: int = 16 * 2**30
    silence_seconds: float = 10.0
    strangers: int = 32
    stranger_seconds: float = 3.0


class RefusedRequestError(InputError):
    """A refused request; `status` is the HTTP status."""

    def __init__(self, status: int, message: str, **facts: Any) -> None:
        self.status = status
        super().__init__(message, **facts)
