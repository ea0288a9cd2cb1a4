"""The motion to run: within the limits of the axis, made of what was asked for, and honest about the rest."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st
from tests.prediction.excitation.axes import STAGE

from bristle.core import Axis, InputError
from bristle.models.friction import coulomb_viscous, lugre
from bristle.prediction.excitation import PURPOSES, excite
from bristle.prediction.excitation.excite import _for_the_loop, _in_time, _pieces
from bristle.prediction.excitation.motion import ExcitationMotion, length_of

USUAL = [name for name, purpose in PURPOSES.items() if not purpose.on_request]


def planned(axis=STAGE, **given):
    return excite(axis, rehearsed=False, **given)


def in_time(axis, duration):
    """Return a motion that takes no longer than it may; None where it is refused, because all take longer."""
    try:
        motion = planned(axis, duration=duration).motion
    except InputError as error:
        if not ("needs" in str(error) or "too short" in str(error)):
            raise
        return None
    assert motion.duration <= 1.001 * duration
    return motion


@pytest.mark.slow
@given(
    velocity=st.floats(1e-3, 2.0),
    acceleration=st.floats(0.05, 50.0),
    jerk=st.floats(1.0, 1e5),
    stroke=st.floats(2e-3, 2.0),
    presliding=st.floats(1e-6, 4e-5),
    duration=st.floats(20.0, 120.0),
)
@settings(max_examples=15, deadline=None)
def test_every_limit_is_kept_at_every_sample(
    velocity, acceleration, jerk, stroke, presliding, duration
):
    axis = replace(
        STAGE,
        velocity_limit=velocity,
        acceleration_limit=acceleration,
        jerk_limit=jerk,
        stroke=(0.1, 0.1 + stroke),
        presliding=presliding,
    )
    motion = in_time(axis, duration)
    assume(motion is not None)
    step = motion.sample_time
    assert motion.position.min() >= 0.1
    assert motion.position.max() <= 0.1 + stroke
    assert np.abs(motion.velocity).max() <= velocity
    assert np.abs(motion.acceleration).max() <= acceleration
    assert np.abs(np.diff(motion.position)).max() <= velocity * step
    assert np.abs(np.diff(motion.velocity)).max() <= acceleration * step
    assert np.abs(np.diff(motion.acceleration)).max() <= jerk * step * (1.0 + 1e-6)


@pytest.mark.parametrize(
    ("asked", "seconds"),
    [
        ({"duration": "5 min"}, 300.0),
        ({"duration": 30.0}, 30.0),
        ({"purposes": "break-away"}, 60.0),  # a minute where none is given
        ({"duration": 6.0, "purposes": "break-away"}, 6.0),
        ({"duration": 2.0, "purposes": "damping"}, 2.0),
    ],
)
def test_the_motion_uses_most_of_the_duration(asked, seconds):
    assert planned(**asked).motion.duration == pytest.approx(seconds, rel=0.05)


def test_it_begins_and_ends_at_rest_in_the_middle_of_the_stroke():
    motion = planned().motion
    assert motion.position[[0, -1]] == pytest.approx(0.05, abs=1e-12)
    assert motion.velocity[[0, -1]] == pytest.approx(0.0)
    assert motion.time[1] - motion.time[0] == pytest.approx(1e-3)


def test_chirps_for_the_stiffness_have_rising_amplitudes_up_to_that_for_the_damping():
    friction = lugre(F_C=20.0, F_S=25.0, v_S=1e-3, sigma_0=4e6, sigma_1=1e3)
    (damping,) = planned(purposes="damping", model=friction).motion.pieces
    pieces = planned(purposes="stiffness", model=friction).motion.pieces
    amplitudes = np.array([piece.amplitude for piece in pieces])
    assert amplitudes[-1] == pytest.approx(damping.amplitude)
    assert np.all(np.diff(amplitudes) > 0.0)
    assert 2.0 <= amplitudes[-1] / amplitudes[0] <= 8.001
    assert len({piece.reference.values["f_1"] for piece in (damping, *pieces)}) == 1


def test_travel_limits_the_motion():
    assert 0.015 < np.ptp(planned(travel="20 mm").motion.position) <= 0.02


def test_impossible_purposes_are_left_out_with_the_reason():
    result = planned(replace(STAGE, velocity_limit=None))
    assert {piece.purpose for piece in result.motion.pieces} == set(USUAL) - {"stribeck"}
    assert any("velocity under [limits]" in note for note in result.notes)


@pytest.mark.parametrize(
    ("axis", "given", "told"),
    [
        (replace(STAGE, presliding=None), {"purposes": "presliding"}, "Write presliding under"),
        (replace(STAGE, resolution=3e-6), {"purposes": "presliding"}, "the encoder is too coarse"),
        (replace(STAGE, stroke=None), {"purposes": "stribeck"}, "stroke under"),
        (replace(STAGE, mass=None), {"purposes": "damping"}, "moving mass"),
        (replace(STAGE, sample_time=0.02), {"purposes": "damping"}, "too long for a resonance"),
        (
            replace(STAGE, resolution=0.5e-6, jerk_limit=1e6),
            {"purposes": "stiffness"},
            "too coarse for several amplitudes",
        ),
        (
            Axis(),
            {},
            "axis: contains too few data .*Write velocity under .limits.; write acceleration.*; write stroke under",
        ),
        (STAGE, {"purposes": ""}, "purposes: names no purpose"),
        (STAGE, {"purposes": []}, "purposes: names no purpose"),
        (STAGE, {"purposes": "stribek"}, "Did you mean 'stribeck'"),
        (STAGE, {"travel": "1 m"}, "more than the stroke"),
        (STAGE, {"travel": "-1 mm"}, "must be positive"),
        (STAGE, {"duration": "1 s"}, "duration: out of range"),
        (
            STAGE,
            {"duration": 1e5},
            "samples; found '100000 s', allowed 100 to 1500000 samples. Record the motion in parts, or correct the sample time",
        ),
        (
            replace(STAGE, stroke=(1e9, 1e9 + 0.1)),
            {},
            "too few digits.*Measure positions from a point near the stroke",
        ),
        (
            replace(STAGE, velocity_limit=1e-9),
            {},
            "the typical friction is out of range \\(v_S: out of range.*in the axis file",
        ),
        (
            replace(STAGE, sample_time=10.0),
            {"duration": 20.0},
            "duration: contains 2 samples.*Extend the duration",
        ),
        (
            replace(STAGE, jerk_limit=1e-9),
            {"purposes": "stribeck"},
            "for stribeck within the limits of the axis: acceleration: ",
        ),
        (
            replace(STAGE, jerk_limit=200.0),
            {"purposes": "damping"},
            "Raise jerk to 612 m/s.3 under .limits. for this motion",
        ),
        (
            Axis(velocity_limit=0.1, stroke=(0.0, 1.0)),
            {},
            r"the acceleration limit of the axis is unknown. Write acceleration under \[limits\],",
        ),
        (STAGE, {"model": 3}, "a friction model or a model file"),
        (STAGE, {"model": coulomb_viscous(F_C="1 N*m", F_v=0.0)}, "rotational"),
        (3, {}, "an axis or an axis file"),
        *((STAGE, {"draws": draws}, "draws") for draws in (1, 19, 100_001)),
    ],
)
def test_invalid_arguments_are_refused_with_advice(axis, given, told):
    with pytest.raises(InputError, match=told):
        planned(axis, **given)


@pytest.mark.slow
@given(slow=st.floats(1e-5, 1e-2), seconds=st.floats(2.0, 40.0))
@settings(max_examples=4, deadline=None)
def test_an_axis_that_is_too_slow_for_the_time_is_refused_at_once(slow, seconds):
    # Limits in the wrong unit: no array is made for a motion of a year.
    axis = replace(
        STAGE, velocity_limit=0.3 * slow, acceleration_limit=3.0 * slow, jerk_limit=200.0 * slow
    )
    in_time(axis, seconds)


def test_units_of_a_rotational_axis():
    axis = replace(
        STAGE,
        kind="rotational",
        mass=1e-3,
        effort_limit=2.0,
        stroke=(-3.0, 3.0),
        velocity_limit=30.0,
        acceleration_limit=500.0,
        jerk_limit=None,
        presliding=1e-3,
        resolution=1e-5,
    )
    result = planned(axis, duration="30 s")
    assert result.motion.kind == "rotational"
    assert {piece.reference.kind for piece in result.motion.pieces} == {"rotational"}


def test_the_motion_begins_at_the_axis_position_and_stays_in_the_stroke():
    motion = planned(start="150 mm").motion
    assert motion.position[0] == pytest.approx(0.15)
    assert np.max(motion.position) <= STAGE.stroke[1]
    with pytest.raises(InputError, match="start: leaves no travel on one side"):
        planned(start="250 mm")


@pytest.mark.parametrize(
    ("refused", "allowed"), [((0.101, 10.0), (0.0999, 10.0)), ((1e-3, 1501.0), (1.1e-3, 1501.0))]
)
def test_a_motion_has_a_hundred_samples_at_least_and_a_million_and_a_half_at_most(refused, allowed):
    axis = replace(STAGE, presliding=4e-4, stroke=(-0.5, 0.5), jerk_limit=None)
    with pytest.raises(
        InputError, match=r"duration: contains .* samples; .* allowed 100 to 1500000"
    ):
        planned(replace(axis, sample_time=refused[0]), duration=refused[1], purposes="stribeck")
    motion = planned(
        replace(axis, sample_time=allowed[0]), duration=allowed[1], purposes="stribeck"
    ).motion
    assert motion.duration <= 1.001 * allowed[1]


@pytest.mark.parametrize("scaled", ["position", "velocity", "acceleration"])
def test_a_motion_beyond_a_limit_of_the_axis_is_never_returned(monkeypatch, scaled):
    whole = getattr(ExcitationMotion, scaled).fget
    monkeypatch.setattr(
        ExcitationMotion, scaled, property(lambda motion: 0.05 + 1.5 * (whole(motion) - 0.05))
    )
    name = {"position": "travel"}.get(scaled, scaled)
    with pytest.raises(RuntimeError, match=f"the motion exceeds the {name} of the axis"):
        planned(purposes="stribeck")


def test_missing_start_and_timing_are_noted():
    silent = planned(replace(STAGE, stroke=None, sample_time=None), purposes="break-away")
    assert silent.motion.sample_time == 1e-3
    assert silent.motion.start == 0.0
    assert silent.notes == (
        "bristle assumed a sample time of 1 ms: the axis file has no [timing] entry",
        "the motion begins at position 0: add the present position of your axis, or state it with --start",
        "the rehearsal assumes: Coulomb friction of 70 N, lugre with the usual proportions",
    )


def test_where_the_motion_begins_is_noted():
    friction = lugre(F_C=20.0, F_S=25.0, v_S=1e-3, sigma_0=4e6, sigma_1=1e3)
    assert planned(purposes="break-away", model=friction).notes == (
        "the motion begins in the middle of the stroke, at 50 mm",
    )
    assert planned(purposes="break-away", model=friction, start="150 mm").notes == (
        "the motion begins at 150 mm",
    )


def test_each_purpose_has_its_share_of_the_time():
    limits, seconds = planned(purposes="break-away").limits, 100.0
    pieces = _pieces(USUAL, limits, seconds)
    assert list(dict.fromkeys(piece.purpose for piece in pieces)) == USUAL
    for name in USUAL:
        purpose = PURPOSES[name]
        assert length_of([piece for piece in pieces if piece.purpose == name]) == pytest.approx(
            purpose.share * seconds, rel=0.03
        )
    assert length_of(pieces) == pytest.approx(seconds, rel=1e-3)


def test_chirps_leave_first_and_sweeps_last_where_time_is_short(monkeypatch):
    of_five_seconds = [SimpleNamespace(rest=0.5, duration=4.5, purpose=name) for name in USUAL]
    monkeypatch.setitem(
        _in_time.__globals__,
        "_pieces",
        lambda chosen, *_: [item for item in of_five_seconds if item.purpose in chosen],
    )
    left = {
        seconds: _in_time(USUAL, None, seconds, may_drop=True)
        for seconds in (19.99, 16.0, 11.0, 6.0)
    }
    purposes = [{piece.purpose for piece in pieces} for pieces, _ in left.values()]
    assert purposes == [
        set(USUAL),
        {"presliding", "break-away", "stribeck"},
        {"presliding", "stribeck"},
        {"stribeck"},
    ]
    notes = left[6.0][1]
    assert [note.split()[1] for note in notes] == ["damping", "break-away", "presliding"]
    assert (
        notes[0]
        == "no damping (micro-damping and the resonance on the contact): with it, the motion would take 20.5 s"
    )


@pytest.mark.parametrize("chosen", [["stribeck"], ["damping", "stribeck"]])
def test_too_short_a_duration_for_named_purposes_is_refused(chosen):
    limits = planned(purposes="break-away").limits
    with pytest.raises(
        InputError,
        match=rf"duration: is too short, because a motion for {', '.join(chosen)} needs .* found '?3 s",
    ) as caught:
        _in_time(chosen, limits, 2.5, may_drop=len(chosen) == 1)
    needed = float(str(caught.value).partition("needs ")[2].split()[0])
    assert length_of(_in_time(chosen, limits, 1.05 * (needed - 0.5), may_drop=False)[0]) <= 1.06 * (
        needed - 0.5
    )


def followed(lag, again=None):
    """Return what is planned where the controller follows so closely [m], and the limits it is planned with."""
    first, requested = planned(purposes="presliding"), []

    def plan(limits):
        requested.append(limits)
        if again is None:
            raise InputError("no room", path="duration")
        return again

    return _for_the_loop(first, lag, plan), requested


def test_loops_that_the_controller_follows_stay():
    smallest = 0.7e-6
    assert followed(0.99 * smallest) == (None, [])


def test_loops_that_the_controller_does_not_follow_are_planned_again():
    again = planned(purposes="presliding", start="150 mm")
    result, (limits,) = followed(1.4e-6, again)
    assert limits.followed == 1.4e-6
    assert result.notes == (
        *again.notes,
        "the amplitude of pre-sliding loops is at least 1.4 µm, the tracking error of the controller in the rehearsal",
    )
    assert (
        followed(1.4e-6, planned(purposes="break-away"))[0].notes
        == planned(purposes="break-away").notes
    )
    assert followed(1.4e-6)[0] is None


def test_a_motion_is_rehearsed_with_a_hundred_logs_where_no_number_is_given(monkeypatch):
    requested = []

    def rehearsed(motion, axis, prior, *, draws, progress):
        requested.append(draws)
        return SimpleNamespace(loop=False, lag=0.0)

    monkeypatch.setitem(_in_time.__globals__, "rehearse", rehearsed)
    assert excite(STAGE, purposes="break-away").rehearsal.lag == 0.0
    assert excite(STAGE, purposes="break-away", draws=20).rehearsal is not None
    assert excite(STAGE, purposes="break-away", rehearsed=False).rehearsal is None
    assert requested == [100, 20]


def test_a_rehearsal_that_is_refused_is_noted_and_the_motion_stays(monkeypatch):
    def refused(*passed, **options):
        raise InputError("too short", path="log")

    monkeypatch.setitem(_in_time.__globals__, "rehearse", refused)
    result = excite(STAGE, purposes="break-away")
    assert result.rehearsal is None
    assert result.notes[-1].startswith("the rehearsal failed: log: too short")
    assert result.notes[:-1] == planned(purposes="break-away").notes
