"""Explanation of the effort of a log: terms, numbers and refusals, on axes simulated by the engine along prescribed motions."""

import json
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, Motion as Moves, log_of, sines, sliding_effort
from tests.identification.test_delay import late

import bristle as br
from bristle.core import InputError
from bristle.core.errors import TooShortError
from bristle.engine import force_along
from bristle.identification import explain
from bristle.identification.dictionary import (
    Element,
    filtered,
    grid_of,
    low_pass_taps,
    memory_force,
    memory_of,
    outputs,
    ramps,
)
from bristle.identification.explanation import DOUBTS, Evidence, Interval
from bristle.identification.friction_law import AtSpeed, least_biased
from bristle.identification.gram import non_negative
from bristle.identification.term_search import Search, Selection, chosen_terms, explains
from bristle.identification.work_rate import motion_of
from bristle.logs.log import Log

DT = 1e-3
FINE = 5  # steps of the engine in a sample
TRUTH = {"M": 34.6, "F_C": 22.0, "F_S": 26.0, "F_v": 40.0}
STROKE = 0.4


def moves(seconds, seed=1, stroke=STROKE):
    """Position of random moves and rests with minimum jerk."""
    random = np.random.default_rng(seed)
    dt = DT / FINE
    place, parts = 0.5 * stroke, [np.full(round(0.3 / dt), 0.5 * stroke)]
    while sum(part.size for part in parts) * dt < seconds:
        goal = place + random.choice([0.1, 0.3, 1.0]) * (random.uniform(0.0, stroke) - place)
        longest = 1.25 * stroke * 10.0 ** random.uniform(-1.0, 0.0)
        duration = max(1.9 * abs(goal - place) / longest, 0.15)
        s = np.arange(round(duration / dt)) * dt / duration
        parts.append(place + (goal - place) * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5))
        parts.append(np.full(round(random.uniform(0.02, 0.2) / dt), goal))
        place = goal
    return np.concatenate(parts)[: round(seconds / dt)]


def simulated(
    seconds=20.0,
    *,
    seed=1,
    delay=0.0,
    further=None,
    level=None,
    kind="translational",
    stroke=STROKE,
    v_S=5e-3,
):
    """Columns of a log: LuGre friction of the engine, times a level of place and time, and a further force of place."""
    x = moves(seconds, seed, stroke)
    dt = DT / FINE
    v, t = np.gradient(x, dt), dt * np.arange(x.size)
    law = br.friction.lugre(
        kind=kind, F_C=22.0, F_S=26.0, v_S=v_S, sigma_0=4e6, sigma_1=200.0, sigma_2=0.0
    )
    friction = force_along(law, v, dt, x)
    if level is not None:
        friction = friction * level(x, t)
    effort = TRUTH["M"] * np.gradient(v, dt) + friction + TRUTH["F_v"] * v
    if further is not None:
        effort = effort + further(x, v, dt)
    noise = np.random.default_rng(seed).normal(0.0, 0.2, x[::FINE].size)
    recorded = np.interp(t[::FINE] - delay, t, effort) + noise
    return {"time": t[::FINE], "position": np.round(x[::FINE] / 1e-7) * 1e-7, "effort": recorded}


def spring(x, v, dt):
    return 31.0 * (x - 0.5 * STROKE)


def cable(x, v, dt):
    element = br.friction.maxwell_slip(k_i=[5.0 / 6e-3], nu_i=[1.0], F_C=5.0)
    return force_along(element, v, dt, x) + spring(x, v, dt)


def named(explanation):
    return {part.name.split()[0] for part in explanation.terms}


def holds(interval, value):
    return abs(interval.value - value) <= interval.half_width


@pytest.fixture(scope="session")
def sprung():
    return simulated(further=spring)


@pytest.fixture(scope="session")
def explained(sprung):
    return explain(sprung)


def test_a_spring_is_named_and_no_other_term(explained):
    assert named(explained) == {"spring"}
    assert explained.F_C.value == pytest.approx(22.0, abs=0.3)
    assert explained.M.value == pytest.approx(34.6, rel=3e-3)
    for name in ("M", "F_C", "F_v"):
        assert holds(getattr(explained, name), TRUTH[name]), name
    slope = np.polyfit(explained.curves["position"].at, explained.curves["position"].values, 1)[0]
    assert slope == pytest.approx(31.0, rel=0.03)


def test_shares_sum_up_to_one_and_lead_the_verdict(explained):
    assert sum(part.share for part in explained.parts) == pytest.approx(1.0)
    assert explained.verdict.startswith(f"{100 * explained.parts[0].share:.0f} % Coulomb, ")
    assert " % spring" in explained.verdict


def test_plain_data_is_json(explained):
    data = json.loads(json.dumps(explained.as_data()))
    assert data["numbers"]["M"]["unit"] == "kg"
    assert len(data["curves"]["speed"]["at"]) == len(data["curves"]["speed"]["values"])


def test_curves_have_the_levels_of_the_law(explained):
    speed, travel = explained.curves["speed"], explained.curves["travel"]
    assert np.interp(0.1, speed.at, speed.values) == pytest.approx(22.0 + 4.0, abs=0.5)
    assert travel.values[-1] == pytest.approx(26.0, abs=1.5)
    assert travel.values[0] == pytest.approx(-travel.values[-1], rel=0.1)


def test_the_residual_is_the_noise(explained):
    assert explained.unexplained == pytest.approx(0.2 * 0.45, rel=0.5)
    assert explained.floor >= 0.95 * explained.unexplained


def test_a_clean_axis_has_no_term():
    explained = explain(simulated(seed=2))
    assert not explained.terms
    assert explained.F_C.value == pytest.approx(22.0, rel=3e-3)


@pytest.mark.slow
def test_a_cable_beside_a_spring_has_its_own_hysteresis():
    explained = explain(simulated(seed=3, further=cable))
    assert named(explained) == {"spring", "cable"}
    assert holds(explained.sliding, 27.0)
    assert explained.sliding.half_width < 0.02 * 27.0
    assert holds(explained.F_C, 22.0)
    assert "F_C_and_cable" in explained.numbers


def test_a_force_too_small_to_be_named_widens_the_interval():
    def weak(x, v, dt):
        element = br.friction.maxwell_slip(k_i=[0.3 / 6e-3], nu_i=[1.0], F_C=0.3)
        return force_along(element, v, dt, x)

    explained = explain(simulated(seed=3, further=weak))
    assert not explained.terms
    assert holds(explained.F_C, 22.0)
    assert explained.F_C.half_width < 0.03 * 22.0


@pytest.mark.slow
def test_friction_that_falls_up_to_a_fair_speed_leaves_coulomb_friction_known():
    explained = explain(simulated(seed=4, v_S=0.05))
    assert not explained.terms
    assert explained.F_C.value == pytest.approx(22.0, rel=0.01)
    assert holds(explained.F_C, 22.0)


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("delay", [-3.5e-3, 0.7e-3, 2.3e-3])
def test_a_delay_is_found(sprung, delay):
    late = simulated(further=spring, delay=delay)
    explained = explain(late)
    assert explained.delay.value == pytest.approx(delay, abs=1.5e-4)
    assert holds(explained.delay, delay)
    assert explained.delay.half_width < 1e-4
    assert explained.M.value == pytest.approx(34.6, rel=3e-3)


def looped(seconds=20.0, seed=1):
    """Columns of a slow speed loop whose effort reacts to the noise of its encoder at once, and acts 4 samples later."""
    random = np.random.default_rng(seed)
    time = DT * np.arange(round(seconds / DT))
    quick = moves(seconds / 3.0, seed)
    wanted = np.interp(time / 3.0, DT / FINE * np.arange(quick.size), quick)
    x, v, stop, seen, rate, integral = wanted[0], 0.0, 0.0, wanted[0], 0.0, 0.0
    queue = [0.0] * 4
    rows = []
    for goal, speed in zip(wanted, np.gradient(wanted, DT), strict=True):
        before, seen = seen, x + random.normal(0.0, 1e-6)
        rate += 0.6 * ((seen - before) / DT - rate)
        error = speed + 15.0 * (goal - seen) - rate
        integral += 15.0 * DT * error
        queue.append(300.0 * (error + integral))
        rows.append((seen, queue[-1]))
        acting = queue.pop(0)
        for _ in range(20):
            stop = min(max(stop + v * DT / 20 / 5e-6, -1.0), 1.0)
            v += DT / 20 * (acting - 8.0 * stop - 40.0 * v) / 8.0
            x += DT / 20 * v
    seen, effort = np.array(rows).T
    return {"time": time, "position": seen, "effort": effort}


@pytest.mark.slow
def test_noise_in_a_loop_does_not_hide_the_delay():
    explained = explain(looped())
    assert holds(explained.delay, -4.5e-3)  # with half a sample, because the loop holds its effort
    assert explained.delay.half_width < 1e-3
    assert explained.M.value == pytest.approx(8.0, rel=0.01)


@pytest.mark.parametrize(
    ("delays", "best"),
    [
        ([(0.1, 0.1), (0.3, 0.2), (3.5, 1.5)], (3.5, 1.5)),  # wide bands are biased
        ([(0.1, 0.1), (0.2, 0.2), (0.9, 1.5)], (0.1, 0.1)),  # nothing contradicts the widest band
        ([(0.1, 0.1), (0.35, 0.2)], (0.1, 0.15)),  # the distance widens the interval
    ],
)
def test_the_band_with_the_least_error_has_the_delay(delays, best):
    bands = [AtSpeed(Interval(1.0, 0.1), Interval(*delay), False, {}) for delay in delays]
    assert least_biased(bands).delay == pytest.approx(best)
    at_edge = AtSpeed(Interval(1.0, 0.1), Interval(9.0, 0.01), True, {})
    assert least_biased([at_edge, *bands, at_edge]).delay == pytest.approx(best)


@pytest.mark.slow
def test_the_forces_are_those_at_the_delay_of_the_best_band(sprung, explained, monkeypatch):
    stage = sys.modules["bristle.identification.explain"]
    monkeypatch.setattr(
        stage, "least_biased", lambda bands: bands[0]._replace(delay=Interval(4e-3, 1e-4))
    )
    late = explain(sprung)
    assert late.delay.value == 4e-3
    assert late.unexplained > 5.0 * explained.unexplained


def test_a_log_too_short_for_narrow_bands_is_explained_in_the_widest(sprung):
    short = explain({name: values[:2000] for name, values in sprung.items()})
    assert abs(short.delay.value) < 2e-3


def test_a_term_that_is_kept_at_last_is_not_among_the_rejected(sprung, monkeypatch):
    search = Search(motion_of([(Log.from_columns(sprung), None)]))
    search.fit()
    shapes = iter(["", "curve"])
    weak = Evidence(0.0, 0.0)

    def eliminated(self, fixed, terms):
        if not self.rejected:
            self.rejected.update({group.name: weak for group in terms})
            return [], {}
        return list(terms), {group.name: Evidence(1.0, 9.0) for group in terms}

    monkeypatch.setattr(Selection, "shape_beside", lambda self, chosen: (next(shapes), {}))
    monkeypatch.setattr(Selection, "eliminated", eliminated)
    choice = chosen_terms(search)
    assert "level" in choice.evidence
    assert not set(choice.evidence) & set(choice.rejected)
    assert "warmup" in choice.rejected


@pytest.mark.slow
def test_load_is_the_transmitted_force():
    x = moves(20.0, 10, 4.0)
    dt = DT / FINE
    v = np.gradient(x, dt)
    transmitted = 20.0 * np.gradient(v, dt) + 15.0 * np.sin(x - 0.3)
    element = br.friction.maxwell_slip(kind="rotational", k_i=[22.0 / 1e-3], nu_i=[1.0], F_C=22.0)
    level = 1.0 + 0.3 * np.abs(transmitted) / 22.0
    friction = force_along(element, v, dt, x) * level
    columns = (dt * np.arange(x.size), x, transmitted + friction + 4.0 * v)
    names = ("time", "position", "effort")
    log = {name: values[::FINE] for name, values in zip(names, columns, strict=True)}
    explained = explain(log, br.Axis(kind="rotational"))
    assert named(explained) == {"gravity", "load"}
    assert explained.doubts == ("loaded",)
    assert explained.F_C is None
    assert explained.M.value == pytest.approx(20.0, rel=3e-3)


@pytest.mark.slow
def test_a_level_beside_gravity_is_no_load():
    log = simulated(
        seed=5,
        kind="rotational",
        stroke=1.5,
        further=lambda x, v, dt: 15.0 * np.sin(x - 0.3),
        level=lambda x, t: 1.0 + 0.2 * (2.0 * x / 1.5 - 1.0),
    )
    assert named(explain(log, br.Axis(kind="rotational"))) == {"gravity", "level"}


@pytest.mark.slow
def test_a_ripple_has_its_wavelength():
    further = lambda x, v, dt: 2.0 * np.sin(2.0 * np.pi * x / 2.5e-3)  # noqa: E731
    explained = explain(simulated(seed=6, further=further))
    (part,) = explained.terms
    assert 1.0 / part.frequency == pytest.approx(2.5e-3, rel=1e-3)
    assert np.hypot(*part.wave) == pytest.approx(2.0, rel=0.05)
    assert "ripple 2.5 mm" in explained.verdict


@pytest.mark.slow
def test_warm_up_is_named_and_its_course_returned():
    explained = explain(simulated(seed=7, level=lambda x, t: 1.0 + 0.25 * np.exp(-t / 5.0)))
    assert named(explained) == {"warmup"}
    level = explained.curves["time"].values
    assert level[0] / level[-1] == pytest.approx(1.25, abs=0.09)  # viscous friction did not change


@pytest.mark.slow
def test_parts_of_a_log_are_explained_like_the_whole(sprung, explained):
    whole = Log.from_columns(sprung)
    half = len(whole) // 2
    part = {name: values[half:] for name, values in sprung.items()}
    first = {name: values[:half] for name, values in sprung.items()}
    both = explain([first, part])
    assert named(both) == named(explained)
    assert holds(both.F_C, 22.0)
    gap = {name: np.delete(values, slice(half, half + 500)) for name, values in sprung.items()}
    log = Log.from_columns(gap)
    assert len(log.segments) == 2
    assert named(explain(log)) == named(explained)


@pytest.mark.slow
def test_a_stroke_of_a_few_slip_lengths_leaves_numbers_unknown():
    x = moves(20.0, 8)
    dt = DT / FINE
    element = br.friction.maxwell_slip(k_i=[22.0 / 0.03], nu_i=[1.0], F_C=22.0)
    effort = force_along(element, np.gradient(x, dt), dt, x)
    log = {"time": DT * np.arange(x[::FINE].size), "position": x[::FINE], "effort": effort[::FINE]}
    explained = explain(log)
    assert "not_saturated" in explained.doubts
    assert explained.M is None
    assert explained.F_C is None
    assert DOUBTS["not_saturated"] in explained.notes


def test_one_direction_does_not_tell_friction_from_a_constant_force():
    t = DT * np.arange(12000)
    v = 0.1 + 0.05 * np.sin(3.0 * t) + 0.02 * np.sin(11.0 * t)
    effort = 5.0 * np.gradient(v, t) + 22.0 + 40.0 * v
    explained = explain({"time": t, "position": np.cumsum(v) * DT, "effort": effort})
    assert explained.doubts == ("one_direction",)
    assert explained.F_C is None
    assert explained.M.value == pytest.approx(5.0, rel=0.01)


def test_a_log_that_cannot_be_explained_is_refused(sprung):
    with pytest.raises(InputError, match="has no effort"):
        explain({name: sprung[name] for name in ("time", "position")})
    with pytest.raises(TooShortError, match="too short to explain"):
        explain({name: values[:700] for name, values in sprung.items()})
    with pytest.raises(InputError, match="is constant"):
        explain(sprung | {"effort": np.full(sprung["time"].size, 3.0)})
    still = sprung | {"position": 1e-7 * (np.arange(sprung["time"].size) % 2)}
    with pytest.raises(InputError, match="hardly changes"):
        explain(still)


@pytest.mark.slow
def test_an_axis_that_holds_its_effort_has_no_delay():
    """A sampled loop holds its effort: half a sample of delay, which the axis file states by `held`."""
    log = simulated(seed=9)
    effort = log["effort"]
    held = log | {"effort": np.append(0.5 * (effort[1:] + effort[:-1]), effort[-1])}
    loop = explain(held, br.Axis(held=True))
    assert abs(loop.delay.value) < 1e-4


@pytest.fixture(scope="module")
def motion(sprung):
    return motion_of([(Log.from_columns(sprung), None)])


def test_the_dictionary_gains_no_energy_over_closed_cycles(motion):
    """The force over the second of two equal cycles takes work, whatever the non-negative weights."""
    random = np.random.default_rng(0)
    grid = grid_of(motion)
    s = np.linspace(0.0, 2.0 * np.pi, 4001)[:-1]
    for _ in range(6):
        waves = random.normal(size=(4, 2)) * np.array([[1.0], [0.5], [0.3], [0.2]])
        path = sum(
            a * np.sin((k + 1) * s) + b * np.cos((k + 1) * s) for k, (a, b) in enumerate(waves)
        )
        x = grid.low + grid.stroke * np.tile((path - path.min()) / np.ptp(path), 2)
        part = (slice(0, x.size),)
        v = np.gradient(x, DT)
        cycle = motion.__class__(
            motion.time[: x.size],
            x,
            v,
            0 * x,
            0 * x,
            part,
            DT,
            100.0,
            0.0,
            False,
            motion.taps,
            4,
            50,
            (0,),
        )
        for members in memory_of(grid).values():
            weights = random.exponential(size=len(members))
            force = memory_force(cycle, grid, members, weights)
            mean = 0.5 * (force[4000:] + force[3999:-1])
            work = mean @ np.diff(x)[3999:]
            assert work > -1e-3 * np.abs(mean) @ np.abs(np.diff(x)[3999:])
        rate = random.exponential(size=14) @ ramps(v, grid.V)
        assert rate[4000:] @ np.diff(x)[3999:] > 0.0


def test_elements_reverse_as_stated(motion):
    """A slow reversal along the compiled loop has the closed form of a stop and of a Dahl element."""
    grid = grid_of(motion)
    x = np.concatenate([np.linspace(0.0, 1e-3, 2001), np.linspace(1e-3, 8e-4, 4001)[1:]])
    part = (slice(0, x.size),)
    slow = motion.__class__(
        motion.time[: x.size],
        x,
        0 * x,
        0 * x,
        0 * x,
        part,
        DT,
        100.0,
        0.0,
        False,
        motion.taps,
        4,
        50,
        (0,),
    )
    members = [Element(False, 3e-5, np.inf, 0.0), Element(True, 3e-5, np.inf, 0.0)]
    pairs = zip(members, outputs(slow, grid_of(slow), members), strict=True)
    for element, out in pairs:
        travel = x[2000] - x[2000:]
        assert -out[2000:] == pytest.approx(element.after_reversal(travel), abs=1e-9)
    assert grid.narrow[0] >= 3.0 * motion.noise


def test_non_negative_least_squares_agree_with_scipy():
    from scipy.optimize import nnls

    random = np.random.default_rng(4)
    for _ in range(10):
        A = random.normal(size=(60, 12))
        b = random.normal(size=60) + A[:, 0]
        x, support = non_negative(A.T @ A, A.T @ b, np.zeros(12, dtype=bool), np.zeros(12, bool))
        assert x == pytest.approx(nnls(A, b)[0], abs=1e-9)
        assert (x[~support] == 0.0).all()
    free = np.ones(12, dtype=bool)
    x, _ = non_negative(A.T @ A, A.T @ b, free, ~free)
    assert x == pytest.approx(np.linalg.lstsq(A, b)[0], abs=1e-9)


@pytest.mark.slow
def test_ten_minutes_take_seconds(explained):
    log = simulated(600.0, further=spring)
    before = time.process_time()
    assert named(explain(log)) == {"spring"}
    assert time.process_time() - before < 8.0


@pytest.mark.parametrize("length", [150, 400])
def test_a_stretch_too_short_for_a_row_is_left_out(length):
    motion = sines(8.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.31, 0.83, 2.3))
    log = log_of(motion, sliding_effort(motion), step=1e-7)
    parts = (slice(0, length), slice(length + 20, len(log)))
    explained = explain(replace(log, segments=parts), br.Axis())
    assert explained.M.value == pytest.approx(12.0, rel=0.01)


def test_a_filter_never_reaches_beyond_its_signal():
    taps = low_pass_taps(100.0, 1e-3)
    signal = np.ones(4 * taps.size)
    assert filtered(signal, taps, taps.size, 5, 3) == pytest.approx(1.0)
    for first in (taps.size // 2 - 1, signal.size - taps.size // 2):
        with pytest.raises(IndexError, match="beyond its signal"):
            filtered(signal, taps, first, 1, 1)


def test_waves_that_meet_are_one():
    motion = sines(6.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.31, 0.83, 2.3))
    search = Search(motion_of([(log_of(motion, sliding_effort(motion), step=1e-7), None)]))
    apart = 1.0 / search.grid.stroke
    search.add_frequencies([5.0 * apart, 5.5 * apart, 7.0 * apart])
    assert search.frequencies == [5.0 * apart, 7.0 * apart]


@pytest.mark.parametrize(
    ("amplitude", "ripple", "frequencies"), [(2e-5, 0.0, []), (0.0, 0.3, [100])]
)
def test_an_error_of_the_encoder_is_no_ripple(amplitude, ripple, frequencies):
    motion = sines(12.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.3, 0.85, 2.3))
    wave = np.sin(2.0 * np.pi * motion.position / 0.01)
    effort = sliding_effort(motion, noise=0.1) + ripple * wave
    shifted = motion._replace(position=motion.position + amplitude * wave)
    explained = explain(log_of(shifted, effort, step=1e-8), STATED)
    assert [part.frequency for part in explained.terms] == pytest.approx(frequencies, rel=5e-3)


@pytest.mark.parametrize("count", [4, 6])
def test_levels_that_scatter_between_few_half_cycles_are_no_warm_up(count):
    t = 1e-3 * np.arange(400 * count)
    w = np.pi / 0.4
    motion = Moves(t, -0.02 * np.cos(w * t), 0.02 * w * np.sin(w * t), 0.02 * w**2 * np.cos(w * t))
    rng = np.random.default_rng(count)
    levels = np.repeat(8.0 * (1.0 + 0.05 * rng.standard_normal(count)), 400)
    effort = 12.0 * motion.acceleration + levels * np.where(motion.velocity < 0.0, -1.0, 1.0)
    log = log_of(motion, effort + 0.05 * rng.standard_normal(t.size))
    assert explain(log, STATED).terms == []


@pytest.mark.parametrize(("size", "told"), [(0.0, False), (1.0, True)])
def test_a_line_over_levels_is_told_from_their_scatter(size, told):
    columns = np.linspace(-1.0, 1.0, 12)[:, None]
    noise = 0.3 * np.random.default_rng(1).standard_normal(12)
    assert explains(columns, size * columns[:, 0] + noise) is told
    assert not explains(columns[:2], columns[:2, 0])


def test_unequal_filters_look_like_no_cable():
    explained = explain(late(command_lag=3e-3, bends=1e6))
    assert explained.filter is not None
    assert explained.terms == []


def test_dry_friction_is_friction_without_its_viscous_part():
    motion = sines(6.0)
    pairs = [(log_of(motion, sliding_effort(motion), step=1e-7), STATED)]
    search = Search(motion_of(pairs), 0.0)
    search.fit()
    moving = np.abs(search.motion.v) > 0.2 * search.grid.V
    speed = np.abs(search.motion.v[moving])
    assert abs(np.polyfit(speed, np.abs(search.dry[moving]), 1)[0]) < 0.1 * 30.0
