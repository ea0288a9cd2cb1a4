"""The bench in small numbers: legs of a walk, how a table is led, what a torque sensor reads, what is recorded."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bristle import friction, hysteresis
from bristle.apps.paper import bench, drift
from bristle.apps.paper.bench import (
    Bench,
    Record,
    Sensed,
    Walk,
    bench_of,
    follow,
    led,
    plant_of,
    read_torque,
    sensor_numbers,
    sensor_says,
    walk,
)
from bristle.core.errors import InputError
from bristle.engine import run_open_loop


def test_a_walk_has_a_force_in_the_middle_of_each_step_and_at_each_turn():
    done = walk(friction.coulomb(F_C=3.0), [2e-6, 1e-6], 1e-6, 0.5, step=1e-6)
    assert 1e6 * done.x == pytest.approx([0.0, 0.5, 1.5, 2.0, 1.5, 1.0])
    assert done.turns.tolist() == [3, 5]
    assert done.torque[1:] == pytest.approx([1.5, 1.5, 1.5, -1.5, -1.5])
    assert walk(friction.coulomb(F_C=3.0), [], 1e-6, 0.5).x.tolist() == [0.0]


def test_an_operator_is_followed_in_steps_of_nanometres():
    done = follow(hysteresis.stop(r=1e-6), [1e-8, -1e-8], 3.0)
    assert done.turns.tolist() == [2, 6]
    assert 1e9 * done.x == pytest.approx([0.0, 5.0, 10.0, 5.0, 0.0, -5.0, -10.0], abs=1e-9)
    assert done.torque == pytest.approx(3.0 * done.x)  # not yet slipped


def test_a_table_turns_exactly_at_its_turning_points():
    dt, x, v, ends = bench._motion([3e-6, -1e-6], 2e-6, 1e-3)
    assert x[ends + 1] == pytest.approx([3e-6, -1e-6], abs=1e-18)
    assert (x[0], v[0], v[-1]) == (0.0, 0.0, 0.0)
    assert np.max(np.abs(v)) == pytest.approx(2e-6, rel=1e-3)
    assert np.diff(x) == pytest.approx(0.5 * (v[1:] + v[:-1]) * dt, abs=2e-3 * 2e-6 * dt + 1e-14)
    assert dt == 5e-4  # a step of 5 nm at 2 um/s would be longer


def test_a_fast_table_is_sampled_in_steps_of_nanometres_and_a_slow_table_more_rarely(monkeypatch):
    fast, *_ = bench._motion([1e-4], 1e-3, 1.0)
    assert fast == pytest.approx(5e-9 / 1e-3)
    # A change of speed takes 2e-6/0.1 = 20 us: a quarter of it.
    hard, *_ = bench._motion([1e-6], 2e-6, 0.1)
    assert hard == pytest.approx(0.25 * 2e-6 / 0.1)
    assert bench.MOST >= 1_000_000
    monkeypatch.setattr(bench, "MOST", 40_000)
    slow, *_, ends = bench._motion([1e-5], 1e-9, 1.0)
    assert ends[-1] <= 40_000
    assert slow == pytest.approx(1e4 / 4e4, rel=1e-3)
    still, *_ = bench._motion([0.0], 1e-6, 1e-3)
    assert still == 5e-4


def test_a_filter_follows_a_step_by_its_time_constant():
    cutoff, dt = 100.0, 1e-4
    item = Bench(J=2e-4, J_m=0.0, cutoff=cutoff)
    effort = np.concatenate([np.zeros(5), np.ones(200)])
    sensed = read_torque(item, effort, np.zeros(effort.size + 1), effort, dt)
    assert sensed.shaft == pytest.approx(effort)
    after = np.arange(1, 201) * dt
    assert sensed.read[5:] == pytest.approx(1.0 - np.exp(-2.0 * math.pi * cutoff * after))
    assert sensed.read[:5].tolist() == [0.0] * 5


def test_the_shaft_carries_the_effort_minus_that_of_the_motor():
    item = Bench(J=5e-4, J_m=2e-4, cutoff=math.inf)
    omega = 3.0 * 1e-3 * np.arange(11)  # 3 rad/s^2
    sensed = read_torque(item, np.full(10, 0.1), omega, np.zeros(10), 1e-3)
    assert sensed.shaft == pytest.approx(0.1 - 2e-4 * 3.0)
    assert sensed.read == pytest.approx(sensed.shaft)


def test_a_sensor_is_described_in_words():
    apart = {"apart": 0.0123, "inertia": 1.5e-3, "filter": 2.5e-4}
    words = sensor_says(Bench(4e-4, 2.5e-4, 200.0), apart, "Here")
    assert words == (
        "Here the error of the torque sensor is 1.2 % of the largest friction: the inertia behind it, 1.5 kg·cm², adds up to "
        "1.5 mN·m, its filter of 200 Hz removes up to 0.25 mN·m."
    )
    assert "filter" not in sensor_says(
        Bench(4e-4, 2.5e-4, math.inf), apart | {"filter": 0.0}, "Here"
    )


class Told(dict):
    """An experiment as a mapping."""

    def __init__(self, **bench_numbers):
        super().__init__({("bench", name): value for name, value in bench_numbers.items()})
        self.numbers, self.source, self.arm, self.mass = (
            {"bench": bench_numbers},
            "x.toml",
            1e-3,
            "own",
        )


def lists(*arrays):
    return [array.tolist() for array in arrays]


PATH = Walk(np.arange(7.0), 10.0 * np.arange(7.0), np.array([2, 5]))
PLACES, TURNS = np.arange(10.0), np.array([2, 5, 8])
RECORD = Record(PLACES, 2.0 * PLACES, TURNS, Walk(PLACES, 3.0 * PLACES, TURNS))
LATER, MIDDLE = RECORD.since(1), RECORD.part(2, 8, 0)
FIRST = Sensed(np.array([2.0, -4.0]), np.array([2.5, -4.0]), np.array([2.0, -3.0]))
SECOND = Sensed(np.array([1.0, 5.0]), np.array([1.0, 4.25]), np.array([1.5, 4.0]))


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        # A leg reaches from turn to turn, and a part of a record keeps its turns.
        (PATH.at_turns.tolist(), [20.0, 50.0]),
        (lists(*PATH.leg(0)), [[0.0, 1.0, 2.0], [0.0, 10.0, 20.0]]),
        (PATH.leg(1)[0].tolist(), [2.0, 3.0, 4.0, 5.0]),
        (LATER.x.tolist(), [5.0, 6.0, 7.0, 8.0, 9.0]),
        ((LATER.torque[0], LATER.actual.torque[0]), (10.0, 15.0)),
        (lists(LATER.turns, LATER.actual.turns), [[0, 3], [0, 3]]),
        ((MIDDLE.x[-1], MIDDLE.turns.tolist()), (7.0, [0, 3])),
        # Read beside friction by 1 at most, of 5; the shaft beside it by 0.75; what is read beside the shaft by 1.
        (sensor_numbers([FIRST, SECOND]), {"apart": 0.2, "inertia": 0.75, "filter": 1.0}),
        # The motor is a part of all inertia, which counts at the table by the square of its arm.
        (bench_of(Told(J=4e-4, J_m=4e-4)), Bench(4e-4, 4e-4, math.inf)),
        (bench_of(Told(J=4e-4, J_m=0.0, torque_filter=50.0)).cutoff, 50.0),
        (bench.plant_of(Told(J=4e-4, J_m=0.0)).values["M"], pytest.approx(400.0)),
    ],
)
def test_numbers_of_a_bench_are_those_by_hand(found, expected):
    assert found == expected


def test_a_motor_heavier_than_all_inertia_is_refused():
    with pytest.raises(InputError, match=r"x\.toml: bench\.J_m.*0 to bench\.J = 0\.0004 kg\*m\^2"):
        bench_of(Told(J=4e-4, J_m=4.1e-4))


def measuring(resolution, noise):
    """An experiment that measures a contact without a bench."""
    reported = Told()
    reported.numbers = {}
    reported |= {
        ("measurement", "resolution"): resolution,
        ("measurement", "noise"): noise,
        ("measurement", "speed"): 1e-6,
    }
    reported[("measurement", "amplitudes")] = np.array([1e-6, 4e-6])
    return reported


def test_an_experiment_without_a_bench_has_its_own_mass():
    assert bench.plant_of(measuring(0.0, 0.0)) == "own"


def test_a_position_is_read_in_counts_and_a_torque_with_noise():
    model = friction.coulomb(F_C=3.0)
    exact = bench.measured(measuring(0.0, 0.0), model, [2e-6, -2e-6], np.random.default_rng(1))
    assert exact.x.tolist() == exact.actual.x.tolist()
    assert exact.torque.tolist() == exact.actual.torque.tolist()
    assert np.max(np.diff(exact.x)) == pytest.approx(5e-8)
    read = bench.measured(measuring(3e-7, 1e-4), model, [2e-6, -2e-6], np.random.default_rng(1))
    assert np.max(np.abs(read.x - read.actual.x)) <= 1.5e-7 + 1e-15
    assert read.x / 3e-7 == pytest.approx(np.round(read.x / 3e-7))
    assert np.std(read.torque - read.actual.torque) == pytest.approx(1e-4, rel=0.2)


def test_a_loop_is_measured_after_a_sweep_of_falling_amplitude():
    rounds = bench.measured_loop(
        measuring(0.0, 0.0), friction.coulomb(F_C=3.0), 1e-6, 3, np.random.default_rng(1)
    )
    assert len(rounds) == 3
    for record in rounds:
        assert record.x[[0, -1]] == pytest.approx([-1e-6, -1e-6])
        assert record.x[record.turns] == pytest.approx([1e-6, -1e-6])
        assert np.max(record.x) == pytest.approx(1e-6)
    led = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            bench,
            "measured",
            lambda setting, model, turns, generator: led.extend(turns) or rounds[0],
        )
        bench.measured_loop(measuring(0.0, 0.0), None, 1e-6, 2, None)
    assert led[:2] == [4e-6, -4e-6]
    assert 1e6 * np.array(led[10:]) == pytest.approx([1.0, -1.0] * 3)
    assert np.diff(np.abs(led[:12:2])) == pytest.approx(np.full(5, -0.6e-6))


# --- the bench of the paper -------------------------------------------------------------------------------------------


RIG = "virtual rig"


def on_bench(setting, **values):
    """The experiment with other numbers of its bench; None for one that is left out."""
    numbers = {
        key: value
        for key, value in (setting.numbers["bench"] | values).items()
        if value is not None
    }
    return replace(setting, numbers=dict(setting.numbers) | {"bench": numbers})


def read(setting, speed=2e-6):
    return led(setting, setting.contact(RIG), setting["path", "turns"], speed)


def test_a_slow_walk_is_read_without_error(setting):
    item = setting(9)
    slow, still = read(item), walk(item.contact(RIG), item["path", "turns"], 2e-6, item.arm)
    assert slow.friction.at_turns == pytest.approx(still.at_turns, rel=2e-3)
    assert slow.sensor.at_turns == pytest.approx(still.at_turns, abs=2e-4)
    assert slow.sensor.x[slow.sensor.turns] == pytest.approx(item["path", "turns"], abs=1e-9)


def test_the_reading_differs_only_by_the_inertia_behind_the_sensor(setting):
    item = on_bench(setting(9), torque_filter=None)
    before = on_bench(item, J_m=item["bench", "J"])
    assert read(before).sensor.torque == pytest.approx(read(before).friction.torque, abs=1e-12)
    apart = sensor_numbers([read(item).sensed])
    assert apart["filter"] < 1e-15
    half = on_bench(item, J_m=0.5 * (item["bench", "J"] + item["bench", "J_m"]))
    assert sensor_numbers([read(half).sensed])["inertia"] == pytest.approx(
        0.5 * apart["inertia"], rel=1e-6
    )


def test_the_torque_that_leads_the_table_moves_it_along_the_path_when_it_drives_it(setting):
    item = on_bench(setting(8), torque_filter=None, J_m=0.0)
    present = read(item)
    # With nothing before the sensor the shaft carries all that the motor gives.
    dt = 5e-4
    trace = run_open_loop(
        plant_of(item), item.contact(RIG), present.sensed.shaft / item.arm, dt, steps=4
    )
    assert trace.position[1:] == pytest.approx(present.sensor.x[:-1], abs=3e-9)


def test_a_torque_drives_the_inertia_of_the_bench_like_one_at_the_table(setting):
    item = setting(3)
    assert plant_of(item).values["M"] == pytest.approx(631.65, rel=1e-4)
    heavy = on_bench(item, J=8e-4)
    assert plant_of(heavy).values["M"] == pytest.approx(2.0 * plant_of(item).values["M"])
    run = drift.rippled(item, item.contact(RIG))
    # What is left of the driving torque accelerates screw and motor alike.
    left = 0.5 * (run.driving[:-1] + run.driving[1:]) - run.sensed.friction
    share = 1.0 - item["bench", "J_m"] / item["bench", "J"]
    assert run.sensed.shaft - run.sensed.friction == pytest.approx(share * left, abs=1e-6)
