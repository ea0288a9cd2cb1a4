"""What checks of a log compute with: one filter for all channels, lines through them, work, lost rows."""

import numpy as np
import pytest
from tests.identification.known_logs import Motion, log_of

from bristle.logs.lines import Line, _piled, lost_in, piled_up, rows_of, work_share

DT = 1e-3


def log_along(position, effort, step=1e-7):
    time = DT * np.arange(position.size)
    velocity = np.gradient(position, DT)
    return log_of(Motion(time, position, velocity, np.gradient(velocity, DT)), effort, step=step)


def swing(count=6000, frequency=1.0, reach=0.05):
    return reach * np.sin(2.0 * np.pi * frequency * DT * np.arange(count))


def test_all_channels_of_a_row_belong_to_one_instant():
    x = 0.3 + swing()
    rows = rows_of(log_along(x, np.sin(2.0 * np.pi * DT * np.arange(x.size))), 1e-7)
    phase = 2.0 * np.pi * rows.time
    for channel, values, error in (
        (rows.position, 0.3 + 0.05 * np.sin(phase), 2e-4),
        (rows.velocity, 0.05 * 2.0 * np.pi * np.cos(phase), 2e-3),
        (rows.acceleration, -0.05 * (2.0 * np.pi) ** 2 * np.sin(phase), 1e-2),
        (rows.effort, np.sin(phase), 4e-3),
        (rows.rate, 2.0 * np.pi * np.cos(phase), 4e-2),
    ):
        np.testing.assert_allclose(channel, values, atol=error)
    assert rows.recorded.size == 0


def test_a_line_is_exact_for_columns_that_make_the_effort():
    rng = np.random.default_rng(1)
    columns = rng.standard_normal((600, 3)) * [1.0, 1e6, 1e-6]
    line = Line.through(columns, columns @ np.array([2.0, -3e-6, 4e6]))
    assert line.coefficients == pytest.approx([2.0, -3e-6, 4e6])
    assert line.deviations == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
    assert line.explained == pytest.approx(1.0)
    assert line.last == pytest.approx((4e6, 0.0), abs=1e-3)


def test_errors_of_a_line_are_those_of_white_noise():
    rng = np.random.default_rng(2)
    column = rng.standard_normal((6000, 1))
    lines = [
        Line.through(column, column[:, 0] + 2.0 * rng.standard_normal(6000)) for _ in range(20)
    ]
    expected = 2.0 / np.sqrt(6000)
    assert np.mean([line.last[1] for line in lines]) == pytest.approx(expected, rel=0.2)
    assert np.std([line.last[0] for line in lines]) == pytest.approx(expected, rel=0.5)
    assert np.mean([line.explained for line in lines]) == pytest.approx(1.0 / 5.0, rel=0.1)


COLUMN = np.random.default_rng(3).standard_normal(200)


@pytest.mark.parametrize(
    ("columns", "effort", "is_line"),
    [
        (np.column_stack([COLUMN, 2.0 * COLUMN]), COLUMN, False),
        (np.column_stack([COLUMN, 0.0 * COLUMN]), COLUMN, False),
        (COLUMN[:119, None], COLUMN[:119], False),
        (COLUMN[:120, None], COLUMN[:120], True),
    ],
)
def test_a_line_needs_enough_rows_and_independent_columns(columns, effort, is_line):
    assert (Line.through(columns, effort) is not None) is is_line
    assert Line.through(COLUMN[:, None], np.ones(200)).explained == 0.0


X = swing()
SIDE = np.sign(np.gradient(X))


@pytest.mark.parametrize(
    ("position", "effort", "share"),
    [
        (X, SIDE, pytest.approx(1.0, abs=0.03)),
        (X, SIDE + 3.0, pytest.approx(1.0, abs=0.03)),  # gravity takes none
        (X, 20.0 * X, pytest.approx(0.0, abs=0.01)),
        (X, SIDE + 40.0 * X, pytest.approx(0.6, abs=0.35)),
        # A motion without return has none.
        (np.linspace(0.0, 1.0, 3000), np.ones(3000), 0.0),
        (np.zeros(3000), np.ones(3000), 0.0),
    ],
)
def test_work_share_is_one_for_friction_and_zero_for_spring_and_mass(position, effort, share):
    assert work_share(log_along(position, effort)) == share
    assert -work_share(log_along(position, -effort)) == share


def test_the_step_across_a_gap_shows_a_lost_row():
    x = swing(4000)
    kept = np.delete(x, [700, 2600])
    lost = lost_in(log_along(kept, 0.0 * kept), 1e-7, 4.0)
    assert lost.tolist() == [699, 2598]
    assert [
        lost_in(log_along(whole, 0.0 * whole), 1e-7, 4.0).size for whole in (x, kept[:100])
    ] == [0, 0]


def test_an_effort_below_the_need_of_the_motion_piles_up():
    time = DT * np.arange(12_000)
    x = 0.05 * np.sin(2.0 * np.pi * time) + 0.02 * np.sin(2.0 * np.pi * 2.3 * time)
    acceleration = np.gradient(np.gradient(x, DT), DT)
    requested = (
        3.0 * acceleration
        + np.sign(np.gradient(x))
        + 0.01 * np.random.default_rng(4).standard_normal(x.size)
    )
    level = 0.6 * float(np.max(requested))
    log = log_along(x, np.minimum(requested, level))
    cut = piled_up(log, rows_of(log, 1e-7), 1e-7, 10, 4.0)
    assert cut.level == pytest.approx(level, rel=0.03)
    assert requested[cut.first] > 0.9 * level
    assert cut.samples == pytest.approx(np.count_nonzero(requested > level), rel=0.3)
    below = log_along(x, np.maximum(requested, -level))
    assert piled_up(below, rows_of(below, 1e-7), 1e-7, 10, 4.0).level == pytest.approx(
        -level, rel=0.03
    )
    whole = log_along(x, requested)
    assert piled_up(whole, rows_of(whole, 1e-7), 1e-7, 10, 4.0) is None


WAVE = np.sin(2.0 * np.pi * np.arange(5000) / 1000.0)


@pytest.mark.parametrize(
    ("signal", "longest"),
    [
        (WAVE, 20),
        (np.abs((np.arange(5000) / 250.0) % 4.0 - 2.0) - 1.0, 20),
        (np.minimum(WAVE, 0.8), 1000),  # it lasts no longer than 205 samples
        (-np.abs(WAVE), 5),
    ],
    ids=["sine", "triangle", "short", "below zero"],
)
def test_a_signal_that_is_not_cut_off_does_not_pile_up(signal, longest):
    assert not _piled(signal, longest).any()


@pytest.mark.parametrize("height", [0.8, 0.95])
def test_a_sine_that_is_cut_off_piles_up(height):
    cut = np.minimum(WAVE, height)
    assert np.all(_piled(cut, 20)[cut == height])
    assert np.min(cut[_piled(cut, 20)]) > 0.9 * height
