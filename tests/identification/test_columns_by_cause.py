"""Forces missing from a model are combinations of the columns of their causes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from bristle.identification.half_cycles import Groups
from bristle.identification.missing_force import columns_by_cause, lagging_columns, missing_forces
from bristle.identification.missing_rows import Rows, Weighed
from bristle.identification.play import play_at_flanks
from bristle.identification.settings import DEFAULT

DT = 2e-3
TIME = DT * np.arange(5000)
SPEED = 2.0 * np.pi * 0.4


def rows_of(amplitude=0.05):
    x = amplitude * np.sin(SPEED * TIME + 0.3) + 0.2 * amplitude * np.sin(3.1 * SPEED * TIME)
    v = amplitude * SPEED * (np.cos(SPEED * TIME + 0.3) + 0.62 * np.cos(3.1 * SPEED * TIME))
    a = np.gradient(v, DT)
    friction = 8.0 * np.sign(v) + 30.0 * v
    cycles = Groups(np.cumsum(np.diff(np.sign(v), prepend=1.0) != 0.0))
    predicted, none = friction + 3.0 * a, np.zeros_like(x)
    return Rows(
        TIME,
        x,
        v,
        a,
        predicted,
        none,
        none[:, None],
        predicted,
        friction,
        np.sign(v),
        cycles,
        50.0,
        none,
        10.0,
    )


ROWS = rows_of()
BRISK = np.abs(ROWS.velocity)
EVEN = BRISK / np.max(BRISK)  # a force that is equal in both directions


def left(columns, force):
    """What columns do not take of a force, as a share of it."""
    rest = force - columns @ np.linalg.lstsq(columns, force, rcond=None)[0]
    return float(np.linalg.norm(rest) / np.linalg.norm(force))


@pytest.mark.parametrize(
    ("cause", "rows", "force", "most"),
    [
        pytest.param(
            "direction", ROWS, np.full(ROWS.time.size, 2.0), 1e-9, id="constant by direction"
        ),
        pytest.param("speed", ROWS, ROWS.velocity * BRISK, 1e-9, id="square of the speed"),
        *(
            pytest.param(
                "speed",
                ROWS,
                5.0 * np.exp(-BRISK / (share * np.quantile(BRISK, 0.99))) * ROWS.side,
                0.02,
                id=f"fall {share}",
            )
            for share in (0.01, 0.05, 0.2, 0.6, 1.0)
        ),
    ],
)
def test_columns_of_a_cause_explain_its_force(cause, rows, force, most):
    assert left(columns_by_cause(rows)[cause], force) < most


@pytest.mark.parametrize("lag", [0.01, 0.04])
@pytest.mark.parametrize("share", [0.003, 0.01, 0.03, 0.1])
def test_a_fall_that_lags_behind_the_speed(lag, share):
    keep, fall = np.exp(-DT / lag), share * np.quantile(BRISK, 0.99)
    late = lfilter([0.5 * (1.0 - keep)] * 2, [1.0, -keep], BRISK - BRISK[0]) + BRISK[0]
    force = 5.0 * (np.exp(-late / fall) - np.exp(-BRISK / fall)) * np.sign(ROWS.velocity)
    assert left(lagging_columns(ROWS), force) < 0.12


def with_residual(rows, force, noise=0.02, seed=1):
    """Rows whose model lacks a force, far from reversals wherever the axis moves."""
    residual = force + noise * np.random.default_rng(seed).standard_normal(rows.time.size)
    distance = np.min(np.abs(rows.time[:, None] - rows.time[rows.cycles.first][None, :]), axis=1)
    return replace(
        rows, residual=residual, slope=rows.side, effort=rows.predicted + residual, turned=distance
    )


def test_a_force_equal_in_both_directions_is_found_with_its_size_and_noise_remains():
    (missing,), left_over = missing_forces(with_residual(ROWS, 0.6 * EVEN), DEFAULT)
    assert missing.cause == "direction"
    assert missing.share > 0.95
    assert missing.force == pytest.approx(0.6 * float(np.std(EVEN)), rel=0.25)
    assert 0.0 < left_over < 2.0


LATE = with_residual(
    ROWS,
    -4.0 * ROWS.side * np.exp(-ROWS.from_ends(ROWS.position)[0] / (5e-3 * np.ptp(ROWS.position))),
)
SMALL = with_residual(ROWS, 0.01 * EVEN, noise=1e-4)
HALF_CYCLES = with_residual(ROWS, 0.4 * EVEN, noise=0.1)


@pytest.mark.parametrize(
    ("rows", "changed", "static", "causes"),
    [
        pytest.param(SMALL, {}, False, [], id="below its share of friction"),
        pytest.param(SMALL, {"missing_evidence": 0.0}, False, ["direction"], id="of any size"),
        pytest.param(
            with_residual(ROWS, 0.4 * EVEN, noise=0.5),
            {},
            False,
            ["direction"],
            id="below the noise of single rows",
        ),
        pytest.param(with_residual(ROWS, 0.0 * TIME, noise=0.4), {}, False, [], id="noise"),
        pytest.param(LATE, {}, True, ["presliding"], id="builds up after reversals"),
        pytest.param(LATE, {}, False, [], id="only sought for static models"),
        pytest.param(with_residual(ROWS, 0.0 * TIME), {}, True, [], id="nothing of a static model"),
        pytest.param(
            with_residual(ROWS, 0.6 * EVEN).at(np.arange(5000) < 150),
            {},
            False,
            [],
            id="too few rows",
        ),
        pytest.param(HALF_CYCLES.at(ROWS.cycles.index < 4), {}, False, [], id="four half-cycles"),
        pytest.param(
            HALF_CYCLES.at(ROWS.cycles.index < 8), {}, False, ["direction"], id="eight half-cycles"
        ),
    ],
)
def test_a_force_is_named_by_its_cause_if_it_matters(rows, changed, static, causes):
    assert [
        force.cause for force in missing_forces(rows, replace(DEFAULT, **changed), static=static)[0]
    ] == causes


def test_friction_builds_up_after_a_reversal_and_not_before():
    behind, before = ROWS.from_ends(ROWS.position)
    reach = float(np.ptp(ROWS.position))
    columns = columns_by_cause(ROWS)["presliding"]
    assert left(columns, ROWS.side * np.exp(-behind / (1e-3 * reach))) < 0.2
    assert left(columns, ROWS.side * np.exp(-before / (1e-3 * reach))) > 0.8
    first, last = ROWS.from_ends(ROWS.time)
    assert first[ROWS.cycles.first].tolist() == [0.0] * ROWS.cycles.count
    assert np.all(first >= 0.0)
    assert (
        last[np.append(ROWS.cycles.first[1:], ROWS.time.size) - 1].tolist()
        == [0.0] * ROWS.cycles.count
    )


def test_far_rows_are_three_periods_of_the_cutoff_from_reversals():
    rows = with_residual(ROWS, 0.0 * TIME)
    assert rows.turned[rows.far].min() > 3.0 / 50.0
    beside = (rows.turned > 3.5 / 50.0) & (
        np.abs(rows.velocity) > 0.01 * np.abs(rows.velocity).max()
    )
    first, last = rows.from_ends(rows.time)
    assert np.all(rows.far[beside & (np.minimum(first, last) > 3.5 / 50.0)])


def test_a_rate_is_zero_at_gaps():
    kept = ROWS.at((TIME < 2.0) | (TIME > 2.5))
    assert kept.stretch.max() == 1
    edge = int(np.flatnonzero(np.diff(kept.stretch))[0])
    rate = kept.rate(3.0 * kept.time)
    assert rate[[edge, edge + 1]].tolist() == [0.0, 0.0]
    assert np.delete(rate, [edge, edge + 1]) == pytest.approx(3.0)
    assert ROWS.enough
    assert not ROWS.at(TIME < 0.3).enough


def test_scatter_of_the_level_between_half_cycles_is_weighted_down():
    levels = np.random.default_rng(3).standard_normal(ROWS.cycles.count)[ROWS.cycles.index]
    scattered = Weighed.of(with_residual(ROWS, 0.5 * levels * ROWS.side, noise=0.05))
    steady = Weighed.of(with_residual(ROWS, 0.0 * levels, noise=0.05))
    assert np.median(scattered.lost) > 0.8
    assert np.median(steady.lost) < 0.5
    assert np.mean(scattered.weight**2) == pytest.approx(1.0)
    assert set(np.unique(scattered.part)) <= set(range(10))


def test_rows_of_an_almost_exact_band_have_at_most_four_times_the_weight():
    lacking = with_residual(ROWS, 0.0 * TIME)
    first, last = ROWS.from_ends(ROWS.time)
    exact = np.minimum(first, last) * ROWS.cutoff > 12.0
    assert 0.1 < np.mean(exact) < 0.9
    weight = Weighed.of(
        replace(lacking, residual=np.where(exact, 1e-4, 1.0) * lacking.residual)
    ).weight
    assert np.median(weight[exact]) > 1.5 * np.median(weight[~exact])
    assert np.max(weight) < 4.0 * np.median(weight[~exact])
    even = Weighed.of(lacking).weight
    assert np.max(even) < 1.5 * np.median(even)


def knocks(times, *, trains=20, flips=1, first=None, friction=1.0, beside=None):
    """What is found in rows of one speed whose load changes sides amid strokes, and leaves so many times the usual residual there."""
    count = 5000
    row, residual, load = (
        np.arange(count),
        0.1 * np.random.default_rng(2).choice([-1.0, 1.0], count),
        np.ones(count),
    )
    side, none = np.where(row // 250 % 2 == 0, 1.0, -1.0), np.zeros(count)
    for number in range(trains):
        start = 250 * number + 100
        for flip in range(flips):
            load[start + 3 * flip :] *= -1.0
        residual[start - 2 : start + 3 * flips + 1] *= first if first and number == 0 else times
    x, long = 0.001 * np.cumsum(side), np.full(count, 1e3)
    cycles = Groups(row // 250)
    rows = Rows(
        0.01 * row,
        x,
        0.1 * side,
        none,
        load,
        residual,
        none[:, None],
        load,
        friction * side,
        side,
        cycles,
        50.0,
        long,
        10.0,
    )
    if beside is not None:
        rows = replace(
            rows,
            jacobian=beside,
            residual=residual + beside @ np.arange(1.0, 1.0 + beside.shape[1]),
        )
    return play_at_flanks(rows, DEFAULT)


def test_play_is_found_if_the_residual_doubles_at_changes_of_flank():
    (play,), usual = knocks(3.0)
    excess = 20 * 6 * 0.1**2 * (3.0**2 - 1.0)  # two rows ahead of a change, four after it
    assert (play.cause, play.ratio) == ("play", pytest.approx(3.0, rel=0.06))
    assert play.force == pytest.approx((excess / 5000) ** 0.5, rel=0.1)
    assert play.share == pytest.approx(excess / (excess + 5000 * 0.1**2), rel=0.1)
    assert usual == pytest.approx(0.1, rel=0.05)


@pytest.mark.parametrize(
    ("times", "struck", "ratio"),
    [
        (1.9, {}, None),
        (2.4, {}, 2.4),
        (3.0, {"friction": 3.0}, 3.0),
        (3.0, {"friction": 6.0}, None),  # less than a hundredth of it
        (5.0, {"trains": 4}, 5.0),  # four changes are needed
        (5.0, {"trains": 3, "flips": 5}, None),
        (5.0, {"trains": 4, "flips": 5}, 5.0),
        (1.0, {"trains": 8, "first": 10.0}, None),  # of which none dominates
        (5.0, {"trains": 8, "first": 20.0}, 5.0),
    ],
)
def test_play_needs_four_changes_that_matter_without_a_dominant_one(times, struck, ratio):
    found, _ = knocks(times, **struck)
    assert [play.ratio for play in found] == (
        [] if ratio is None else [pytest.approx(ratio, rel=0.1)]
    )


def test_an_effect_of_model_parameters_is_not_play():
    turn = 2.0 * np.pi * np.arange(5000) / 5000
    beside = np.column_stack(
        [50.0 * np.sin(11.0 * turn), np.cos(17.0 * turn), 1e-3 * np.sin(23.0 * turn)]
    )
    ((plain,), usual), ((play,), as_usual) = knocks(3.0), knocks(3.0, beside=beside)
    assert play.ratio == pytest.approx(plain.ratio, rel=0.02)
    assert play.force == pytest.approx(plain.force, rel=0.02)
    assert as_usual == pytest.approx(usual, rel=0.02)


def test_a_single_omitted_row_ends_a_stretch():
    assert ROWS.stretch.max() == 0
    assert np.flatnonzero(np.diff(ROWS.at(np.arange(TIME.size) != 700).stretch)).tolist() == [699]


def test_many_rows_are_reduced_to_pieces_of_the_whole_log():
    rows = rows_of()
    assert rows.pieces(TIME.size) is rows
    pieces = rows.pieces(2000)
    assert (
        pieces.time.tolist()
        == TIME[[*range(500), *range(1500, 2000), *range(3000, 3500), *range(4500, 5000)]].tolist()
    )
    assert pieces.jacobian.shape == (2000, 1)
    assert pieces.cycles.index.size == 2000
