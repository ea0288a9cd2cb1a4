"""What a comparison finds of logs whose changes are known, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest
from tests.comparison.machine import STEP, log, sine, wandering

import bristle as br
from bristle.core.errors import InputError
from bristle.report.messages import message

ERRORS = ("following_error.rms", "following_error.peak", "reversals.forward_to_backward", "reversals.backward_to_forward")


def codes(result):
    return {diagnostic.code for diagnostic in result.diagnostics}


def holds(change, value):
    low, high = change.interval
    return low <= value <= high


def test_a_smaller_error_and_less_friction_are_found_with_their_size():
    comparison = br.compare(log(1, sine(12)), log(2, sine(10), gain=0.7, friction=7.0))
    for name in ERRORS:
        change = comparison.changes[name]
        assert change.verdict == "lower"
        assert change.interval_percent[0] - 3.0 < -30.0 < change.interval_percent[1] + 3.0
    assert holds(comparison.changes["friction.level"], -1.0)
    assert comparison.changes["effort.rms"].verdict == "lower"
    assert comparison.helped is True
    assert codes(comparison) == {"one_recording"}
    assert (comparison.shared.cycles_before, comparison.shared.cycles_after, comparison.shared.motions) == (11, 9, 1)
    assert len(comparison.friction_curve) == 4
    assert all(holds(change, -1.0) for _, change in comparison.friction_curve)


def test_a_larger_error_did_not_help():
    comparison = br.compare(log(1, sine(12)), log(2, sine(12), gain=1.3))
    assert comparison.changes["following_error.rms"].verdict == "higher"
    assert comparison.helped is False
    assert comparison.changes["friction.level"].verdict == "no_change"


def bumped(seed, times, *, forward):
    """A log whose error has a bump so long behind each reversal into one direction."""
    motion = sine(12)
    error = 1e-6 * np.random.default_rng(seed).standard_normal(motion[0].size)
    turns = [round((cycle + (0.75 if forward else 0.25)) / STEP) for cycle in range(12)]
    for turn in turns:
        error[turn + round(times / STEP)] += 5e-5
    return log(seed, motion, position=motion[0] - error)


def test_a_glitch_after_one_reversal_is_reported_for_that_direction_only():
    flat = log(1, sine(12), position=sine(12)[0] - 1e-6 * np.random.default_rng(9).standard_normal(sine(12)[0].size))
    for forward, lower, same in ((True, ERRORS[3], ERRORS[2]), (False, ERRORS[2], ERRORS[3])):
        comparison = br.compare(bumped(2, 0.02, forward=forward), flat)
        assert comparison.changes[lower].verdict == "lower"
        assert comparison.changes[lower].before == pytest.approx(5e-5, rel=0.1)
        assert abs(comparison.changes[same].change) < 1e-6


def test_the_window_after_a_reversal_has_the_given_length():
    pair = bumped(2, 0.08, forward=True), bumped(3, 0.08, forward=False)
    assert br.compare(*pair).window == pytest.approx(0.05, abs=STEP)  # a tenth of half a second
    assert br.compare(*pair, window="40 ms").changes[ERRORS[3]].before < 1e-5
    assert br.compare(*pair, window="100 ms").changes[ERRORS[3]].before > 4e-5
    assert br.compare(*pair, window=0.1).window == pytest.approx(0.1)


def test_faster_sampling_does_not_raise_peaks():
    peaks = []
    for step in (STEP, STEP / 8.0):
        motion = sine(12, step=step)
        noise = 1e-5 * np.random.default_rng(3).standard_normal(motion[0].size)
        peaks.append(log(1, motion, step=step, position=motion[0] - noise))
    comparison = br.compare(*peaks)
    assert comparison.changes["following_error.peak"].verdict == "no_change"
    assert abs(comparison.changes["following_error.peak"].change_percent) < 10.0
    assert comparison.changes["friction.level"].verdict == "no_change"
    assert "sample_times_differ" in codes(comparison)


def test_only_common_motions_are_compared():
    slow, fast = sine(8), sine(16, period=0.5)
    before = log(1, [np.concatenate(pair) for pair in zip(slow, fast, strict=True)])
    comparison = br.compare(before, log(2, sine(9)))
    assert "motions_differ" in codes(comparison)
    assert comparison.shared.before_percent == pytest.approx(50.0, abs=5.0)
    assert comparison.shared.after_percent == 100.0
    assert comparison.changes["effort.rms"].verdict == "no_change"  # the fast half takes four times the force


@pytest.mark.parametrize("other", [sine(9, amplitude=0.04), sine(9, period=1.2)], ids=["amplitude", "period"])
def test_logs_without_a_motion_in_common_are_refused(other):
    with pytest.raises(InputError, match=r"no cycle of the references is the same .*same reference: the same positions at the same speed"):
        br.compare(log(1, sine(9)), log(2, other))


def test_a_motion_that_never_repeats_is_compared_cycle_by_cycle_with_its_counterpart():
    comparison = br.compare(log(1, wandering(30.0)), log(2, wandering(20.0), gain=0.8))
    assert comparison.shared.paired
    assert comparison.shared.motions == comparison.shared.cycles_after >= 8
    assert comparison.shared.before_percent < 75.0
    change = comparison.changes["following_error.rms"]
    assert change.interval_percent[0] < -20.0 < change.interval_percent[1]
    assert change.interval_percent[1] - change.interval_percent[0] < 10.0


def test_a_motion_in_one_direction_is_compared_in_pieces():
    t = STEP * np.arange(4000)
    slide = 0.1 * t + 0.002 * np.sin(2.0 * t), 0.1 + 0.004 * np.cos(2.0 * t), -0.008 * np.sin(2.0 * t)
    elsewhere = slide[0] + 1.3, *slide[1:]
    comparison = br.compare(log(1, slide), log(2, elsewhere, gain=0.5))
    assert not comparison.shared.complete
    assert {"pieces_for_cycles", "friction_not_told"} <= codes(comparison)
    assert not [name for name in comparison.changes if name.startswith(("reversals", "friction"))]
    assert comparison.changes["following_error.rms"].verdict == "lower"


@pytest.mark.parametrize("cycles", [3, 4])
def test_a_motion_from_turn_to_turn_gives_all_its_cycles(cycles):
    phase = 2.0 * np.pi * STEP * np.arange(round(cycles / STEP) + 1)
    w = 2.0 * np.pi
    motion = -0.05 * np.cos(phase), 0.05 * w * np.sin(phase), 0.05 * w * w * np.cos(phase)
    comparison = br.compare(log(1, motion), log(2, motion))
    assert comparison.shared.complete
    assert (comparison.shared.cycles_before, comparison.shared.motions) == (cycles, 1)


def test_a_peak_in_only_two_pieces_has_no_narrow_interval():
    comparison = br.compare(log(1, sine(2)), log(2, sine(2)))
    assert comparison.shared.cycles_before > 10
    for name in ERRORS[2:]:
        change = comparison.changes[name]
        assert change.interval is None or change.verdict == "no_change"


def test_without_a_reference_effort_and_friction_are_compared_with_a_remark():
    comparison = br.compare(log(1, sine(9), reference=None), log(2, sine(9), friction=7.0))
    assert set(comparison.changes) == {"effort.rms", "effort.peak", "friction.level"}
    assert comparison.helped is None
    lacking = next(diagnostic for diagnostic in comparison.diagnostics if diagnostic.code == "no_reference")
    assert lacking.numbers["sides"] == ("before",)
    assert "does not compare the following error" in message(lacking)
    assert "Without a reference" in comparison.sentences[0]


def test_positions_match_despite_noise_and_different_loops():
    motion = sine(9)
    noise = 1e-4 * np.random.default_rng(5).standard_normal((2, motion[0].size))
    pair = [
        log(seed, motion, reference=None, position=share * motion[0] + custom)
        for seed, share, custom in zip((1, 2), (1.0, 0.97), noise, strict=True)
    ]
    comparison = br.compare(*pair)
    assert (comparison.shared.cycles_before, comparison.shared.cycles_after) == (8, 8)
    with pytest.raises(InputError, match=r"no cycle of the positions .compared because a log has no reference. is the same"):
        br.compare(pair[0], log(3, sine(9, amplitude=0.04), reference=None))


def test_without_an_effort_the_following_error_is_compared():
    comparison = br.compare(log(1, sine(9), effort=None), log(2, sine(9), effort=None, gain=0.5))
    assert set(comparison.changes) == set(ERRORS)
    assert "no_effort" in codes(comparison)
    assert comparison.helped


def test_neither_gravity_nor_mass_counts_as_friction():
    phase = 2.0 * np.pi * STEP * np.arange(3000)
    position = 0.05 * np.sin(phase + 0.5 * np.sin(phase))  # forth is faster than back
    velocity = np.gradient(position, STEP)
    motion = position, velocity, np.gradient(velocity, STEP)
    inertia = 6.0 * motion[2]
    loaded = log(2, motion, friction=7.0, gravity=30.0)
    loaded = log(2, motion, effort=loaded.effort.values + inertia)
    comparison = br.compare(log(1, motion), loaded)
    assert holds(comparison.changes["friction.level"], -1.0)
    assert abs(comparison.changes["friction.level"].change + 1.0) < 0.3


def strokes(*amplitudes):
    """A reference of one stroke after another, each a second long and with a standstill at both ends."""
    phase = 2.0 * np.pi * STEP * np.arange(round(1.0 / STEP))
    w, amplitude = 2.0 * np.pi, np.concatenate([np.full(phase.size, custom) for custom in amplitudes])
    phase = np.tile(phase, len(amplitudes))
    return amplitude * (1.0 - np.cos(phase)), amplitude * w * np.sin(phase), amplitude * w * w * np.cos(phase)


@pytest.mark.parametrize("fast_after", [1, 2])
def test_friction_is_given_only_at_speeds_of_the_compared_strokes(fast_after):
    tiny = np.repeat([0.001, 0.0014, 0.002, 0.0028], 2)  # below a tenth of the speed of the fast ones: near a reversal
    before = log(1, strokes(*tiny, 0.02, 0.02, 0.05))
    comparison = br.compare(before, log(2, strokes(*tiny, 0.02, 0.02, *fast_after * [0.05])))
    assert comparison.friction_curve
    for speed, change in comparison.friction_curve:
        assert speed < 0.02 * 2.0 * np.pi * 1.01
        assert change.before == pytest.approx(8.0 + 20.0 * speed, rel=0.15)
    assert comparison.changes["friction.level"].before == pytest.approx(9.0, rel=0.15)


def test_several_logs_of_a_side_are_combined():
    comparison = br.compare([log(1, sine(5)), log(2, sine(6))], [log(3, sine(5)), log(4, sine(5))])
    assert (comparison.shared.cycles_before, comparison.shared.cycles_after) == (9, 8)
    assert "one_recording" not in codes(comparison)
    assert "one_recording" in codes(br.compare(log(1, sine(9)), log(3, sine(9))))


def test_logs_that_follow_each_other_in_time_cancel_a_drift():
    own, motion, logs = log(1, sine(5)), sine(5), {False: ([], []), True: ([], [])}
    for place, side in enumerate((0, 1, 1, 0, 1, 0, 0, 1)):
        recorded = log(10 + place, motion, gain=(1.0, 0.7)[side] * (1.0 + 0.1 * place))
        for follows, sides in logs.items():
            sides[side].append(replace(recorded, time=own.time.values + 100.0 * place * follows))
    widths = {follows: np.ptp(br.compare(*sides).changes[ERRORS[0]].interval) for follows, sides in logs.items()}
    assert widths[True] < 0.5 * widths[False]


def test_few_cycles_and_cycles_without_scatter_are_warned_of():
    assert "few_cycles" in codes(br.compare(log(1, sine(4)), log(2, sine(9))))
    assert "few_cycles" not in codes(br.compare(log(1, sine(9)), log(2, sine(9))))
    motion = sine(9)
    same = [log(k, motion, position=motion[0] - k * 1e-5, effort=None) for k in (1, 2)]
    assert "cycles_identical" in codes(br.compare(*same))


def test_units_are_those_of_the_axis():
    turning = [log(seed, sine(9), kind="rotational") for seed in (1, 2)]
    comparison = br.compare(*turning)
    assert comparison.changes["following_error.rms"].unit == "rad"
    assert comparison.changes["friction.level"].unit == "N*m"
    with pytest.raises(InputError, match="different kinds"):
        br.compare(turning[0], log(2, sine(9)))


@pytest.mark.parametrize("other", ["itself", "a copy"])
def test_the_same_log_on_both_sides_is_refused(other):
    item = log(1, sine(9))
    with pytest.raises(InputError, match=r"is also the log from before the change.*and another log from after the change"):
        br.compare(item, item if other == "itself" else log(1, sine(9)))


def test_incomparable_logs_are_refused():
    item, columns = log(1, sine(9)), {"time": STEP * np.arange(400), "position": np.full(400, np.nan)}
    refusals = {
        "names no log": lambda: br.compare([], item),
        "NaN": lambda: br.compare(item, columns | {"effort": columns["time"]}),
        "no such file": lambda: br.compare("gone.csv", item),
        "all contain a reference, or all contain an effort": lambda: br.compare(
            log(1, sine(9), effort=None), log(2, sine(9), reference=None)
        ),
        "must be positive": lambda: br.compare(item, log(2, sine(9)), window=0.0),
        "1 mm": lambda: br.compare(item, log(2, sine(9)), window="1 mm"),
        "2 axis files for 3 logs": lambda: br.compare(item, [log(2, sine(9)), log(3, sine(9))], axis=[br.Axis(), br.Axis()]),
    }
    for words, call in refusals.items():
        with pytest.raises(InputError, match=words):
            call()
