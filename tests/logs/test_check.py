"""A log is looked at before anything is fitted: each lie is told by its code, and a right log by none."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from bristle.core.axis import Axis, Column
from bristle.logs import Log, checked
from bristle.logs.check import checked_together
from bristle.report.messages import message

DT, COUNT, MASS, LEVEL, DRAG = 1e-3, 16_000, 12.0, 9.0, 14.0
SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))]


class Run:
    """A motion that is known exactly, and the effort that it takes: speeds of several sizes, or what is asked for."""

    def __init__(self, seed, speeds=(0.02, 0.1, 0.3, 0.9), *, back=True, mass=MASS, level=LEVEL):
        self.rng = np.random.default_rng(seed)
        self.t = DT * np.arange(COUNT)
        self.v = self._strokes(speeds, back)
        self.a = np.gradient(self.v, DT)
        self.x = np.cumsum(self.v) * DT
        self.level = level * np.ones(COUNT)
        self.mass = mass

    def _strokes(self, speeds, back):
        v, k = np.zeros(0), 0
        while v.size < COUNT:
            speed = speeds[k // (2 if back else 1) % len(speeds)] * self.rng.uniform(0.99, 1.01)
            ramp = speed * (0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 150)))
            stroke = np.concatenate([ramp, np.full(350, speed), ramp[::-1], np.zeros(60)])
            v, k = np.concatenate([v, -stroke if back and k % 2 else stroke]), k + 1
        return v[:COUNT]

    def effort(self):
        friction = self.level * np.tanh(self.v / 1e-4) + DRAG * self.v
        return self.mass * self.a + friction + 5.0 + self.rng.normal(0.0, 0.1, COUNT)

    def log(self, **changed):
        channels = {"time": self.t, "position": np.round(self.x, 7), "effort": self.effort()}
        return Log(**(channels | changed), sample_time=DT)


def codes(log, axis=None):
    return [result.code for result in checked(log, axis)]


@pytest.mark.parametrize(
    "seed", [*SEEDS, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (3, 4, 5))]
)
@pytest.mark.parametrize("mass", [None, MASS])
def test_a_correct_log_has_no_contradiction(seed, mass):
    run = Run(seed)
    assert [
        code for code in codes(run.log(velocity=run.v), Axis(mass=mass)) if code != "motion_repeats"
    ] == []


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("gravity", [0.0, 300.0])
def test_the_work_over_closed_motion_shows_a_wrong_sign(seed, gravity):
    effort = Run(seed).effort() + gravity
    assert "sign_reversed" in codes(Run(seed).log(effort=-effort))
    assert "sign_reversed" not in codes(Run(seed).log(effort=effort))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("reach", [1e-6, 3e-6])
def test_presliding_of_the_right_sign_is_no_reversed_effort(seed, reach):
    rng, t = np.random.default_rng(seed), DT * np.arange(8000)
    x = reach * np.sin(2.0 * np.pi * t)
    # A stiff spring with a narrow loop, two samples late: taken for an inertia it is a negative one.
    late = reach * np.sin(2.0 * np.pi * (t - 2.0 * DT))
    loop = 0.1 * reach * np.cos(2.0 * np.pi * (t - 2.0 * DT))
    effort = 2e6 * (late + loop) + rng.normal(0.0, 2e4 * reach, t.size)
    log = Log(time=t, position=np.round(x, 9), effort=effort, sample_time=DT)
    assert set(codes(log)) & {"sign_reversed", "never_slides"} == {"never_slides"}
    assert "sign_reversed" in codes(replace(log, effort=-effort))
    assert "never_slides" not in {
        finding.code for finding in checked_together([(log, None), (Run(seed).log(), None)])
    }


def pulled(force, seed):
    """Return a log of two sines of a few micrometres that takes a force over the position, and its noise."""
    rng, t = np.random.default_rng(seed), DT * np.arange(12_000)
    x = 1.8e-6 * np.sin(2.0 * np.pi * 0.7 * t) + 0.8e-6 * np.sin(2.0 * np.pi * 2.3 * t)
    return Log(
        time=t,
        position=np.round(x, 9),
        effort=force(x) + rng.normal(0.0, 0.01, t.size),
        sample_time=DT,
    )


def elements(x, reach=6e-6, level=8.0, count=14):
    """Return the force of springs that slip one after the other, the last one at `reach` [m]."""
    limits = np.linspace(0.07 * reach, reach, count)
    bent, force = np.zeros(count), np.empty(x.size)
    for k, step in enumerate(np.diff(x, prepend=0.0)):
        bent = np.clip(bent + step, -limits, limits)
        force[k] = level * np.mean(bent / limits)
    return force


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("reach", [5e-6, 6e-6])
def test_the_build_up_distance_identifies_wide_loops_before_sliding(seed, reach):
    (result,) = [
        item
        for item in checked(pulled(lambda x: elements(x, reach), seed))
        if item.code == "never_slides"
    ]
    assert result.numbers["percent"] > 30.0  # as wide as that of an axis that slides


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("level", [0.6, 0.8, 1.0])
def test_an_axis_that_slides_against_a_spring_does_not_count_as_stuck(seed, level):
    def falling(x):
        speed = np.gradient(x)
        return level * np.tanh(speed / 1e-10) * (1.0 + np.exp(-((speed / 3e-9) ** 2)))

    for friction in (
        lambda x: level * np.sign(np.gradient(x)),
        lambda x: elements(x, 6e-8, level),
        falling,
    ):
        log = pulled(lambda x, friction=friction: 1.6e6 * x + friction(x), seed)
        assert "never_slides" not in codes(log)


@pytest.mark.parametrize("seed", SEEDS)
def test_an_effort_that_is_cut_off_or_bends_over(seed):
    effort = Run(seed).effort()
    top = np.max(np.abs(effort))
    assert "clipped" in codes(Run(seed).log(effort=np.clip(effort, -0.6 * top, 0.6 * top)))
    bent = 0.7 * top * np.tanh(effort / (0.7 * top))
    (result,) = [item for item in checked(Run(seed).log(effort=bent)) if item.code == "saturates"]
    assert 20.0 < result.numbers["percent"] < 100.0


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("noise", [0.002, 0.01, 0.02])
def test_an_effort_that_is_cut_off_below_its_noise(seed, noise):
    run = Run(seed, (0.1, 0.5, 0.9))
    pure = run.mass * run.a + run.level * np.tanh(run.v / 1e-4) + DRAG * run.v
    top = 0.6 * np.max(np.abs(pure))
    scatter = noise * top * np.random.default_rng(seed).standard_normal(COUNT)
    (result,) = [
        item
        for item in checked(run.log(effort=np.clip(pure, -top, top) + scatter))
        if item.code == "clipped"
    ]
    assert abs(result.numbers["level"]) == pytest.approx(top, rel=0.02)
    # Where the effort is at its limit, and a few samples before and behind.
    cut = np.count_nonzero(np.abs(pure) > top)
    assert 0.9 * cut < result.numbers["all"] < 1.5 * cut
    assert "clipped" not in codes(run.log(effort=pure + scatter))


@pytest.mark.parametrize("seed", SEEDS)
def test_an_effort_that_stays_at_its_extreme_is_not_cut_off_where_the_motion_takes_no_more(seed):
    # A drive at its limit: the axis accelerates as that effort lets it.
    limit, t = 60.0, DT * np.arange(COUNT)
    v, u = np.zeros(COUNT), np.zeros(COUNT)
    wanted = 0.9 * np.sign(np.sin(2.0 * np.pi * 0.4 * t))
    for k in range(COUNT - 1):
        u[k] = np.clip(600.0 * (wanted[k] - v[k]), -limit, limit)
        v[k + 1] = v[k] + DT * (u[k] - LEVEL * np.tanh(v[k] / 1e-3) - DRAG * v[k]) / MASS
    noise = 0.3 * np.random.default_rng(seed).standard_normal(COUNT)
    assert np.mean(np.abs(u) == limit) > 0.05
    assert "clipped" not in codes(
        Log(time=t, position=np.cumsum(v) * DT, effort=u + noise, sample_time=DT)
    )
    # Slow moves without a load: friction at the highest speed is the largest effort.
    slow = Run(seed, (0.02, 0.1, 0.3), mass=0.3)
    assert "clipped" not in codes(slow.log(effort=slow.effort() - 5.0))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("count", [3, 200])
def test_rows_that_are_lost_and_the_rest_stamped_again(seed, count):
    run = Run(seed)
    start = int(np.argmax(run.v > 0.85)) + 100
    kept = np.r_[0:start, start + count : COUNT]
    log = Log(
        time=run.t[: kept.size],
        position=np.round(run.x, 7)[kept],
        effort=run.effort()[kept],
        sample_time=DT,
    )
    (result,) = [item for item in checked(log) if item.code == "rows_lost"]
    assert result.numbers["time"] == pytest.approx((start - 1) * DT)
    assert result.numbers["step"] == pytest.approx(
        run.x[start + count] - run.x[start - 1], rel=1e-3
    )


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_stamps_that_no_axis_is_sampled_at(factor):
    run = Run(0)
    log = Log(
        time=factor * run.t,
        position=np.round(run.x, 7),
        effort=run.effort(),
        sample_time=factor * DT,
    )
    (result,) = [item for item in checked(log) if item.code == "unit_suspect"]
    assert "speed" not in result.numbers
    assert result.numbers["sample_time"] == pytest.approx(factor * DT)


@pytest.mark.parametrize(
    ("kind", "factor", "told"),
    [
        ("translational", 1e3, True),
        ("translational", 10.0, False),
        ("rotational", 1e3, False),
        ("rotational", 1e4, True),
    ],
)
def test_speeds_that_no_axis_has(kind, factor, told):
    run = Run(0)
    log = Log(time=run.t, position=factor * run.x, effort=run.effort(), sample_time=DT, kind=kind)
    assert ("unit_suspect" in codes(log, Axis(kind=kind))) is told


@pytest.mark.parametrize(
    ("channel", "name", "unit", "code"),
    [
        ("time", "t_s", "ms", "unit_suspect"),
        ("time", "t_s", "s", None),
        ("time", "Time [ms]", "s", "unit_suspect"),
        ("position", "x_mm", "m", "unit_suspect"),
        ("position", "x_mm", "mm", None),
        ("position", "x", "m", None),
    ],
)
def test_a_unit_in_a_name_contradicts_the_axis_file(channel, name, unit, code):
    axis = Axis(columns={channel: Column(name, unit, "s" if channel == "time" else "m")})
    result = [item for item in checked(Run(0).log(), axis) if item.code.endswith("_suspect")]
    assert [item.code for item in result] == ([code] if code else [])
    assert all(name in message(item) for item in result)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("lag", [5e-3, 40e-3])
def test_a_slow_filter_of_the_effort_is_no_other_mass(seed, lag):
    keep, effort = np.exp(-DT / lag), Run(seed).effort()
    slow = lfilter([1.0 - keep], [1.0, -keep], effort, zi=[keep * effort[0]])[0]
    log = Run(seed).log(effort=slow)
    assert "mass_contradicts" not in codes(log, Axis(mass=MASS))
    (result,) = [
        item for item in checked(log, Axis(mass=2.0 * MASS)) if item.code == "mass_contradicts"
    ]
    assert result.numbers["found"] == pytest.approx(MASS, rel=0.03)


def test_a_motion_of_a_few_steps_of_the_encoder():
    run = Run(0)
    assert "below_resolution" in codes(run.log(position=np.round(run.x / 0.1) * 0.1))
