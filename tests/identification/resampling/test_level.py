"""The level may scatter invisibly; rows next to reversals do not show it."""

import numpy as np
import pytest

from bristle.identification.bootstrap import ChiSquare, Level, Levels
from bristle.identification.half_cycles import Groups


def test_without_apparent_scatter_the_ratio_gives_the_scatter():
    level = Level(0.04, 0.0, 1.0, ChiSquare(0.04, 9.0))
    assert level.scatter() == pytest.approx(0.2)
    for deviation in (0.5, 2.0):
        assert level.scatter(deviation) == pytest.approx(0.2 / deviation)
        assert level.visible_of(level.scatter(deviation)) == pytest.approx(0.2 / deviation)


def test_an_invisible_scatter_may_exist():
    level = Level(0.9, 1.0, 0.5, ChiSquare(1.0, 8.0))
    assert level.scatter() == level._replace(gain=0.0).scatter() == 0.0
    assert level.scatter(level.squares.deviation(0.025)) > 0.5
    assert level.scatter(level.squares.deviation(0.975)) == 0.0


@pytest.mark.parametrize("corner", [0.0, 5.0])
def test_errors_next_to_reversals_are_not_scatter(corner):
    rng, count, rows = np.random.default_rng(4), 24, 40
    cycles, place = Groups(np.repeat(np.arange(count), rows)), np.tile(np.arange(rows), count)
    slope, away = np.where(cycles.of_rows % 2, -1.0, 1.0), (place > 4) & (place < rows - 4)
    levels = 0.05 * rng.standard_normal(count)
    residual = levels[cycles.of_rows] * slope + 0.01 * rng.standard_normal(slope.size)
    residual += np.where(away, 0.0, corner * rng.standard_normal(slope.size))
    assert Levels.of(cycles, slope, away).scatter(residual) == pytest.approx(np.std(levels), rel=0.1)


def test_all_rows_count_if_most_half_cycles_have_no_rows_away_from_reversals():
    cycles = Groups(np.repeat(np.arange(10), 20))
    assert Levels.of(cycles, np.ones(200), cycles.of_rows < 4).rows.all()
    assert not Levels.of(cycles, np.ones(200), cycles.of_rows < 6).rows.all()
