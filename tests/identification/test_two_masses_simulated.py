"""Elastic drives of an independent simulator, with friction on both sides, loops, delays and encoders."""

import pytest
from benchmarks.elastic import tried

SEEDS = (501, 504, 505, 509, 510, 511)  # without and with play; `benchmarks.elastic` measures the rates over sixty drives


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_an_elastic_drive_is_reported_first_and_a_rigid_axis_is_not(seed):
    drive, rigid = tried(seed, True), tried(seed, False)
    assert drive.reported
    assert drive.first
    assert not drive.suggested
    assert abs(drive.antiresonance) < 5.0
    assert abs(drive.resonance) < 5.0
    assert not rigid.reported
