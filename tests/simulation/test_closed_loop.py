"""The closed loop of a log: where it begins, what it follows, and what becomes of a stretch."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bristle import controllers, friction, plants
from bristle.core import Axis
from bristle.core.errors import InputError
from bristle.core.packing import pack
from bristle.core.status import Status
from bristle.engine import run_open_loop
from bristle.engine.loop_derivatives import Sensitive
from bristle.logs.log import Channel, Log
from bristle.models.sensors import encoder
from bristle.simulation.recorded.closed_loop import (
    Beginning,
    Stretch,
    beginning_of,
    can_be_simulated,
    closed_loop_of,
    desired_of,
    resumed_effort_at,
)

pytestmark = pytest.mark.usefixtures("in_plain_python")

DT = 1e-2
LAW = controllers.cascade(k_p=10.0, k_v=100.0, k_i=1e3)
PLANT, FILM = plants.inertia(M=2.0), friction.viscous(F_v=5.0)


def log_of(position, effort=None, **changes):
    time = DT * np.arange(len(position))
    channels = {
        "time": Channel(time, "s", "t"),
        "position": Channel(np.asarray(position, float), "m", "q"),
        "effort": Channel(
            np.ones(time.size) if effort is None else np.asarray(effort, float), "N", "u"
        ),
        "reference": Channel(np.asarray(position, float) + 0.01, "m", "r"),
    }
    return Log(**(channels | {"sample_time": DT, "segments": (slice(0, time.size),)} | changes))


def cubic(count=100):
    t = DT * np.arange(count)
    return 0.3 + 0.2 * t + 0.5 * t**2 - 0.4 * t**3


@pytest.mark.parametrize("first", [0, 3, 50])
@pytest.mark.parametrize("resolution", [None, 1e-6, 1e-3])
def test_a_motion_begins_with_the_velocity_and_the_acceleration_of_a_cubic(first, resolution):
    t = DT * first
    begun = beginning_of(log_of(cubic()), first, resolution)
    assert begun.x == cubic()[first]
    assert (begun.v, begun.acceleration) == pytest.approx(
        (0.2 + t - 1.2 * t**2, 1.0 - 2.4 * t), rel=1e-6
    )
    assert begun.moves is True


def straight(reach):
    """Return a motion of 0.5 m/s so many samples around number 100, at rest before and after."""
    return 0.5 * DT * np.clip(np.arange(200.0) - 100.0, -reach[0], reach[1])


def test_a_motion_is_looked_at_over_as_few_samples_as_a_hundred_counts_take():
    # Eight samples of 5 mm span 35 mm.
    enough, too_few = (
        beginning_of(log_of(straight((4, 3))), 100, resolution) for resolution in (3.4e-4, 3.6e-4)
    )
    assert enough.v == pytest.approx(0.5)
    assert too_few.v < 0.49


@pytest.mark.parametrize("resolution", [None, 0.0, 1e-2])
@pytest.mark.parametrize(
    ("reach", "is_enough"), [((20, 20), True), ((20, 19), False), ((19, 20), False)]
)
def test_a_motion_of_few_counts_is_looked_at_over_twenty_samples_to_either_side(
    resolution, reach, is_enough
):
    assert (
        beginning_of(log_of(straight(reach)), 100, resolution).v == pytest.approx(0.5)
    ) is is_enough


@pytest.mark.parametrize(("counts", "moves"), [(1, False), (2, True)])
def test_a_position_that_flickers_by_a_count_rests(counts, moves):
    position = 0.2 + 1e-4 * counts * (np.arange(200) % 2)
    assert beginning_of(log_of(position), 100, 1e-4).moves is moves


def test_friction_of_a_motion_under_way_has_moved_for_long():
    bristles, rest = friction.lugre(F_C=20.0, F_S=20.0, v_S=1.0, sigma_0=1e6), Beginning(0.3)
    assert (rest.v, rest.acceleration, rest.moves) == (0.0, 0.0, False)
    assert Beginning(0.3, 0.2).state(bristles) == {"x": 0.3, "v": 0.0}
    state = Beginning(0.3, -0.2, 1.0, moves=True).state(bristles)
    assert (state["x"], state["v"], state["memory"].size) == (0.3, -0.2, 0)
    assert state["state"].z == pytest.approx(-20e-6)


def test_a_recorded_reference_has_derivatives_and_zero_feedforward():
    desired = desired_of(cubic(), DT)
    t = DT * np.arange(100)
    assert desired.shape == (4, 100)
    assert desired[0].tolist() == cubic().tolist()
    assert desired[1][5:-5] == pytest.approx((0.2 + t - 1.2 * t**2)[5:-5], abs=1e-4)
    assert desired[2][5:-5] == pytest.approx((1.0 - 2.4 * t)[5:-5], abs=1e-3)
    assert desired[3].tolist() == [0.0] * 100


def axis_of(**changes):
    return Axis(**({"controller": LAW, "resolution": 1e-6, "lag": 1e-3} | changes))


def test_a_loop_has_the_values_of_axis_and_log():
    log = log_of(cubic(), 3.0 + np.arange(100.0), injected=(Channel(np.full(100, 0.5), "N", "d"),))
    loop = closed_loop_of(log, axis_of(effort_limit=50.0), slice(20, 80))
    values = {
        "count": 60,
        "sample_time": DT,
        "limit": 50.0,
        "resolution": 1e-6,
        "lag": 1e-3,
        "effort_before": 23.0,
    }
    assert {name: getattr(loop, name) for name in values} == values
    assert loop.injected.tolist() == [0.5] * 60
    assert loop.desired[0] == pytest.approx(cubic()[20:80] + 0.01)
    assert loop.beginning.x == cubic()[20]
    bare = closed_loop_of(log, axis_of(resolution=None), slice(0, 100))
    assert (bare.resolution, bare.limit) == (0.0, math.inf)


@pytest.mark.parametrize(
    ("changes", "axis", "options", "words"),
    [
        (
            {},
            Axis(),
            (),
            r"axis.controller: is needed to predict the closed loop.*or use --mode inverse",
        ),
        (
            {"reference": None},
            Axis(controller=LAW),
            ("to do that", "leave it"),
            r"log: has no reference to follow.*\[columns\] of the axis file, or leave it",
        ),
    ],
)
def test_a_loop_that_lacks_its_controller_or_its_reference_is_refused(
    changes, axis, options, words
):
    with pytest.raises(InputError, match=words):
        closed_loop_of(replace(log_of(cubic()), **changes), axis, slice(0, 100), *options)


@pytest.mark.parametrize(
    ("changes", "controller", "loop", "can"),
    [
        ({}, LAW, "closed-loop", True),
        ({}, None, "closed-loop", False),
        ({}, None, "open-loop", True),
        ({"reference": None}, LAW, "closed-loop", False),
        ({"reference": None}, LAW, "open-loop", True),
        ({"effort": None}, LAW, "closed-loop", False),
        ({"effort": None}, LAW, "open-loop", False),
    ],
)
def test_a_log_with_the_data_of_a_loop_can_be_simulated(changes, controller, loop, can):
    assert (
        can_be_simulated(replace(log_of(cubic()), **changes), Axis(controller=controller), loop)
        is can
    )


def test_a_loop_elsewhere_on_the_axis_is_moved_as_a_whole():
    loop = closed_loop_of(log_of(cubic()), axis_of(), slice(0, 100))
    moved = loop.moved_by(0.5)
    assert moved.desired[0] == pytest.approx(loop.desired[0] + 0.5)
    assert moved.desired[1:].tolist() == loop.desired[1:].tolist()
    assert moved.beginning.x == pytest.approx(loop.beginning.x + 0.5)
    assert loop.desired[0][0] == pytest.approx(0.31)


def test_an_integral_resumes_with_the_effort_that_the_law_lacks():
    # 0.01 m behind the reference the law asks for 10 N, and for 1 N more from sample to sample: over 20 samples for 19.5 N.
    still = log_of(np.full(100, 0.3), np.full(100, 17.0))
    loop = closed_loop_of(still, axis_of(), slice(10, 60))
    assert loop.resumed_effort == pytest.approx(17.0 - 19.5 + 10.0)
    pushed = replace(still, injected=(Channel(np.full(100, 4.0), "N", "d"),))
    assert closed_loop_of(pushed, axis_of(), slice(10, 60)).resumed_effort == pytest.approx(
        13.0 - 19.5 + 10.0
    )
    assert (
        resumed_effort_at(LAW, loop.desired, replace(still, effort=None), 10, loop.beginning)
        is None
    )


def test_a_loop_runs_from_where_the_log_begins_by_its_own_drive():
    loop = closed_loop_of(log_of(cubic()), axis_of(), slice(20, 60))
    plain, other = (
        loop.run(PLANT, FILM),
        loop.run(PLANT, FILM, lag=0.1, disturbance=np.full(40, 3.0)),
    )
    assert plain.position[0] == cubic()[20]
    assert plain.velocity[0] == pytest.approx(loop.beginning.v)
    assert plain.measured / 1e-6 == pytest.approx(np.round(plain.measured / 1e-6), abs=1e-6)
    assert not np.allclose(plain.position, other.position)
    assert plain.measured[-1] == pytest.approx(cubic()[59] + 0.01, abs=0.05)


def test_an_open_loop_leaves_out_the_samples_before_its_velocity_is_known():
    log = log_of(cubic())
    opened, closed, rested = (
        Stretch.of(log, Axis(at_rest=rest), loop, slice(5, 90))
        for loop, rest in (("open-loop", False), ("closed-loop", False), ("open-loop", True))
    )
    assert [item.samples for item in (opened, closed, rested)] == [
        slice(25, 90),
        slice(5, 90),
        slice(5, 90),
    ]
    assert (opened.count, closed.count) == (65, 85)
    assert opened.position.tolist() == cubic()[25:90].tolist()
    assert Stretch.of(log, Axis(), "open-loop", slice(5, 15)).count == -10


@pytest.mark.parametrize("hold", [None, "linear", "band_limited"])
def test_an_open_loop_continues_from_the_state_of_the_log(hold):
    # 2 a + 5 v = u along the motion of the log.
    t = DT * np.arange(100)
    effort = 2.0 * (1.0 - 2.4 * t) + 5.0 * (0.2 + t - 1.2 * t**2)
    stretch = Stretch.of(log_of(cubic(), effort), Axis(hold=hold), "open-loop", slice(0, 100))
    course = stretch.run(PLANT, FILM, np.zeros(80))
    assert course.status is Status.OK
    assert course.position[0] == pytest.approx(cubic()[20])
    assert course.position == pytest.approx(cubic()[20:], abs=3e-3)
    assert course.command == pytest.approx(effort[20:])
    pushed = stretch.run(PLANT, FILM, np.full(80, 1.0))
    assert pushed.position[-1] < course.position[-1] - 0.05


def test_an_open_loop_from_rest_begins_at_the_first_sample_with_a_note():
    stretch = Stretch.of(
        log_of(np.zeros(60), np.linspace(0.0, 3.0, 60)),
        Axis(at_rest=True, periodic=False),
        "open-loop",
        slice(0, 60),
    )
    course = stretch.run(PLANT, FILM, np.zeros(60))
    assert [item.code for item in course.diagnostics] == ["start_of_contact"]
    plain = run_open_loop(PLANT, FILM, np.repeat(np.linspace(0.0, 3.0, 60), 20), DT / 20)
    assert course.position == pytest.approx(plain.position[::20])


def test_a_closed_loop_returns_measured_position_and_commanded_effort():
    stretch = Stretch.of(log_of(cubic()), axis_of(), "closed-loop", slice(0, 40))
    course, trace = (
        stretch.run(PLANT, FILM, np.zeros(40)),
        closed_loop_of(log_of(cubic()), axis_of(), slice(0, 40)).run(PLANT, FILM),
    )
    assert course.position.tolist() == trace.measured.tolist()
    assert course.command.tolist() == trace.command.tolist()
    assert course.diagnostics == ()
    pushed = stretch.run(PLANT, FILM, np.full(40, 3.0))
    assert pushed.position[-1] < course.position[-1]


@pytest.mark.parametrize("lag", [None, 2e-3])
def test_derivatives_of_a_loop_come_with_the_effort_of_its_run_through_a_perfect_encoder(lag):
    loop = closed_loop_of(log_of(cubic(), 3.0 + np.arange(100.0)), axis_of(), slice(20, 40))
    plain = loop.run(PLANT, FILM, encoder(resolution=0.0), lag=lag)
    tangents = (
        np.zeros((pack(PLANT.parameters).size, 1)),
        np.ones((pack(FILM.parameters).size, 1)),
    )
    effort, slopes = loop.with_derivatives(
        Sensitive(PLANT, tangents[0]), Sensitive(FILM, tangents[1]), lag, np.zeros(1)
    )
    assert effort.tolist() == plain.command.tolist()
    beside = [
        loop.run(PLANT, friction.viscous(F_v=5.0 + step), encoder(resolution=0.0), lag=lag).command
        for step in (1e-4, -1e-4)
    ]
    assert slopes[:, 0] == pytest.approx((beside[0] - beside[1]) / 2e-4, rel=1e-3, abs=1e-6)
