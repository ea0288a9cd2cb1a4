"""Feedforward for a table behind an elastic screw: the motor leads by the wind-up, and the table follows."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bristle import controllers, friction, plants, references, sensors
from bristle.core.errors import InputError
from bristle.core.experiment import Experiment, Feedforward, Run, Variant
from bristle.engine import run_open_loop
from bristle.files import read_experiment
from bristle.report.compensation import closing_sentences, standing
from bristle.simulation import feedforward_effort, motor_reference, simulate

DT, LEAD = 1e-3, 10e-3
ARM = LEAD / (2.0 * math.pi)
J, M, K = 5e-4, 150.0, 3e6
# One law on both sides, so that one compiled motion is enough.
FILM = friction.coulomb_viscous
MOTOR = FILM(kind="rotational", F_C=0.0, F_v=2e-3)
TABLE = FILM(F_C=0.0, F_v=900.0)
DRY = FILM(F_C=200.0, F_v=0.0)
WHOLE = Feedforward(
    mass=J + M * ARM**2, friction=FILM(kind="rotational", F_C=0.0, F_v=2e-3 + 900.0 * ARM**2)
)


def screw(**values):
    return plants.ball_screw(
        kind="rotational", **({"J": J, "M": M, "lead": LEAD, "k": K, "d": 1500.0} | values)
    )


def motion(count=4000, size=20.0, rate=4.0):
    """Position and acceleration of a table, converted to the motor [rad, rad/s^2], which begins smoothly."""
    t = DT * np.arange(count)
    begun = np.clip(t, 0.0, 1.0)
    begins = begun**3 * (10.0 - 15.0 * begun + 6.0 * begun**2)
    position = size * begins * np.sin(rate * t)
    return position, np.gradient(np.gradient(position, DT), DT)


def strokes():
    """Position and acceleration of a stroke, a rest and a stroke back [rad, rad/s^2]."""
    part = np.clip(np.arange(2000) * DT / 1.0 - 0.5, 0.0, 1.0)
    there = 12.0 * part**4 * (35.0 - 84.0 * part + 70.0 * part**2 - 20.0 * part**3)
    position = np.concatenate([there, there[::-1]])
    return position, np.gradient(np.gradient(position, DT), DT)


def test_the_effort_alone_moves_the_table_along_the_desired_motion():
    # In open loop, on the plant of the simulation: an error of a mass, of the stiffness or of a friction would show.
    position, acceleration = motion()
    missed, unaware = (
        np.max(
            np.abs(
                run_open_loop(screw(), MOTOR, effort, DT, table=TABLE, steps=4).position - position
            )
        )
        for effort in (
            feedforward_effort(fed, position, acceleration, DT)
            for fed in (Feedforward(plant=screw(), friction=MOTOR, table=TABLE), WHOLE)
        )
    )
    assert missed < 1e-4 * np.ptp(position)
    assert missed < 0.15 * unaware


@pytest.mark.parametrize("damping", [1500.0, 3e4])
def test_the_motor_of_the_simulation_turns_as_its_reference(damping):
    position, acceleration = motion()
    damped = screw(d=damping)
    fed = Feedforward(plant=damped, friction=MOTOR, table=TABLE)
    trace = run_open_loop(
        damped, MOTOR, feedforward_effort(fed, position, acceleration, DT), DT, table=TABLE, steps=4
    )
    lead, twist = (
        motor_reference(fed, position, acceleration, DT) - position,
        trace.motor_position - trace.position,
    )
    assert np.max(np.abs(lead - twist)[1500:3900]) < 0.005 * np.ptp(twist)


def test_a_stiff_screw_needs_the_feedforward_of_one_mass():
    position, acceleration = motion()
    stiff = Feedforward(plant=screw(k=1e13), friction=MOTOR, table=TABLE)
    effort = feedforward_effort(WHOLE, position, acceleration, DT)
    assert feedforward_effort(stiff, position, acceleration, DT) == pytest.approx(
        effort, abs=5e-3 * np.max(np.abs(effort))
    )
    assert motor_reference(stiff, position, acceleration, DT) == pytest.approx(position, abs=1e-6)


def test_dry_friction_winds_the_screw_up_and_the_motor_crosses_the_gap_once_for_each_reversal_of_the_force():
    position, acceleration = strokes()
    gap, places, sides = 40e-6, [1000, 1950, 2999], np.array([1.0, 1.0, -1.0])
    tight, loose = (
        motor_reference(
            Feedforward(plant=screw(backlash=wide), table=DRY), position, acceleration, DT
        )
        - position
        for wide in (0.0, gap)
    )
    # In the middle of a stroke the acceleration is zero, and the friction holds the screw wound up in the rest.
    assert tight[places] == pytest.approx(sides * 200.0 / (K * ARM), rel=1e-3)
    crossed = (loose - tight) * ARM / gap
    assert crossed[places] == pytest.approx(0.5 * sides, abs=1e-6)
    assert np.count_nonzero(np.diff(np.sign(crossed[600:]))) == 1


@pytest.mark.parametrize("time", [0.0, 0.2])
def test_a_shorter_wind_up_needs_more_effort(time):
    position, acceleration = strokes()
    fed = Feedforward(plant=screw(), table=DRY, wind_up_time=time)
    effort = feedforward_effort(fed, position, acceleration, DT)
    shortest = feedforward_effort(replace(fed, wind_up_time=5e-3), position, acceleration, DT)
    assert np.max(np.abs(effort)) < 0.5 * np.max(np.abs(shortest))


def test_the_wind_up_of_a_reversal_costs_no_more_than_the_rest_of_the_motion():
    position, acceleration = motion()
    mean = 0.5 * (acceleration[1:] + acceleration[:-1])
    rest = np.max(np.abs((J + M * ARM**2) * mean)) + 200.0 * ARM
    effort = feedforward_effort(Feedforward(plant=screw(), table=DRY), position, acceleration, DT)
    assert np.max(np.abs(effort)) < 2.0 * rest


def test_the_wind_up_has_no_lag_and_keeps_the_mean_of_a_ramp():
    def lead(acceleration, time):
        fed = Feedforward(plant=screw(d=0.0), wind_up_time=time)
        return motor_reference(fed, np.zeros(acceleration.size), acceleration, DT) * K / M

    draw = np.random.default_rng(5)
    signal = np.concatenate([np.zeros(60), draw.normal(size=80), np.zeros(60)])
    assert lead(signal[::-1], 0.021)[::-1] == pytest.approx(lead(signal, 0.021), abs=1e-12)
    assert np.sum(lead(signal, 0.021)) == pytest.approx(np.sum(signal))
    assert np.max(np.abs(lead(signal, 0.021))) < 0.5 * np.max(np.abs(lead(signal, 1e-3)))
    ramp = np.arange(200.0)
    assert lead(ramp, 0.05)[30:-30] == pytest.approx(ramp[30:-30])


LAW = controllers.cascade(kind="rotational", k_p=15.0, k_v=60.0 * J, k_i=900.0 * J, k_ff=1.0)
SUM = FILM(kind="rotational", F_C=0.05 + 200.0 * ARM, F_v=0.0)
OF_MOTOR = FILM(kind="rotational", F_C=0.05, F_v=0.0)


def loops(sensor_at="motor"):
    rigid = Variant(
        name="base",
        plant=screw(),
        friction=OF_MOTOR,
        table=DRY,
        controller=LAW,
        sensor=sensors.encoder(kind="rotational", resolution=1e-5),
        sensor_at=sensor_at,
        reference=references.sine(kind="rotational", amplitude=12.0, frequency=0.5),
        feedforward=Feedforward(mass=J + M * ARM**2, friction=SUM),
        run=Run(6.0, DT, substeps=4, settle=2.0, delay=1),
    )
    wound = replace(
        rigid, name="wound up", feedforward=Feedforward(plant=screw(), friction=OF_MOTOR, table=DRY)
    )
    return Experiment("loops", "rotational", (rigid, wound))


def test_the_table_follows_better_with_both_frictions_and_the_wind_up():
    result = simulate(loops())
    before, after = (result.variants[name] for name in ("base", "wound up"))
    assert after.true_error.rms < 0.1 * before.true_error.rms
    assert after.following_error.rms < before.true_error.rms
    # The encoder of the motor does not show this gain: reports compare the error of the load.
    assert before.following_error.rms < 0.5 * before.true_error.rms
    assert before.at_load
    assert standing(result).best.name == "wound up"
    assert any("error of the load" in sentence for sentence in closing_sentences(result))


def test_a_law_that_feeds_inertia_forward_does_not_feed_it_twice():
    law = controllers.sliding_mode(kind="rotational", J=J + M * ARM**2, lambda_=50.0, K_1=50.0)
    fed = (
        Feedforward(friction=WHOLE.friction),
        Feedforward(plant=screw(), friction=MOTOR, table=TABLE),
    )
    pair = tuple(
        replace(loop, controller=law, friction=MOTOR, table=TABLE, feedforward=one)
        for loop, one in zip(loops().variants, fed, strict=True)
    )
    before, after = simulate(Experiment("laws", "rotational", pair)).variants.values()
    assert after.true_error.rms < 0.25 * before.true_error.rms


def test_a_loop_on_the_table_keeps_its_reference():
    experiment = loops("load")
    quick = replace(
        experiment,
        variants=tuple(
            replace(v, run=replace(v.run, duration=0.05, settle=0.0)) for v in experiment.variants
        ),
    )
    rigid, wound = simulate(quick).variants.values()
    assert wound.reference.tolist() == rigid.reference.tolist()
    assert not wound.at_load


FILE = """
schema = 1
kind = "rotational"
[plant]
model = "ball_screw"
J = "5e-4 kg*m^2"
M = "150 kg"
lead = "10 mm"
k = "3 N/um"
[friction]
model = "coulomb"
F_C = "0.05 N*m"
[table_friction]
model = "coulomb"
F_C = "200 N"
[controller]
model = "cascade"
k_p = 15.0
k_v = "0.03 N*m*s/rad"
[reference]
model = "sine"
amplitude = "12 rad"
frequency = "0.5 Hz"
[run]
duration = "1 s"
sample_time = "1 ms"
[compare.fed.controller.feedforward]
plant = PLANT
wind_up_time = "20 ms"
friction = { model = "coulomb", F_C = "0.05 N*m" }
table_friction = { model = "coulomb", F_C = "190 N" }
"""


@pytest.mark.parametrize(
    ("plant", "mass"),
    [
        ('"own"', 150.0),
        (
            '{ model = "ball_screw", J = "5e-4 kg*m^2", M = "140 kg", lead = "10 mm", k = "3 N/um" }',
            140.0,
        ),
    ],
)
def test_a_file_names_the_plant_and_the_friction_of_the_table(plant, mass):
    fed = read_experiment(FILE.replace("PLANT", plant).encode()).variants[-1].feedforward
    assert (fed.plant.values["M"], fed.table.values["F_C"], fed.friction.values["F_C"]) == (
        mass,
        190.0,
        0.05,
    )
    assert (fed.wind_up_time, fed.table.kind) == (0.02, "translational")


@pytest.mark.parametrize(
    ("read", "given", "words"),
    [
        *(
            (lambda values: Feedforward(**values), *row)
            for row in (
                (
                    {"table": DRY},
                    r"feedforward\.table: needs a plant with a table behind a screw.*ball_screw",
                ),
                (
                    {"plant": screw(), "table": friction.coulomb(kind="rotational", F_C=1.0)},
                    r"feedforward\.table: must be translational",
                ),
                (
                    {"plant": screw(), "mass": 1.0},
                    r"feedforward\.mass: conflicts with a plant that has two masses.*Omit mass",
                ),
            )
        ),
        *(
            (lambda text: read_experiment(text.encode()), *row)
            for row in (
                (
                    FILE.replace("PLANT", '"none"'),
                    r"compare\.fed\.controller\.feedforward\.table: needs a plant with a table behind a screw",
                ),
                (
                    FILE.replace("plant = PLANT", 'plant = "own"\nmass = "1e-3 kg*m^2"'),
                    r"compare\.fed\.controller\.feedforward\.mass: conflicts",
                ),
                (
                    FILE.replace("PLANT", '"mine"'),
                    r"compare\.fed\.controller\.feedforward\.plant.*is not a plant for the feedforward",
                ),
            )
        ),
    ],
)
def test_a_faulty_feedforward_of_two_masses_is_refused(read, given, words):
    with pytest.raises(InputError, match=words):
        read(given)
