"""How logs are cut into cycles, and which of these are of one motion."""

import numpy as np
import pytest
from tests.prediction.comparison.machine import STEP, log, sine

from bristle.prediction.comparison import cycles
from bristle.prediction.comparison.cycles import Cycle, Recording, sides_of


def recording(motion, turns=()):
    """A stretch of a log that holds a motion alone."""
    return Recording(
        1.0, np.array(motion, dtype=float), None, None, None, np.array(turns, dtype=int)
    )


def spans(result):
    """From which sample to which each cycle goes."""
    return [(cycle.samples.start, cycle.samples.stop) for cycle in result]


@pytest.mark.parametrize(
    ("motion", "expected"),
    [
        ([5, 5, 6, 7, 7], (1, 4)),
        ([1, 2, 3], (0, 3)),
        ([4, 4, 4], (0, 0)),
        ([0, 1, 1, 1, 2, 2], (0, 5)),
    ],
)
def test_a_motion_moves_from_its_first_step_to_its_last(motion, expected):
    moving = cycles._moving(recording(motion))
    assert (moving.start, moving.stop) == expected


def test_pieces_are_cut_as_long_as_each_other_while_the_axis_moves():
    motion = [0, 0, 1, 2, 3, 4, 5, 6, 7, 7, 7]
    assert spans(cycles._pieces([recording(motion)], 4)) == [(1, 5), (5, 9)]
    assert spans(cycles._pieces([recording(motion)], 3)) == [(1, 4), (4, 7)]
    assert spans(cycles._pieces([recording(motion), recording([3, 3, 3])], 8)) == [(1, 9)]


def to_and_fro(count, half=6):
    """A motion up and down in even steps, and the samples at which it turns, ends not included."""
    strokes = [np.arange(half), half - np.arange(half)] * count
    motion = np.concatenate([*strokes, [0]])
    return motion, np.arange(half, motion.size - 1, half)


THRICE, TURNS = to_and_fro(3)
TWICE, _ = to_and_fro(2)
SEVEN = [*np.tile([0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.5], 3), 0.0]


@pytest.mark.parametrize(
    ("motion", "turns", "cycles_of"),
    [
        (THRICE, TURNS, [(0, 12), (12, 24), (24, 36)]),
        # Upside down it turns forward in the middle of these.
        (-THRICE, TURNS, [(6, 18), (18, 30)]),
        (THRICE[3:], TURNS - 3, [(9, 21), (21, 33)]),  # begun halfway
        (THRICE[:-3], TURNS, [(0, 12), (12, 24)]),  # ended halfway
        # Rest before and after.
        (
            np.concatenate([np.zeros(5), TWICE, np.zeros(7)]),
            np.array([11, 17, 23]),
            [(5, 17), (17, 29)],
        ),
        (*to_and_fro(3, 4), [(0, 8), (8, 16), (16, 24)]),
        (*to_and_fro(3, 3), []),  # too few samples
        (SEVEN, [3, 7, 10, 14, 17], []),
        (np.full(30, 2.0), (), []),  # a standstill
    ],
)
def test_cycles_reach_from_a_forward_turn_to_the_next(motion, turns, cycles_of):
    assert spans(cycles._complete([recording(motion, turns)])) == cycles_of


@pytest.mark.parametrize(
    ("away", "count", "number"),
    [
        (0.0, 100, 0),
        (0.5, 100, 0),  # as far as is allowed
        (0.51, 100, 2),
        (-0.51, 100, 2),
        (9.6, 100, 1),  # half a step from the second motion
        (0.0, 104, 0),  # 2 % of it and two samples
        (0.0, 97, 0),
        (0.0, 105, 2),
        (0.0, 96, 2),
    ],
)
def test_equal_duration_and_nearby_positions_make_the_same_motion(away, count, number):
    known, motion = (
        [np.zeros(3), np.full(3, 10.0)],
        np.array([0.0, 0.0, away]) if abs(away) < 1 else np.full(3, away),
    )
    assert cycles._first_alike(motion, count, known, [100, 100], 0.5, 0.02) == number
    assert cycles._first_alike(motion, count, [], [], 0.5, 0.02) == 0, "the first motion"


def test_motions_are_numbered_through_both_sides():
    wide, narrow = np.arange(10.0), 0.5 * np.arange(10.0)
    stretch = recording(np.concatenate([narrow, wide, narrow]))
    low = [Cycle(stretch, slice(0, 10)), Cycle(stretch, slice(10, 20))]
    high = [
        Cycle(recording(wide), slice(0, 10)),
        Cycle(stretch, slice(20, 30)),
        Cycle(recording(5.0 + wide), slice(0, 10)),
    ]
    numbered = cycles._numbered([low, high], 0.0, 0.02, complete=True)
    assert [[cycle.kind for cycle in custom] for custom in numbered] == [[0, 1], [1, 0, 2]]


@pytest.mark.parametrize(("complete", "number"), [(True, 1), (False, 0)])
def test_pieces_are_placed_from_where_their_motion_begins(complete, number):
    near, far = (recording(origin + np.arange(10.0)) for origin in (0.0, 40.0))
    numbered = cycles._numbered(
        [[Cycle(near, slice(0, 10))], [Cycle(far, slice(0, 10))]], 0.0, 0.02, complete=complete
    )
    assert numbered[1][0].kind == number


@pytest.mark.parametrize(
    ("away", "grain", "number"), [(1.05, 0.0, 0), (1.25, 0.0, 1), (1.25, 0.2, 0), (1.45, 0.2, 1)]
)
def test_cycles_are_equal_within_a_share_a_step_and_a_grain(away, grain, number):
    # Of a range of 9, in steps of 1: a share of 0.02 are 0.18.
    first, second = (
        Cycle(recording(origin + np.arange(10.0)), slice(0, 10)) for origin in (0.0, away)
    )
    assert cycles._numbered([[first], [second]], grain, 0.02, complete=True)[1][0].kind == number


# --- from logs -----------------------------------------------------------------------------------------------------


def recorded(item, step=STEP, **requested):
    """The stretches of a log, and why it tells no friction."""
    return cycles._recordings_of(
        item, None, step, **({"follows": True, "tells_effort": False} | requested)
    )


def test_the_following_error_is_the_reference_minus_the_position():
    motion = sine(2)
    item = log(1, motion, position=motion[0] - 1e-5, effort=None)
    (part,), reason = recorded(item)
    assert part.error == pytest.approx(1e-5)
    assert part.motion.tolist() == motion[0].tolist()
    assert (part.effort, part.sliding, reason, part.sample_time) == (None, None, None, STEP)


def test_without_a_reference_the_motion_is_the_position():
    item = log(1, sine(2), reference=None)
    (part,), _ = recorded(item, follows=False)
    assert part.error is None
    assert part.motion.tolist() == item.position.values.tolist()
    assert (
        recorded(item, follows=False, tells_effort=True)[0][0].effort.tolist()
        == item.effort.values.tolist()
    )


@pytest.mark.parametrize(
    ("times", "rows"),
    [
        (1.0005, range(500)),
        (2.0, range(0, 500, 2)),
        (3.0, range(0, 500, 3)),
        (499.0 / 99.0, [round(499.0 * k / 99.0) for k in range(100)]),
    ],
)
def test_a_log_with_more_samples_gives_as_many_as_the_other(times, rows):
    motion = sine(2)
    (part,), _ = recorded(log(1, motion, effort=None), times * STEP)
    expected = motion[0][np.array(rows)]
    assert part.motion[: expected.size].tolist() == expected.tolist()
    assert part.motion.size == pytest.approx(500 / times, abs=1.0 if times > 1.1 else 0.3)
    if times > 1.1:  # the last sample is there where it is due
        assert part.motion.tolist() == expected.tolist()
    assert part.error.size == part.motion.size


def test_sliding_has_the_rows_of_a_moving_axis():
    motion = sine(3)
    (part,), reason = recorded(log(1, motion), tells_effort=True)
    assert reason is None
    assert part.sliding.shape == (3, motion[0].size)
    known = np.flatnonzero(np.isfinite(part.sliding).all(axis=0))
    assert known.size > 0.8 * motion[0].size
    fast = known[np.abs(motion[1][known]) > 0.15]
    # A row that is shifted by a sample would err by the acceleration times the sample time.
    assert part.sliding[0, fast] == pytest.approx(motion[1][fast], rel=0.02)
    assert part.sliding[1, fast] == pytest.approx(motion[2][fast], abs=0.25)


def test_a_log_too_short_for_the_filter_has_a_reason():
    motion = [part[:12] for part in sine(1)]
    (part,), reason = recorded(log(1, motion), tells_effort=True)
    assert part.sliding is None
    assert reason is not None


def test_back_and_forth_motion_gives_cycles_and_other_motion_pieces():
    single, other = ((log(seed, sine(4), effort=None), None) for seed in (1, 2))
    low, high, complete = sides_of([single], [other], follows=True, tells_effort=False)
    assert complete
    # From three quarters of a period on.
    assert spans(low.cycles) == [(188, 438), (438, 688), (688, 938)]
    assert set(low.kinds) == set(high.kinds) == {0}
    short = (log(3, sine(1.4), effort=None), None)
    low, high, complete = sides_of([single], [short], follows=True, tells_effort=False)
    assert not complete
    assert {cycle.count for cycle in (*low.cycles, *high.cycles)} == {350 // 20}
    assert low.kinds[:20] == high.kinds[:20]


def test_both_sides_have_the_longest_sample_time():
    fine, coarse = (
        (log(1, sine(4, step=step), step=step, effort=None), None) for step in (STEP, 2.0 * STEP)
    )
    low, high, _ = sides_of([fine], [coarse], follows=True, tells_effort=False)
    assert {cycle.recording.sample_time for cycle in (*low.cycles, *high.cycles)} == {
        coarse[0].sample_time
    }
    assert spans(low.cycles) == spans(high.cycles)


@pytest.mark.parametrize("amplitude", [5e-5, 0.05, 50.0])
def test_a_small_tremble_of_the_reference_adds_no_turns(amplitude):
    motion = sine(4, amplitude=amplitude)
    ripple = 0.4e-3 * np.ptp(motion[0]) * np.sin(0.25 * np.pi * np.arange(motion[0].size))
    single, other = (
        (log(seed, motion, reference=motion[0] + ripple, effort=None), None) for seed in (1, 2)
    )
    low, _, complete = sides_of([single], [other], follows=True, tells_effort=False)
    assert complete
    assert [cycle.count for cycle in low.cycles] == pytest.approx(3 * [250], abs=4)


def test_a_side_has_the_reason_for_missing_friction_of_its_first_log():
    short = log(1, [part[:12] for part in sine(1)])
    long, other = log(2, sine(4)), log(3, sine(4))
    for side in ([short, long], [long, short]):
        low, high, _ = sides_of(
            [(item, None) for item in side], [(other, None)], follows=True, tells_effort=True
        )
        assert low.reason is not None
        assert high.reason is None


def test_pieces_are_a_twentieth_of_the_longest_motion_of_the_shorter_side():
    t = STEP * np.arange(2000)
    slides = [
        log(1, (0.1 * t[:count], np.full(count, 0.1), np.zeros(count)), effort=None)
        for count in (400, 2000, 1000)
    ]
    low, high, complete = sides_of(
        [(item, None) for item in slides[:2]], [(slides[2], None)], follows=True, tells_effort=False
    )
    assert not complete
    assert {cycle.count for cycle in (*low.cycles, *high.cycles)} == {1000 // 20}


@pytest.mark.parametrize(
    ("follows", "wider", "is_one"),
    [(True, 1.05, True), (True, 1.1, False), (False, 1.1, True), (False, 1.2, False)],
)
def test_references_match_within_2_percent_and_positions_within_6_percent(follows, wider, is_one):
    # And within a step from sample to sample, which is a hundredth of the range here.
    sides = [
        [(log(seed, sine(4, amplitude=size)), None)]
        for seed, size in ((1, 0.05), (2, 0.05 * wider))
    ]
    low, high, complete = sides_of(*sides, follows=follows, tells_effort=False)
    assert complete
    assert bool(set(low.kinds) & set(high.kinds)) is is_one
