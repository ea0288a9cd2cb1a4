"""Logs of motion axes: recorded channels with units, and readers of log files."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.logs.break_away import BreakAway
    from bristle.logs.catalogue import FORMATS
    from bristle.logs.check import checked
    from bristle.logs.curves import Curves
    from bristle.logs.filters import low_passed
    from bristle.logs.formats import reading
    from bristle.logs.listing import LogFile, listed_logs
    from bristle.logs.log import Channel, Log, is_table
    from bristle.logs.passages import Passage, holds, passages
    from bristle.logs.readers import read_log
    from bristle.logs.summary import summarize
    from bristle.logs.turns import period_of

__getattr__ = loaded_from(__name__)
