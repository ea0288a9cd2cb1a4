"""The process that holds the Dask cluster of this machine. It imports little, so that the cluster is ready soon."""

import os
import pickle
import signal
import sys

from bristle.core import library


def hold_cluster() -> None:
    """Hold a Dask cluster of this machine as described on the input, answer with its address, and end with the input."""
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C reaches all processes of a terminal: the command ends this one
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # keep prints of user models out of the answers
    options = pickle.load(sys.stdin.buffer)
    distributed = library("distributed", "bristle study")
    with distributed.LocalCluster(
        threads_per_worker=1, memory_limit=None, dashboard_address=None, **options
    ) as cluster:
        print(cluster.scheduler_address, file=answers, flush=True)
        sys.stdin.buffer.read()
