"""`Limits`: how much of anything a browser may ask for."""

from dataclasses import dataclass

from bristle.core import SIZE_LIMIT


@dataclass(frozen=True)
class Limits:
    """What is refused beyond, so that nothing a browser sends takes all of the machine.

    Parameters
    ----------
    file_size : int
        Largest file [byte].
    total_size : int
        All files of all analyses together [byte].
    body_size : int
        Largest message that is no file [byte].
    files : int
        Files of one analysis.
    cases : int
        Analyses that are open.
    jobs : int
        Jobs that run at once.
    job_seconds : float
        Time of a job; an identification then ends with the best found so far [s].
    grace_seconds : float
        Time in which a job that was asked to end has to do so [s].
    job_memory : int
        Addresses of a job [byte].
    silence_seconds : float
        How long a client may say nothing, or read nothing, within a request [s].
    strangers : int
        Connections whose last request did not have the token, or that have sent none; the oldest one makes room for a
        new one.
    stranger_seconds : float
        How long one of those may take for the lines of a request, or for the rest of one that was answered [s].
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
