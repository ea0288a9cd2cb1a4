"""What makes a channel unfit, and where a signal is cut off."""

from types import SimpleNamespace

import numpy as np
import pytest

from bristle import controllers
from bristle.core.axis import Axis
from bristle.logs.channel import Channel
from bristle.logs.problems import (
    clipped,
    far_outside,
    limits_exceeded,
    longest_run,
    problems_of,
    spikes,
)

TIME = 1e-3 * np.arange(3000)
MOVED = np.sin(2.0 * np.pi * TIME)
RNG = np.random.default_rng(1)
NOISY = MOVED + 0.01 * RNG.standard_normal(TIME.size)


def gathered(injected=(), **channels):
    kept = {
        name: Channel(values, {"time": "s", "position": "m"}.get(name, "N"), name)
        for name, values in channels.items()
    }
    return SimpleNamespace(
        channels=kept,
        injected=tuple(Channel(values, "N", "push") for values in injected),
        named=lambda: iter(kept.items()),
    )


def message(**channels):
    return [
        str(problem) for problem in problems_of(gathered(**{"time": TIME} | channels), "log.csv")
    ]


def changed(values, **at):
    """A signal with other values at some samples: at_700=np.nan."""
    result = values.copy()
    for place, value in at.items():
        result[int(place.removeprefix("at_"))] = value
    return result


@pytest.mark.parametrize(
    ("channels", "words"),
    [
        (
            {"time": TIME[:99], "position": NOISY[:99]},
            "is too short to be used as the time; found 99, allowed at least 100 samples",
        ),
        # Samples that are no measurement are named before anything else.
        (
            {"position": changed(NOISY, at_700=np.nan, at_701=np.nan), "effort": np.zeros(3000)},
            "has NaN (not a number) in 2 samples, the first at sample 700 (t = 0.7 s)",
        ),
        (
            {"position": changed(NOISY, at_700=np.inf)},
            "an infinite value in 1 sample, the first at sample 700",
        ),
        (
            {"position": changed(NOISY, at_700=-3e30)},
            "has -3e+30 m at sample 700 (t = 0.7 s), which cannot be a measurement: 1 sample in all",
        ),
        (
            {"position": NOISY, "effort": np.full(3000, 2.5)},
            "is constant (2.5 N), so it gives no information on the effort",
        ),
        (
            {"position": changed(MOVED, at_500=MOVED[500] + 0.5, at_501=MOVED[501] + 0.5)},
            "returns after 2 samples at sample 500 (t = 0.5 s), 1 such place in all: the recording lost readings",
        ),
        (
            {"position": changed(MOVED, at_500=MOVED[500] + 0.5, at_900=MOVED[900] - 0.7)},
            "returns after 1 sample at sample 900 (t = 0.9 s), 2 such places in all",
        ),
    ],
)
def test_a_problem_of_a_channel_is_named_with_its_first_sample(channels, words):
    (problem,) = message(**channels)
    assert words in problem


@pytest.mark.parametrize(
    "channels",
    [
        {"position": NOISY, "effort": NOISY},
        {"time": TIME[:100], "position": NOISY[:100]},
        {"position": NOISY, "load": np.ones(3000)},
    ],
)
def test_a_good_log_has_no_problem(channels):
    assert message(**channels) == []


def test_a_reading_that_leaves_and_returns_was_lost():
    position = MOVED.copy()
    position[500:502] += 0.5
    assert spikes(position, 0.0) == [(500, 2, pytest.approx(0.5, abs=0.01))]
    position[500:506] = MOVED[500:506] + 0.5  # six samples are a motion
    assert spikes(position, 0.0) == spikes(position[:20], 0.0) == []


@pytest.mark.parametrize(
    ("values", "places"),
    [
        (changed(NOISY, at_10=3e6), [10]),
        (changed(NOISY, at_10=1e6), []),
        # Six samples on end move.
        (np.where((np.arange(3000) >= 10) & (np.arange(3000) < 16), 3e6, NOISY), []),
        (changed(NOISY, at_10=3e6, at_20=3e6), [10, 20]),
        (changed(NOISY, at_5=-2e30), [5]),
        (np.ones(50), []),
        (np.where(np.arange(3000) < 2990, 0.0, 1.0), []),
    ],
)
def test_far_outside_is_a_million_times_the_usual_range(values, places):
    assert far_outside(values).tolist() == places


@pytest.mark.parametrize(
    ("flags", "run"), [([True, False, True, True, False], (2, 2)), ([False] * 4, (0, 0))]
)
def test_the_longest_run_has_its_first_sample_and_its_length(flags, run):
    assert longest_run(np.array(flags)) == run


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_signal_that_stays_at_its_extreme_is_cut_off(side):
    cut = clipped(side * np.minimum(NOISY, 0.8))
    assert cut.level == side * 0.8
    assert NOISY[cut.first] >= 0.8
    assert cut.samples == np.count_nonzero(NOISY >= 0.8)
    assert cut.longest >= 10
    assert clipped(side * NOISY) is None
    assert clipped(side * np.minimum(NOISY, 0.8), run=cut.longest) is not None
    assert clipped(side * np.minimum(NOISY, 0.8), run=cut.longest + 1) is None


def test_a_known_limit_is_where_a_signal_is_cut_off_though_noise_goes_beyond():
    jittering = np.where(NOISY > 0.8, 0.8 + 1e-7 * RNG.random(3000), NOISY)
    assert clipped(jittering) is None
    assert clipped(jittering, 0.8).samples == np.count_nonzero(NOISY > 0.8)
    assert clipped(jittering, 2.0) is None


def test_an_effort_with_few_levels_or_other_constant_levels_is_not_clipped():
    steps = np.round(3.0 * MOVED)
    assert clipped(steps) is None
    friction = np.where(
        np.arange(3000) % 1500 < 700, 0.8, np.where(np.arange(3000) % 1500 < 1400, 0.3, NOISY)
    )
    assert clipped(np.minimum(friction, 0.8)) is None


LAW = controllers.cascade(k_p=80.0, k_v=500.0, limit=5.0)
BEYOND = pytest.approx(10.0, rel=1e-5)


@pytest.mark.parametrize(
    ("axis", "pushed", "numbers"),
    [
        (Axis(effort_limit=9.0), [], {"value": BEYOND, "limit": 9.0, "key": "[effort] limit"}),
        (Axis(effort_limit=9.6), [], None),  # a twentieth is no matter
        (Axis(controller=LAW), [], {"value": BEYOND, "limit": 5.0, "key": "[controller] limit"}),
        (
            Axis(controller=LAW, effort_limit=9.0),
            [6.0 * MOVED],
            {"value": BEYOND, "limit": 9.0, "key": "[effort] limit"},
        ),
        (Axis(controller=LAW), [6.0 * MOVED], None),
        (Axis(), [], None),
        (Axis(stroke=(-0.5, 1.0)), [], {"value": pytest.approx(2.0, rel=1e-5), "limit": 1.5}),
        (Axis(stroke=(-0.95, 1.0)), [], None),
    ],
)
def test_the_drive_limits_all_effort_the_controller_its_output_and_the_stroke_the_position(
    axis, pushed, numbers
):
    found = limits_exceeded(gathered(pushed, effort=10.0 * MOVED, position=MOVED), axis)
    expected = [] if numbers is None else [("beyond_limit", "warning", numbers)]
    assert [(item.code, item.severity, item.numbers) for item in found] == expected


def plateaus(levels, stay, *, beside=1, still=0):
    """Three rises over so many levels, with a stay at the top, `beside` samples next to it, and a stay half way down."""
    up = np.arange(float(levels))
    down = np.concatenate(
        [
            np.full(beside, levels - 1.0),
            up[-2 : levels // 2 : -1],
            np.full(still, levels // 2),
            up[levels // 2 :: -1],
        ]
    )
    return np.tile(np.concatenate([up, np.full(stay, float(levels)), down]), 3) - 0.3


@pytest.mark.parametrize(
    ("shape", "is_cut"),
    [
        ({"levels": 16, "stay": 20}, True),
        ({"levels": 15, "stay": 20}, False),  # of so few levels a signal is a command
        ({"levels": 40, "stay": 10}, True),
        ({"levels": 40, "stay": 9}, False),  # a run of fewer than ten samples
        ({"levels": 40, "stay": 20, "beside": 3}, True),
        ({"levels": 40, "stay": 20, "beside": 4}, False),  # a fifth as often beside its extreme
        ({"levels": 40, "stay": 20, "still": 7}, True),
        ({"levels": 40, "stay": 20, "still": 12}, False),  # it stays elsewhere, half as long
    ],
)
def test_clipping_needs_ten_samples_and_five_times_the_next_level(shape, is_cut):
    for side in (1.0, -1.0):
        cut = clipped(side * plateaus(**shape))
        assert (cut is not None) is is_cut
        if cut:
            assert (cut.level, cut.longest, cut.samples) == (
                side * (shape["levels"] - 0.3),
                shape["stay"],
                3 * shape["stay"],
            )
