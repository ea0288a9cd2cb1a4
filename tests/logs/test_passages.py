"""Experiments found in logs: those that were designed are recognised, and measured logs are what their papers say."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from tests.examples.data import measured
from tests.identification.known_logs import Motion, log_of, sines
from tests.prediction.excitation.axes import STAGE

from bristle.core import Axis
from bristle.files import read_axis, read_log
from bristle.files.axis import axis_from
from bristle.logs import Log
from bristle.logs.passages import Stretch, nesting, passages, passages_along
from bristle.logs.turns import Leg, graininess, turning_points
from bristle.prediction.excitation import excite
from bristle.prediction.excitation.rehearsal import recorded

EXPECTED = {
    "decaying loops": "loops",
    "triangles": "loops",
    "break-away ramp": "break_away",
    "chirp": "chirp",
    "constant velocity": "constant_velocity",
}


def designed(axis, **requested):
    result = excite(axis, rehearsed=False, **requested)
    log, _, _ = recorded(result.motion, axis, result.prior)
    return result.motion, log


@pytest.fixture(scope="module")
def stage():
    motion, log = designed(replace(STAGE, resolution=0.02e-6, sample_time=5e-4, jerk_limit=None))
    return motion, log, passages(log, STAGE)


def share_of(kind, begin, end, result):
    """The share of a time that passages of a kind cover."""
    covered = sum(
        max(min(item.end, end) - max(item.begin, begin), 0.0)
        for item in result
        if item.kind == kind
    )
    return covered / (end - begin)


@pytest.mark.parametrize("name", EXPECTED)
def test_designed_passages_are_recognised(stage, name):
    motion, _, result = stage
    shares = [
        share_of(EXPECTED[name], begin, begin + piece.duration, result)
        for piece, begin in zip(motion.pieces, motion.begins, strict=True)
        if piece.name == name
    ]
    assert np.mean(shares) > 0.85


def test_amplitudes_speeds_and_nesting_are_those_that_were_designed(stage):
    motion, _, result = stage
    loops = max((slide for slide in result if slide.kind == "loops"), key=lambda slide: slide.legs)
    assert loops.amplitudes[1] == pytest.approx(6.8e-6, rel=0.03)
    assert 14 <= loops.levels <= 24
    assert loops.depth >= 9  # the decaying loops: ten turning points, each inside the one before
    (chirp,) = (slide for slide in result if slide.kind == "chirp")
    (piece,) = (slide for slide in motion.pieces if slide.name == "chirp")
    assert chirp.frequencies == pytest.approx(
        (piece.reference.values["f_0"], piece.reference.values["f_1"]), rel=0.2
    )
    slides = [slide for slide in result if slide.kind == "constant_velocity"]
    assert max(slide.speeds[1] for slide in slides) == pytest.approx(
        max(slide.speed for slide in motion.pieces), rel=0.05
    )


def test_rests_and_passages_share_the_log_between_them(stage):
    _, log, result = stage
    taken = np.zeros(len(log), dtype=int)
    for item in result:
        taken[item.samples] += 1
    assert np.mean(taken != 1) < 0.01


def test_a_coarse_encoder_still_shows_the_loops():
    motion, log = designed(STAGE, duration="30 s", purposes="presliding")
    triangles = [k for k, item in enumerate(motion.pieces) if item.name == "triangles"]
    result = passages(log, STAGE)
    assert (
        share_of("loops", motion.begins[triangles[4]], motion.duration - motion.rest, result) > 0.9
    )


def test_without_effort_the_presliding_distance_separates_loops_and_slides():
    motion, log = designed(STAGE, duration="40 s", purposes="presliding,stribeck")
    result = passages(replace(log, effort=None), STAGE)
    first = next(
        begin
        for piece, begin in zip(motion.pieces, motion.begins, strict=True)
        if piece.name == "constant velocity"
    )
    assert share_of("constant_velocity", first, motion.duration, result) > 0.8
    assert share_of("loops", 4.0, first, result) > 0.8


def test_a_sine_is_an_oscillation_of_one_frequency():
    t = 1e-3 * np.arange(20_000)
    x = 0.01 * np.sin(2.0 * np.pi * 2.0 * t)
    (result,) = passages(
        log_of(Motion(t, x, np.gradient(x, t), 0.0 * t), np.sign(np.gradient(x)), step=1e-6)
    )
    assert (result.kind, result.legs) == ("oscillation", pytest.approx(80, abs=1))
    assert result.frequencies == pytest.approx((2.0, 2.0), rel=0.02)


def test_sines_mixed_are_moves():
    motion = sines(20.0)
    kinds = {
        passage.kind for passage in passages(log_of(motion, np.sign(motion.velocity), step=1e-6))
    }
    assert "moves" in kinds
    assert not kinds & {"loops", "break_away", "chirp", "oscillation"}


def there_and_back(*ways, start=0.0):
    """Time and position of moves over a distance at a speed each, their corners rounded, and their velocity."""
    speeds = [np.full(round(abs(far) / speed / 1e-3), np.sign(far) * speed) for far, speed in ways]
    velocity = np.concatenate([np.zeros(300), *speeds, np.zeros(300)])
    velocity = np.convolve(velocity, np.ones(40) / 40, "same")
    return 1e-3 * np.arange(velocity.size), start + np.cumsum(velocity) * 1e-3, velocity


def kinds_of(time, position, effort):
    result = passages_along(time, position, effort, graininess(position, 1e-9))
    return {item.kind for item in result if item.kind != "rest"}, result


PULLS = {
    "cogging": lambda x: (
        6.0 * np.sin(2.0 * np.pi * x / 0.024) + 3.0 * np.cos(4.0 * np.pi * x / 0.024)
    ),
    "cable": lambda x: 40.0 * x + 60.0 * x**2,
    "gravity": lambda x: 35.0 * np.cos(3.0 * x),
}


@pytest.mark.parametrize("pull", PULLS)
@pytest.mark.parametrize("back", [0.6, 0.3])
def test_a_slide_under_a_force_of_the_place_is_no_loop_before_sliding(pull, back):
    ways = [
        (sign * size, speed)
        for speed in (0.05, 0.2, 0.5)
        for sign, size in ((1.0, 0.6), (-1.0, back))
    ]
    time, position, velocity = there_and_back(*ways, start=-0.3)
    friction = 9.0 * np.tanh(velocity / 1e-4) + 20.0 * velocity
    noise = np.random.default_rng(0).normal(0.0, 0.3, time.size)
    kinds, result = kinds_of(time, position, friction + PULLS[pull](position) + noise)
    assert "loops" not in kinds
    assert share_of("constant_velocity", 1.0, time[-1] - 1.0, result) > 0.6


@pytest.mark.parametrize("spring", [0.0, 5e5])
@pytest.mark.parametrize("back", [10e-6, 6e-6])
def test_a_spring_does_not_hide_a_loop_before_sliding(spring, back):
    time, position, _ = there_and_back(*[(10e-6, 1e-5), (-back, 1e-5)] * 5)
    limits, bent, force = np.linspace(1e-6, 12e-6, 12), np.zeros(12), np.empty(time.size)
    for k, step in enumerate(np.diff(position, prepend=0.0)):
        bent = np.clip(bent + step, -limits, limits)
        force[k] = 8.0 * np.mean(bent / limits)
    noise = np.random.default_rng(0).normal(0.0, 0.02, time.size)
    kinds, _ = kinds_of(time, position, force + spring * position + noise)
    assert kinds == {"loops"}


def test_moves_at_several_speeds_are_no_oscillation():
    sizes = {2.0: 3.0, 1.0: 1.5, 0.5: 0.7, 0.2: 0.3}
    ways = [
        (sign * size, speed)
        for size, speed in sizes.items()
        for _ in range(3)
        for sign in (1.0, -1.0)
    ]
    time, position, velocity = there_and_back(*ways, *[(1.0, 3.0), (-1.0, 3.0)] * 8)
    kinds, _ = kinds_of(time, position, 5.0 * np.tanh(velocity / 1e-4) + 1.2 * velocity)
    assert kinds == {"constant_velocity"}


def test_steps_of_the_encoder_are_no_loops_where_stamps_are_uneven():
    rng = np.random.default_rng(0)
    even, wanted, velocity = there_and_back(*[(2e-4, 5e-5), (-2e-4, 5e-5)] * 2)
    stamps = even + 1e-3 * np.clip(rng.normal(0.0, 0.06, even.size), -0.3, 0.3)
    moving = np.interp(stamps, even, wanted) + rng.normal(0.0, 0.03e-6, even.size)
    effort = 5.0 * np.tanh(velocity / 1e-6) + rng.normal(0.0, 0.1, even.size)
    log = Log.from_columns({"time": stamps, "position": np.round(moving, 6), "effort": effort})
    assert (log.findings[0].code, log.position.step) == ("resampled", pytest.approx(1e-6))
    assert sum(passage.legs for passage in passages(log)) == 4


def test_a_resting_log_has_no_passage():
    t = 1e-3 * np.arange(5000)
    (result,) = passages(
        log_of(Motion(t, 0.0 * t, 0.0 * t, 0.0 * t), 0.0 * t), Axis(resolution=1e-6)
    )
    assert result.kind == "rest"


@pytest.mark.parametrize("noise", [0.0, 2e-7])
def test_a_rest_with_noise_is_a_rest(noise):
    t = 1e-3 * np.arange(6000)
    x = np.interp(t, [0.0, 2.0, 4.0, 6.0], [0.0, 0.0, 0.1, 0.1])
    x += noise * np.random.default_rng(3).standard_normal(t.size)
    result = passages(
        log_of(Motion(t, x, 0.0 * t, 0.0 * t), np.sign(np.gradient(x, t))), Axis(resolution=1e-8)
    )
    assert [item.kind for item in result] == ["rest", "constant_velocity", "rest"]
    assert [item.begin for item in result] == pytest.approx([0.0, 2.0, 4.0], abs=0.02)


@given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=60), st.floats(1e-3, 0.5))
def test_turning_points_alternate_and_lie_more_than_a_grain_apart(values, grain):
    x = np.array(values)
    heights = x[turning_points(x, grain)]
    steps = np.diff(heights)
    assert np.all(np.abs(steps) > grain)
    assert np.all(steps[1:] * steps[:-1] < 0.0)


@given(st.lists(st.integers(-50, 50), min_size=1, max_size=40))
def test_a_contact_remembers_no_more_than_it_was_shown(points):
    depth = nesting(points)
    assert 1 <= depth <= len(points)
    # A move further out than any before leaves nothing but itself and where it came from.
    assert nesting([*points, 1000, -1001, 1002]) == max(depth, nesting([*points, 1000]))


@pytest.mark.measured
def test_emps_is_ordinary_moves():
    axis = read_axis(Path(__file__).parents[2] / "examples/emps/axis.toml")
    (result,) = passages(read_log(measured("emps/DATA_EMPS.mat"), axis), axis)
    assert (result.kind, result.legs, result.levels) == ("moves", 8, 1)
    assert result.amplitudes[1] == pytest.approx(0.2464 / 2.0, rel=0.001)


@pytest.mark.measured
def test_the_tribometer_breaks_away_from_rest_again_and_again():
    columns = {
        "time": {"column": "Time", "unit": "s"},
        "position": {"column": "Position", "unit": "mm"},
        "effort": {"column": "Friction", "unit": "uN", "sign": -1},
    }
    axis = axis_from({"schema": 1, "kind": "translational", "columns": columns})
    result = passages(read_log(measured("tribometer/test_data_2.txt"), axis), axis)
    strokes = [
        stroke for stroke in result if stroke.kind == "break_away" and 12.0 < stroke.begin < 205.0
    ]
    assert len(strokes) == pytest.approx(2 * 48, abs=2)
    assert np.median([stroke.amplitudes[1] for stroke in strokes]) == pytest.approx(
        0.5 * 229.6e-6, rel=0.02
    )
    resting = sum(
        stroke.end - stroke.begin
        for stroke in result
        if stroke.kind == "rest" and 12.0 < stroke.begin < 205.0
    )
    assert resting / (205.0 - 12.0) == pytest.approx(0.5, abs=0.03)


@pytest.mark.measured
def test_sines_on_a_damper_are_oscillations_of_the_frequency_that_was_set():
    tests = np.load(measured("friction_damper/brfd_all.npz"))
    result = {}
    for name in sorted(tests.files)[::4]:
        columns = tests[name] if len(tests[name]) < 10 else tests[name].T
        time, position, force = (np.array(column, dtype=float) for column in columns[:3])
        set_to = float(re.search(r"__([\d.]+)Hz", name)[1])
        sines = [
            column
            for column in passages_along(time, position, force, graininess(position, None))
            if column.kind == "oscillation" and column.end - column.begin > 0.7 * np.ptp(time)
        ]
        result[name] = (
            bool(sines)
            and 0.9 < sines[0].legs / (2.0 * (sines[0].end - sines[0].begin)) / set_to < 1.1
        )
    # Fast strokes of large amplitude are cut by the actuator, and are no sines.
    assert np.mean(list(result.values())) > 0.8, result


@pytest.mark.parametrize(
    ("turning", "depth"),
    [
        ([0], 1),
        ([0, 5], 2),
        ([0, 5, 1, 4, 2], 5),  # each inside the one before
        ([0, 5, 1, 4, 1], 4),  # as far out as before wipes out what lies between
        ([0, 5, 1, 4, -1], 4),
        ([0, 5, 1, 4, 0, 4, 1, 3], 5),
        ([0, 1, -2, 0], 3),  # farther out than where it began: the turn before it remains
        ([0, 1, -2, 4, -3], 2),
        ([0, 1, -1, 1, -1], 2),
    ],
)
def test_a_contact_remembers_turning_points_that_lie_inside_one_another(turning, depth):
    assert [
        nesting([shift + scale * point for point in turning])
        for shift, scale in ((0, 1), (0, -1), (7.0, 0.1))
    ] == 3 * [depth]


def slides(*rests):
    """Passages of slides to and fro over 0.2 m at 0.1 m/s, with rests of so many seconds between them, and their speeds."""
    parts = [np.zeros(600)]
    for number, rest in enumerate([*rests, 0.6]):
        parts += [np.full(2000, 0.1 if number % 2 == 0 else -0.1), np.zeros(round(rest / 1e-3))]
    velocity = np.convolve(np.concatenate(parts), np.ones(20) / 20, "same")
    position, time = np.cumsum(velocity) * 1e-3, 1e-3 * np.arange(velocity.size)
    result = passages_along(time, position, 5.0 * np.tanh(velocity / 1e-3), 1e-6)
    return [item for item in result if item.kind != "rest"], [
        item for item in result if item.kind == "rest"
    ]


@pytest.mark.parametrize(
    ("rest", "parted"), [(0.3, False), (0.45, False), (0.6, True), (2.0, True)]
)
def test_a_rest_of_half_a_second_separates_passages_of_slides(rest, parted):
    outcome, resting = slides(rest, rest)
    assert [(item.kind, item.legs) for item in outcome] == (
        [("constant_velocity", 1)] * 3 if parted else [("constant_velocity", 3)]
    )
    assert len(resting) == (4 if parted else 2)
    for item in outcome:
        assert (item.speeds, item.amplitudes) == (
            pytest.approx((0.1, 0.1), rel=1e-3),
            pytest.approx((0.1, 0.1), rel=0.02),
        )
        assert (item.levels, item.depth, item.frequencies) == (1, 0, (0.0, 0.0))
        assert (item.begin, item.end) == pytest.approx(
            (1e-3 * item.samples.start, 1e-3 * (item.samples.stop - 1))
        )


def test_passages_of_a_later_stretch_have_the_samples_of_the_whole_log():
    time, position, velocity = there_and_back((0.2, 0.1), (-0.2, 0.1))
    early, late = (
        passages_along(time, position, 5.0 * np.tanh(velocity / 1e-3), 1e-6, start=start)
        for start in (0, 70)
    )
    assert [(item.samples.start - 70, item.samples.stop - 70) for item in late] == [
        (item.samples.start, item.samples.stop) for item in early
    ]
    assert passages_along(time[:1], position[:1], None, 1e-6) == []


@pytest.mark.parametrize(
    ("sizes", "levels"), [((0.2, 0.205, 0.2), 1), ((0.2, 0.24, 0.2), 2), ((0.1, 0.2, 0.3), 3)]
)
def test_amplitudes_are_of_one_level_within_a_twentieth(sizes, levels):
    ways = [(sign * size, 0.1) for size in sizes for sign in (1.0, -1.0)]
    time, position, velocity = there_and_back(*ways)
    outcome = [
        item
        for item in passages_along(time, position, 5.0 * np.tanh(velocity / 1e-3), 1e-6)
        if item.kind != "rest"
    ]
    assert [item.levels for item in outcome] == [levels]
    assert outcome[0].amplitudes == pytest.approx((0.5 * min(sizes), 0.5 * max(sizes)), rel=0.03)


@pytest.mark.parametrize(
    ("distance", "presliding", "kind"),
    [(0.2, 0.09, "constant_velocity"), (0.2, 0.11, "loops"), (0.2, None, "constant_velocity")],
)
def test_without_an_effort_a_leg_slides_beyond_twice_the_presliding_distance(
    distance, presliding, kind
):
    time, position, _ = there_and_back(*3 * [(distance, 0.1), (-distance, 0.1)])
    outcome = passages_along(time, position, None, 1e-6, presliding=presliding)
    assert {item.kind for item in outcome} - {"rest"} == {kind}


def test_data_of_a_passage_are_its_numbers_without_its_samples():
    (item,), _ = slides()
    data = item.as_data()
    assert (data["kind"], data["legs"], data["speeds"], "samples" in data) == (
        "constant_velocity",
        1,
        list(item.speeds),
        False,
    )


def level_between(friction, *, count=90, begin=0.0, place=0.0):
    """Whether a way forth over a metre and one back, from `begin` on, tell a level of friction; it depends on what is left of a way."""
    outward, back = np.linspace(0.0, 1.0, count), np.linspace(1.0 + begin, begin, count)
    x = np.concatenate([outward, back])
    effort = np.concatenate([friction(outward), -friction(1.0 + begin - back)]) + place * x
    stretch = Stretch(1e-3 * np.arange(x.size), x, effort, 1e-6, None, 0)
    ways = (
        Leg(
            first,
            first + count - 1,
            way,
            1.0,
            slice(first, first + count - 1),
            1.0,
            1.0,
            from_rest=False,
        )
        for first, way in ((0, 1.0), (count, -1.0))
    )
    return stretch._level_between(*ways)


@pytest.mark.parametrize(
    ("friction", "more", "is_level"),
    [
        (lambda way: 5.0 + 0.0 * way, {}, True),
        # A force of the place is the same on both ways.
        (lambda way: 5.0 + 0.0 * way, {"place": 40.0}, True),
        (lambda way: -5.0 + 0.0 * way, {}, False),  # it pushes
        # It builds up from the end of each way.
        (lambda way: 5.0 * (1.0 - np.exp(-way / 0.3)), {}, False),
        (lambda way: 5.0 * (1.0 - np.exp(-way / 0.02)), {}, True),
        # Two samples between marks are too many for so few.
        (lambda way: 5.0 + 0.0 * way, {"count": 30}, False),
        (lambda way: 5.0 + 0.0 * way, {"begin": 0.55}, True),  # they share four tenths of a way
        (lambda way: 5.0 + 0.0 * way, {"begin": 0.65}, False),
        (lambda way: 5.0 + 4.0 * np.sin(1e4 * way), {"count": 900}, True),
        (lambda way: 0.5 + 4.0 * np.sin(1e4 * way), {"count": 90}, False),  # it scatters by as much
    ],
)
def test_a_level_of_friction_is_half_of_the_difference_between_both_ways(friction, more, is_level):
    assert level_between(friction, **more) == is_level
