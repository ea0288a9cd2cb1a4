"""The bench of the paper: what the torque sensor reads of a motion, and what it does not."""

from dataclasses import replace

import numpy as np
import pytest

from bristle.engine import run_open_loop
from bristle.paper.bench import bench_of, led, measured, plant_of, sensor_numbers, sensor_says, walk
from bristle.paper.drift import rippled

RIG = "virtual rig"


def on_bench(setting, **values):
    """The experiment with other numbers of its bench; None for one that is left out."""
    numbers = {key: value for key, value in (setting.numbers["bench"] | values).items() if value is not None}
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
    assert sensor_numbers([read(half).sensed])["inertia"] == pytest.approx(0.5 * apart["inertia"], rel=1e-6)


def test_the_torque_that_leads_the_table_moves_it_along_the_path_when_it_drives_it(setting):
    item = on_bench(setting(8), torque_filter=None, J_m=0.0)
    present = read(item)
    # With nothing before the sensor the shaft carries all that the motor gives.
    dt = 5e-4
    trace = run_open_loop(plant_of(item), item.contact(RIG), present.sensed.shaft / item.arm, dt, steps=4)
    assert trace.position[1:] == pytest.approx(present.sensor.x[:-1], abs=3e-9)


def test_a_torque_drives_the_inertia_of_the_bench_like_one_at_the_table(setting):
    item = setting(3)
    assert plant_of(item).values["M"] == pytest.approx(631.65, rel=1e-4)
    heavy = on_bench(item, J=8e-4)
    assert plant_of(heavy).values["M"] == pytest.approx(2.0 * plant_of(item).values["M"])
    run = rippled(item, item.contact(RIG))
    # What is left of the driving torque accelerates screw and motor alike.
    left = 0.5 * (run.driving[:-1] + run.driving[1:]) - run.sensed.friction
    share = 1.0 - item["bench", "J_m"] / item["bench", "J"]
    assert run.sensed.shaft - run.sensed.friction == pytest.approx(share * left, abs=1e-6)


def test_the_sentence_omits_a_missing_filter(setting):
    apart = {"apart": 0.01, "inertia": 1e-4, "filter": 0.0}
    assert "filter" not in sensor_says(bench_of(on_bench(setting(9), torque_filter=None)), apart, "Here")
    assert "filter of 200 Hz" in sensor_says(bench_of(setting(9)), apart, "Here")


def test_readings_are_a_twentieth_of_a_micrometre_apart_and_at_every_turn(setting):
    item = setting(5)
    record = measured(item, item.contact(RIG), [2e-6, -1e-6], np.random.default_rng(0))
    assert np.max(np.abs(np.diff(record.actual.x))) < 6e-8
    assert 90 < record.x.size < 110
    assert record.actual.x[record.turns] == pytest.approx([2e-6, -1e-6], abs=1e-9)
    assert np.std(record.torque - record.actual.torque) == pytest.approx(0.2e-3, rel=0.25)
