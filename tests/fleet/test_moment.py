"""When a log was recorded: told by its name or its head, or not at all."""

from datetime import UTC, datetime

import pytest

from bristle.fleet.moment import moment_of


def seconds(*parts):
    return datetime(*parts, tzinfo=UTC).timestamp()


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (("x_2026-03-01.csv", ""), (2026, 3, 1)),
        (("x_20260301_0630.csv", ""), (2026, 3, 1, 6, 30)),
        (("x_2026-03-01T06-30-15.csv", ""), (2026, 3, 1, 6, 30, 15)),
        (("2026_03_01 06.30.csv", ""), (2026, 3, 1, 6, 30)),
        (("log.csv", "2026-03-01"), (2026, 3, 1)),
        (("2026-03-02.csv", "2026-03-01"), (2026, 3, 2)),
        (("2026-03-01_to_2026-03-04.csv", "2026-03-01"), None),
        (("01.03.2026.csv", ""), None),
        (("25.03.2026.csv", ""), (2026, 3, 25)),
        (("test-9-11-2019-10-28-30 AM.csv", ""), None),
        (("test-9-11-2019-10-28.csv", "2019-11-09"), None),
        (("test-9-25-2019-10-28-30 AM.csv", ""), (2019, 9, 25, 10, 28, 30)),
        (("test-25-9-2019-10-28-30 PM.csv", ""), (2019, 9, 25, 22, 28, 30)),
        (("test-9-9-2019 9-05-30 AM.csv", ""), (2019, 9, 9, 9, 5, 30)),
        (("test_9-25-2019_12-05_am.csv", ""), (2019, 9, 25, 0, 5)),
        (("test 2019-09-25 12.05 PM.csv", ""), (2019, 9, 25, 12, 5)),
        (("test 2019-09-25 13.05 PM.csv", ""), None),
        (("test-25-9-2019-12-28-90.csv", ""), None),
        (("axis_3_1_2026-03-01T06-30.csv", ""), (2026, 3, 1, 6, 30)),
        (("axis_3_1_2026-03-01.csv", ""), None),
        (("axis_7_2026-03-01.csv", ""), (2026, 3, 1)),
        (("x_2026-03-01_amended.csv", ""), (2026, 3, 1)),
        (("serial_120260301.csv", ""), None),
        (("x_20261301.csv", ""), None),
        (("run_7.csv", "press"), None),
    ],
)
def test_a_name_tells_its_one_date(names, expected):
    assert moment_of(names, b"") == (None if expected is None else seconds(*expected))


@pytest.mark.parametrize(
    ("head", "expected"),
    [
        (b"# exported 2026-03-01 06:30:10\ntime,x\n", (2026, 3, 1, 6, 30, 10)),
        (b"time,x\n2026-03-01T06:30:00.5,1\n2026-03-01T06:30:01.5,2\n", (2026, 3, 1, 6, 30)),
        (b"# made 2026-03-04 08:00\n2026-03-01T06:30:00,1\n", None),
        (b"# version of 2026-03-04\n0.0,1\n", None),
        (b"# made 2026-03-04 08:00\n01.03.2026 06:30:00,1\n", None),
        (b"25.03.2026 06:30:00;1\n25.03.2026 06:30:01;2\n", (2026, 3, 25, 6, 30)),
        (b"Name\tScope\nStarttime of export\t133864182720000000\tFriday, 14. March 2025\n", (2025, 3, 14, 9, 31, 12)),
        (b"0.1,2.0\n", None),
    ],
)
def test_a_head_tells_it_where_all_its_times_are_of_one_day(head, expected):
    assert moment_of(("log.csv", "press"), head) == (None if expected is None else seconds(*expected))
