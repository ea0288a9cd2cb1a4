"""The limits of the served lab are those that its page tells."""

import re
from pathlib import Path

import pytest

from bristle.server.limits import Limits

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "identify-in-the-browser.md"
MIB, GIB = 2**20, 2**30


@pytest.mark.parametrize(
    ("row", "words", "limits"),
    [
        (
            "size of a log; of all logs",
            "512 MiB, or `BRISTLE_SIZE_LIMIT`; four times this size",
            {"file_size": 512 * MIB, "total_size": 4 * 512 * MIB},
        ),
        ("analyses; logs in each", "16; 32", {"cases": 16, "files": 32}),
        (
            "jobs at once; time and memory of each",
            "2; one hour, 16 GiB of address space",
            {"jobs": 2, "job_seconds": 3600.0, "job_memory": 16 * GIB},
        ),
        ("silence within a request", "10 s", {"silence_seconds": 10.0}),
        (
            "connections without the token; their time for a request",
            "32 (a new connection replaces the oldest); 3 s",
            {"strangers": 32, "stranger_seconds": 3.0},
        ),
    ],
)
def test_limits_are_those_of_the_page(row, words, limits):
    assert dict(re.findall(r"^\| (.+?) \| (.+?) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE))[row] == words
    assert {name: getattr(Limits(), name) for name in limits} == limits


def test_a_job_has_a_minute_to_end_and_a_message_a_mebibyte():
    assert (Limits().grace_seconds, Limits().body_size) == (60.0, MIB)
