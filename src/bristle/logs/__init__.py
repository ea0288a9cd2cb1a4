"""Logs of motion axes: what was recorded, with units, and the readers of the files that hold it."""

from bristle.logs.check import checked
from bristle.logs.log import Channel, Log
from bristle.logs.passages import passages
from bristle.logs.readers import read_log
from bristle.logs.summary import summarize

__all__ = ["Channel", "Log", "checked", "passages", "read_log", "summarize"]
