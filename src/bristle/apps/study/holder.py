"""The process that holds the Dask cluster of this machine. It imports little, so that the cluster is ready soon."""

import os
import pickle
import signal
import sys
from tempfile import TemporaryDirectory

from bristle.core import library


def hold_cluster() -> None:
    """Hold a Dask cluster of this machine as described on the input, answer with its address, and end with the input.

    The input also ends if the command is killed, and then the temporary files go, too.
    """
    # Ctrl-C reaches all processes of a terminal: the command ends this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # keep prints of user models out of the answers
    with TemporaryDirectory(prefix="bristle-", ignore_cleanup_errors=True) as folder:
        os.environ["DASK_TEMPORARY_DIRECTORY"] = folder  # before the options load Dask
        options = pickle.load(sys.stdin.buffer)
        distributed = library("distributed", "bristle study")
        with distributed.LocalCluster(
            threads_per_worker=1,
            memory_limit=None,
            dashboard_address=None,
            scheduler_kwargs={"dashboard_address": "127.0.0.1:0", "dashboard": False},
            **options,
        ) as cluster:
            print(cluster.scheduler_address, file=answers, flush=True)
            sys.stdin.buffer.read()
