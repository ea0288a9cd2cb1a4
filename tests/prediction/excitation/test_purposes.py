"""Each purpose: when an axis allows it, and the amplitudes, speeds and times of its pieces."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bristle.prediction.excitation import purposes
from bristle.prediction.excitation.limits import MotionLimits
from bristle.prediction.excitation.motion import length_of
from bristle.prediction.excitation.purposes import PURPOSES

LIMITS = MotionLimits(
    "translational",
    sample_time=1e-3,
    travel=0.1,
    velocity=10.0,
    acceleration=2.5,
    count=1e-7,
    presliding=1e-5,
    resonance=60.0,
)


USUAL = ("presliding", "break-away", "damping", "stribeck")


def pieces_of(purpose, seconds=20.0, **changes):
    return PURPOSES[purpose].pieces(replace(LIMITS, **changes), seconds)


def missing(purpose, **changes):
    return PURPOSES[purpose].missing(replace(LIMITS, **changes))


@pytest.mark.parametrize("purpose", PURPOSES)
def test_a_complete_axis_file_allows_every_purpose(purpose):
    assert missing(purpose) == ""


@pytest.mark.parametrize("purpose", ["presliding", "break-away", "damping"])
@pytest.mark.parametrize(
    ("allowed", "refused", "why"),
    [
        # Half of the largest loop, which is 97 % of the pre-sliding amplitude.
        (
            {"count": 1.61e-6},
            {"count": 1.62e-6},
            "3 steps of 1.62 µm are not small against the pre-sliding amplitude of 10 µm",
        ),
        (
            {"followed": 4.8e-6},
            {"followed": 4.9e-6},
            "is 4.9 µm, which is not small against the pre-sliding amplitude of 10 µm",
        ),
        # Four pre-sliding amplitudes to either side.
        ({"travel": 8.1e-5}, {"travel": 7.9e-5}, "a travel of 80 µm"),
        ({"travel": None}, {"presliding": None}, "Write presliding under"),
    ],
)
def test_loops_before_sliding_are_allowed_up_to_a_bound(purpose, allowed, refused, why):
    if purpose != "damping" or "count" not in allowed:  # a chirp is smaller than that
        assert missing(purpose, **allowed) == ""
    assert why in missing(purpose, **refused)


@pytest.mark.parametrize("purpose", ["presliding", "break-away"])
def test_a_conditioning_slide_of_four_presliding_amplitudes_takes_a_second_and_a_half(purpose):
    slide = pieces_of(purpose)[0]
    assert (slide.name, slide.purpose, slide.rest) == ("conditioning slide", purpose, 0.2)
    assert (slide.amplitude, slide.duration) == (pytest.approx(4e-5), pytest.approx(1.5, rel=0.2))
    assert slide.speed == pytest.approx(1.6e-4 / 1.5)
    assert np.ptp(slide.sample(np.linspace(0.0, slide.duration, 2001))[0]) == pytest.approx(
        8e-5, rel=1e-3
    )


@pytest.mark.parametrize(
    ("changes", "smallest"), [({}, 1e-6), ({"count": 5e-7}, 1.5e-6), ({"followed": 2e-6}, 2e-6)]
)
def test_loops_grow_evenly_from_the_smallest_that_shows_to_almost_the_presliding_amplitude(
    changes, smallest
):
    loops = [
        piece.amplitude for piece in pieces_of("presliding", **changes) if piece.name == "triangles"
    ]
    assert loops == pytest.approx([smallest + k / 13.0 * (9.7e-6 - smallest) for k in range(14)])


@pytest.mark.parametrize(
    ("purpose", "name", "slowest"),
    [
        # A thousandth of a longest leg in five seconds.
        ("presliding", "triangles", 1e-3 * 2.0 * 9.7e-6 / 5.0),
        # A hundredth of a turn in a fifth of the time.
        ("break-away", "break-away ramp", 1e-2 * 2e-5 / (0.2 * 20.0)),
        # A hundredth of ten slides of 200 um in the time.
        ("stribeck", "constant velocity", 1e-2 * 10 / 20.0 * 2e-4),
    ],
)
def test_no_time_is_so_long_that_a_motion_stands_still(monkeypatch, purpose, name, slowest):
    monkeypatch.setattr(purposes, "in_time", lambda make, seconds, pace, low, high: make(low))
    assert min(piece.speed for piece in pieces_of(purpose) if piece.name == name) == pytest.approx(
        slowest
    )


def test_decaying_loops_end_at_a_seventh_of_the_largest_loop():
    loops = pieces_of("presliding")[1]
    x, v, _ = loops.sample(np.linspace(0.0, loops.duration, 20_001))
    turns = x[np.flatnonzero(v[1:-1] * v[2:] < 0.0) + 1]
    assert loops.name == "decaying loops"
    assert turns.size == 10
    assert abs(turns[0]) == pytest.approx(9.7e-6, rel=1e-3)
    assert abs(turns[-1] / turns[0]) == pytest.approx(0.15, rel=1e-3)


@pytest.mark.parametrize(("seconds", "cycles"), [(100.0, 2), (400.0, 4), (1000.0, 10)])
def test_time_goes_into_more_cycles_with_longest_legs_of_five_or_six_seconds(seconds, cycles):
    pieces = pieces_of("presliding", seconds)
    assert length_of(pieces) == pytest.approx(seconds, rel=1e-3)
    assert {piece.reference.values["cycle_count"] for piece in pieces[2:]} == {cycles}
    assert 2.0 * 9.7e-6 / pieces[-1].speed == pytest.approx(6.0, rel=0.1) or cycles == 2


def test_break_away_has_three_rates_by_factors_of_four_and_reverses_first():
    _, *ramps = pieces_of("break-away")
    assert [ramp.name for ramp in ramps] == ["break-away ramp"] * 6
    assert [ramp.speed / ramps[0].speed for ramp in ramps] == pytest.approx(
        [1.0, 1.0, 4.0, 4.0, 16.0, 16.0]
    )
    assert [ramp.end for ramp in ramps] == pytest.approx([-5e-5, 5e-5] * 3)
    assert [ramp.amplitude for ramp in ramps] == pytest.approx([-5e-5, 5e-5] * 3)
    assert {ramp.rest for ramp in ramps} == {0.4}


@pytest.mark.parametrize("purpose", ["break-away", "stribeck", "damping", "presliding"])
def test_the_pieces_of_each_purpose_take_the_time_that_it_is_given(purpose):
    assert length_of(pieces_of(purpose, 25.0)) == pytest.approx(25.0, rel=0.03)


@pytest.mark.parametrize(
    ("unknown", "why"),
    [
        ("velocity", "the velocity limit of the axis is unknown. Write velocity under [limits]"),
        (
            "acceleration",
            "the acceleration limit of the axis is unknown. Write acceleration under [limits], or limit under [effort]",
        ),
        (
            "travel",
            "the travel limit of the axis is unknown. Write stroke under [limits], or give a travel",
        ),
    ],
)
def test_constant_velocities_take_all_limits_of_the_axis(unknown, why):
    assert missing("stribeck", **{unknown: None}).startswith(why)


def test_velocities_span_a_factor_of_three_at_least():
    # The slowest is a fifth of the Stribeck velocity, the fastest what speeding up within an eighth of the travel reaches.
    assert missing("stribeck", stribeck_velocity=0.41) == ""
    assert (
        missing("stribeck", stribeck_velocity=0.42)
        == "a travel of 100 mm is too short for several velocities. Raise the stroke or the travel"
    )
    assert missing("stribeck", velocity=0.1, stribeck_velocity=0.16) == ""
    assert "too short" in missing("stribeck", velocity=0.1, stribeck_velocity=0.17)


def speeds_of(seconds=20.0, **changes):
    return [piece.speed for piece in pieces_of("stribeck", seconds, **changes)]


@pytest.mark.parametrize("jerk", [math.inf, 50.0, 3.0])
def test_the_fastest_sweep_is_at_speed_after_an_eighth_of_the_travel(jerk):
    # Up to v with an acceleration a that rises and falls by the jerk j takes the way v / 2 (v / a + a / j).
    v = speeds_of(jerk=jerk)[-1]
    assert 0.5 * v * (v / 2.5 + 2.5 / jerk) == pytest.approx(0.0125)


def test_ten_velocities_follow_each_other_by_the_same_factor():
    speeds = speeds_of(stribeck_velocity=1e-2)
    assert (len(speeds), speeds[0], speeds[-1]) == (10, pytest.approx(2e-3), pytest.approx(0.25))
    assert np.diff(np.log(speeds)) == pytest.approx(math.log(125.0) / 9.0)


def test_sweeps_of_all_velocities_take_the_same_time():
    sweeps = pieces_of("stribeck", 60.0, stribeck_velocity=1e-2)
    ways = np.array(
        [
            4.0 * piece.amplitude * piece.reference.values["cycle_count"] / piece.speed
            for piece in sweeps
        ]
    )
    assert {piece.name for piece in sweeps} == {"constant velocity"}
    assert ways[:6] == pytest.approx(ways[0])
    assert ways[6:] == pytest.approx(ways[0], rel=0.3)  # whole cycles of half the travel
    assert sweeps[-1].reference.values["cycle_count"] == 6
    assert sweeps[0].reference.values["cycle_count"] == 1


def test_sweeps_go_half_the_travel_at_most_and_have_room_to_speed_up_and_brake():
    sweeps = pieces_of("stribeck", 20.0, stribeck_velocity=1e-2, jerk=50.0)
    for piece in sweeps:
        braking = piece.speed**2 / 2.5 + piece.speed * 2.5 / 50.0
        assert min(2.0 * braking, 0.05) - 1e-12 <= piece.amplitude <= 0.05
        assert piece.amplitude >= 5e-5
        assert piece.reference.values["acceleration"] == pytest.approx(
            min(20.0 * piece.speed**2 / piece.amplitude, 2.5)
        )
    assert max(piece.amplitude for piece in pieces_of("stribeck", 400.0)) == 0.05


@pytest.mark.parametrize(
    ("allowed", "refused", "why"),
    [
        ({}, {"resonance": None}, "Write the moving mass under [plant]"),
        # Five samples in a period: 200 Hz, and a quarter more than the resonance is needed.
        (
            {"resonance": 159.0},
            {"resonance": 161.0},
            "the sample time of 1 ms is too long for a resonance at 161 Hz",
        ),
        # An amplitude of two steps: 0.2 um at 150 Hz are 0.178 m/s^2.
        (
            {"acceleration": 0.18},
            {"acceleration": 0.17},
            "at 150 Hz, but the amplitude must be 2 steps of the encoder, each 100 nm",
        ),
    ],
)
def test_a_chirp_is_allowed_up_to_a_bound(allowed, refused, why):
    assert missing("damping", **allowed) == ""
    assert why in missing("damping", **refused)


def test_a_chirp_passes_from_an_eighth_of_the_resonance_to_two_and_a_half_of_it():
    (piece,) = pieces_of("damping", 10.0)
    values = piece.reference.values
    assert (piece.name, piece.rest) == ("chirp", 0.2)
    assert (values["f_0"], values["f_1"]) == pytest.approx((7.5, 150.0))
    assert values["duration"] == pytest.approx(9.8)
    assert values["ramp"] == pytest.approx(2.0 / 7.5)
    assert piece.speed == pytest.approx(2.0 * math.pi * 150.0 * piece.amplitude)


@pytest.mark.parametrize(
    ("changes", "amplitude"),
    [
        ({}, 2e-6),  # a fifth of the pre-sliding amplitude
        ({"count": 1.5e-6}, 2.5 / 888_264.0),  # two steps would be too fast
        ({"velocity": 1e-3}, 1e-3 / 942.478),
        ({"acceleration": 1.0}, 1.0 / 888_264.0),
        ({"jerk": 1000.0}, 1000.0 / 837_169_000.0),
        ({"acceleration": None, "count": 1.5e-6}, 3e-6),
    ],
)
def test_a_chirp_is_small_before_sliding_and_keeps_the_limits_at_its_highest_frequency(
    changes, amplitude
):
    (piece,) = pieces_of("damping", 10.0, **changes)
    assert piece.amplitude == pytest.approx(amplitude, rel=1e-3)


def braking(piece):
    """The way of speeding up and braking together."""
    return piece.speed**2 / piece.reference.values["acceleration"]


def slow(seconds=20.0, **changes):
    return speeds_of(seconds, stribeck_velocity=1e-5, **changes)[0]


@pytest.mark.parametrize(
    ("number", "expected"),
    [
        pytest.param(
            lambda: [PURPOSES[name].share for name in USUAL],
            [0.55, 0.12, 0.08, 0.25],
            id="shares are the whole time",
        ),
        pytest.param(
            lambda: LIMITS.corner(1.0, 1.0), 2.5, id="corners keep the largest acceleration"
        ),
        pytest.param(lambda: LIMITS.corner(0.1, 1.0), 0.2, id="corners are a tenth of the way"),
        # Corners take a tenth of the shortest leg, which is twice the last turning point.
        pytest.param(
            lambda: braking(pieces_of("presliding", acceleration=None)[1]),
            0.1 * 0.15 * 9.7e-6,
            id="corners of decaying loops",
        ),
        pytest.param(
            lambda: braking(pieces_of("presliding", acceleration=None)[2]),
            0.1 * 1e-6,
            id="corners of a pair",
        ),
        pytest.param(
            lambda: braking(pieces_of("break-away", acceleration=None)[1]),
            0.05 * 1e-5,
            id="a ramp is at speed early in pre-sliding",
        ),
        pytest.param(
            lambda: 2e-6 / pieces_of("presliding", 0.1)[2].speed,
            25e-3,
            id="the shortest leg before sliding has twenty-five samples",
        ),
        pytest.param(
            lambda: pieces_of("presliding", 0.1, velocity=1e-5)[2].speed,
            1e-5,
            id="loops keep the velocity limit",
        ),
        pytest.param(
            lambda: [
                (piece.speed, piece.reference.values["cycle_count"])
                for piece in pieces_of("presliding", 300.0, velocity=1e-6)[2:]
            ],
            14 * [(1e-6, 2)],
            id="an axis slower than the slowest loops runs two cycles",
        ),
        pytest.param(
            lambda: max(piece.speed for piece in pieces_of("break-away", 4.0)[1:]),
            2e-5 / 50e-3,
            id="a ramp has fifty samples in the turn",
        ),
        pytest.param(
            lambda: max(piece.speed for piece in pieces_of("break-away", 4.0, velocity=1e-4)[1:]),
            1e-4,
            id="ramps keep the velocity limit",
        ),
        # Of 20 s, for a slide to and fro of five pre-sliding amplitudes to either side: 200 um.
        pytest.param(slow, 2e-4 / 6.0, id="the slowest sweep takes three tenths of the time"),
        pytest.param(
            lambda: slow(count=1e-6),
            8e-4 / 6.0,
            id="the slowest sweep is of 200 steps of the encoder",
        ),
        pytest.param(
            lambda: slow(count=0.0, presliding=None),
            4e-3 / 6.0,
            id="the slowest sweep is of a hundredth of the travel",
        ),
        pytest.param(
            lambda: (
                speeds_of(0.3, stribeck_velocity=1.0)[-1] / speeds_of(0.3, stribeck_velocity=1.0)[0]
            ),
            3.0,
            id="the slowest is a third",
        ),
        pytest.param(
            lambda: sorted(
                {
                    piece.amplitude
                    for piece in pieces_of("stribeck", count=1e-3, stribeck_velocity=1e-2)
                }
            ),
            [0.05],
            id="slides stay within the travel",
        ),
        pytest.param(
            lambda: pieces_of("damping", 0.3)[0].duration,
            4.0 / 7.5,
            id="a chirp takes four of its longest periods",
        ),
        pytest.param(
            lambda: pieces_of("damping", 0.3)[0].reference.values["ramp"],
            0.8 / 7.5,
            id="a chirp fades over a fifth",
        ),
    ],
)
def test_a_motion_is_made_by_its_rule(number, expected):
    assert np.ravel(number()) == pytest.approx(np.ravel(expected))
