"""`Limits`: largest resources for requests of a browser."""

from dataclasses import dataclass

from bristle.core import SIZE_LIMIT


@dataclass(frozen=True)
class Limits:
    """Limits of requests, so that a browser cannot exhaust the machine.

    Parameters
    ----------
    file_size : int
        Largest file [byte].
    total_size : int
        All files of all analyses together [byte].
    body_size : int
        Largest message other than a file [byte].
    files : int
        Files of one analysis.
    cases : int
        Open analyses.
    jobs : int
        Jobs at the same time.
    job_seconds : float
        Time of a job; an identification then ends with its best result [s].
    grace_seconds : float
        Time for a job to end on request [s].
    job_memory : int
        Address space of a job [byte].
    silence_seconds : float
        Longest silence of a client within a request, sending or reading [s].
    strangers : int
        Connections without the token, or without any request yet. The oldest is dropped for a new connection.
    stranger_seconds : float
        Time of such a connection for the lines of a request, or for the rest of an answered request [s].
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
