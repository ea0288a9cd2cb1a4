"""Limits of effort and following error: the motion becomes slower until its rehearsal respects them."""

from dataclasses import replace
from importlib import import_module
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from tests.prediction.excitation.axes import STAGE

from bristle.models.controllers import cascade
from bristle.models.friction import lugre
from bristle.prediction.excitation import excite
from bristle.prediction.excitation.excite import _in_time
from bristle.prediction.excitation.rehearsal import exceeded
from bristle.report.excitation import excitation_ruling

TRUTH = lugre(F_C=60.0, F_S=80.0, v_S=2e-3, sigma_0=1.2e7, sigma_1=4e3, sigma_2=150.0)
LOOP = cascade(k_p=60.0, k_v=4e3, k_i=1.6e6)
AXIS = replace(STAGE, resolution=1e-8, controller=LOOP, effort_limit=None)
WORDS = "because faster motion exceeds the limit of effort or following error in the rehearsal"


def rehearsed(axis, **options):
    return excite(
        axis, **{"duration": "10 s", "purposes": "stribeck", "model": TRUTH, "draws": 0} | options
    )


@pytest.fixture(scope="module")
def free():
    """A motion on an axis without limits of effort and following error."""
    return rehearsed(AXIS)


@pytest.fixture(autouse=True)
def identified_before(monkeypatch, free):
    """Each log gives what the log of the free motion gives: the limits do not depend on that."""
    monkeypatch.setattr(
        import_module("bristle.prediction.excitation.rehearsal"),
        "identify",
        lambda *log, **how: free.rehearsal.identification,
    )


def test_a_loop_within_its_limits_keeps_its_motion(free):
    error, effort = free.rehearsal.following_error, free.rehearsal.peak_effort
    kept = rehearsed(replace(AXIS, following_error_limit=1.01 * error, effort_limit=1.01 * effort))
    assert np.array_equal(kept.motion.position, free.motion.position)
    assert kept.notes == free.notes
    assert kept.exceeded == ()


@pytest.mark.parametrize("share", [0.5, 0.1])
def test_a_motion_becomes_slower_until_the_following_error_is_within_its_limit(free, share):
    limit = share * free.rehearsal.following_error
    slower = rehearsed(replace(AXIS, following_error_limit=limit))
    log = slower.rehearsal.log
    assert 0.5 * limit < np.max(np.abs(log.reference.values - log.position.values)) <= limit
    fastest = [np.max(np.abs(result.motion.velocity)) for result in (slower, free)]
    assert 0.5 * share < fastest[0] / fastest[1] < share
    of_velocity, of_acceleration = (
        getattr(slower.limits, name) / getattr(free.limits, name)
        for name in ("velocity", "acceleration")
    )
    assert of_acceleration == pytest.approx(of_velocity, rel=0.05)
    assert slower.notes[:-1] == free.notes
    assert slower.notes[-1].startswith("bristle limited the motion to ")
    assert slower.notes[-1].endswith(WORDS)
    assert f"{1e3 * slower.limits.velocity:.3g} mm/s" in slower.notes[-1].replace(
        "\u202f", " "
    ).replace("\u00a0", " ")
    assert excitation_ruling(slower).level != "no"


@pytest.mark.parametrize("saturation", [inf, 400.0])
def test_a_motion_becomes_slower_until_the_effort_is_within_its_limit(saturation):
    hard = replace(
        AXIS,
        acceleration_limit=30.0,
        effort_limit=400.0,
        controller=LOOP.with_values(limit=saturation),
    )
    free, slower = rehearsed(replace(hard, effort_limit=None, controller=LOOP)), rehearsed(hard)
    assert free.rehearsal.peak_effort > 500.0
    assert slower.rehearsal.peak_effort < 400.0
    assert np.max(np.abs(slower.motion.acceleration)) < 0.8 * np.max(
        np.abs(free.motion.acceleration)
    )
    assert slower.notes[-1].endswith(WORDS)
    assert excitation_ruling(slower).level != "no"


@pytest.mark.parametrize(
    ("limits", "names"),
    [
        ({"following_error_limit": 1e-6}, ("following error",)),
        ({"effort_limit": 50.0}, ("effort",)),
        ({"following_error_limit": 1e-6, "effort_limit": 50.0}, ("effort", "following error")),
    ],
)
def test_a_motion_that_no_speed_keeps_within_the_limits_is_not_to_be_run(free, limits, names):
    result = rehearsed(replace(AXIS, **limits))
    assert result.exceeded == names
    assert result.notes[-1].startswith(
        f"the rehearsal exceeds the limit of {' and '.join(names)}, and no slower motion "
    )
    assert np.array_equal(result.motion.position, free.motion.position)
    ruling = excitation_ruling(result)
    assert (ruling.level, ruling.words) == ("no", "Do not run it")
    assert len(ruling.reasons) >= len(names)
    # The verdict stays, even if the simulated log cannot be identified.
    assert excitation_ruling(replace(result, rehearsal=None)).words == "Do not run it"


def test_without_a_controller_the_motion_stays_and_its_effort_decides():
    bare = replace(AXIS, controller=None, acceleration_limit=30.0)
    free, limited = (
        rehearsed(bare),
        rehearsed(replace(bare, effort_limit=400.0, following_error_limit=1e-9)),
    )
    assert np.array_equal(limited.motion.position, free.motion.position)
    assert limited.notes == free.notes
    ruling = excitation_ruling(limited)
    assert (ruling.level, ruling.words, ruling.reasons[0]) == (
        "no",
        "Do not run it",
        "the effort exceeds the limit of the drive",
    )


@pytest.mark.slow
def test_a_motion_planned_again_for_its_loops_is_slower_too():
    stiff = replace(
        AXIS, controller=cascade(k_p=150.0, k_v=1e4, k_i=2e6), following_error_limit=0.9e-3
    )
    slower = rehearsed(stiff, purposes="presliding,stribeck", duration="22 s")
    assert 0.4e-3 < slower.rehearsal.following_error <= 0.9e-3
    assert slower.limits.followed > 0.0
    assert [
        note
        for note in slower.notes
        if note.startswith("the amplitude of pre-sliding loops is at least")
    ]
    assert slower.notes[-1].endswith(WORDS)


FOLLOWING = replace(AXIS, following_error_limit=1.0)
STILL = replace(FOLLOWING, velocity_limit=None, acceleration_limit=None)
EFFORT = replace(AXIS, effort_limit=400.0)
QUICK = {"purposes": "break-away"}


@pytest.mark.parametrize(
    ("axis", "options", "ratios", "lag", "names", "limits"),
    [
        # An unknown limit stays unknown, and without any the axis cannot be slower.
        (
            replace(FOLLOWING, velocity_limit=None),
            QUICK,
            [{"following error": 2.0}, {}],
            0.0,
            (),
            {"velocity": None},
        ),
        (
            replace(FOLLOWING, acceleration_limit=None),
            QUICK,
            [{"following error": 2.0}, {}],
            0.0,
            (),
            {"acceleration": None},
        ),
        (
            replace(FOLLOWING, velocity_limit=None, acceleration_limit=None),
            QUICK,
            [{"following error": 2.0}, {}],
            0.0,
            ("following error",),
            {},
        ),
        # A slower motion with an unstable loop is no remedy, and an unstable loop leaves the motion.
        (EFFORT, {}, [{"effort": 2.0}, None], 0.0, ("effort",), {}),
        (EFFORT, {}, [None], 0.0, (), {}),
        # A motion that is planned again for its loops is checked again.
        (
            EFFORT,
            {"purposes": "presliding", "duration": "16 s"},
            [{}, {"effort": 2.0}],
            2e-6,
            ("effort",),
            {"followed": 2e-6},
        ),
    ],
)
def test_a_motion_is_slower_if_that_helps(monkeypatch, axis, options, ratios, lag, names, limits):
    """The ratios to the limits are those of one simulation after the other, and rehearsals take no time."""
    left = list(ratios)
    monkeypatch.setitem(
        _in_time.__globals__, "rehearse", lambda *_, **__: SimpleNamespace(loop=True, lag=0.0)
    )
    monkeypatch.setitem(_in_time.__globals__, "lag_of", lambda *_: lag)
    monkeypatch.setitem(
        _in_time.__globals__, "exceeded", lambda *_: left.pop(0) if len(left) > 1 else left[0]
    )
    result = rehearsed(axis, **options)
    assert result.exceeded == names
    assert {name: getattr(result.limits, name) for name in limits} == limits
    if ratios == [None]:
        assert not any("bristle limited the motion" in note for note in result.notes)


def test_an_unstable_loop_has_no_ratios_to_its_limits(free):
    axis = replace(AXIS, controller=cascade(k_p=6e4, k_v=4e3), effort_limit=1.0)
    assert exceeded(free.motion, axis, free.prior) is None
