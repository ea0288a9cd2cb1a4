"""What a call from Python may give for an axis, a log or an experiment: the thing, or the file that describes it."""

from __future__ import annotations

from typing import Any

from bristle.core.axis import Axis
from bristle.core.edge import Converter, instance
from bristle.core.experiment import Experiment
from bristle.logs.log import Log

__all__ = ["AXIS", "EXPERIMENT", "LOG"]


# Readers bring what checks files, which a call that hands in the thing itself need not wait for.
def _read_axis(source: Any) -> Any:
    from bristle.files.axis import read_axis

    return read_axis(source)


def _read_experiment(source: Any) -> Any:
    from bristle.files.experiment import read_experiment

    return read_experiment(source)


AXIS: Converter = instance(Axis, "an axis or its file", read=_read_axis)
EXPERIMENT: Converter = instance(Experiment, "an experiment or its file", read=_read_experiment)
LOG: Converter = instance(Log, "a log", 'Write read_log("axis.csv", axis)')
