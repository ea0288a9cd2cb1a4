"""When a log was recorded: by the one date in its name, else in that of its folder."""

from datetime import UTC, datetime

import pytest

from bristle.logs.listing import recorded_at


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
        (("25.03.2026.csv", ""), None),
        (("axis_3_1_2026-03-01T06-30.csv", ""), (2026, 3, 1, 6, 30)),
        (("x_2026-03-01_amended.csv", ""), (2026, 3, 1)),
        (("serial_120260301.csv", ""), None),
        (("x_20261301.csv", ""), None),
        (("run_7.csv", "press"), None),
    ],
)
def test_a_name_has_a_single_date(names, expected):
    assert recorded_at(*names) == (
        None if expected is None else datetime(*expected, tzinfo=UTC).timestamp()
    )
