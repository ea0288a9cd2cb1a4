"""The limits of the served lab are those that its page tells."""

import re
from pathlib import Path

from bristle.server.limits import Limits

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "identify-in-the-browser.md"
MIB, GIB = 2**20, 2**30


def test_limits_are_those_of_the_page():
    limits = Limits()
    rows = dict(re.findall(r"^\| (.+?) \| (.+?) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE))
    assert rows["size of a log; of all logs"].startswith("512 MiB,")
    assert rows["size of a log; of all logs"].endswith("four times this size")
    assert (limits.file_size, limits.total_size) == (512 * MIB, 4 * 512 * MIB)
    assert rows["analyses; logs in each"] == "16; 32"
    assert (limits.cases, limits.files) == (16, 32)
    assert rows["jobs at once; time and memory of each"] == "2; one hour, 16 GiB of address space"
    assert (limits.jobs, limits.job_seconds, limits.job_memory) == (2, 3600.0, 16 * GIB)
    assert rows["silence within a request"] == "10 s"
    assert limits.silence_seconds == 10.0
    assert rows["connections without the token; their time for a request"] == "32 (a new connection replaces the oldest); 3 s"
    assert (limits.strangers, limits.stranger_seconds) == (32, 3.0)


def test_a_job_has_a_minute_to_end_and_a_message_a_mebibyte():
    limits = Limits()
    assert (limits.grace_seconds, limits.body_size) == (60.0, MIB)
    assert limits.grace_seconds < limits.job_seconds
