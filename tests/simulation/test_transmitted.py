"""Friction that rises with what passes on to the load: fed forward, in loops, behind a screw, in experiment files."""

import numpy as np
import pytest
from tests.simulation import transmitted_truth as truth

import bristle as br
from bristle.core.experiment import Experiment, Feedforward, Run, Variant
from bristle.simulation.compensation import feedforward_effort

pytestmark = pytest.mark.usefixtures("in_plain_python")

DT = 1e-3
ARM = br.plants.find("inertia+gravity", ["g_sin"])(
    kind="rotational", M=truth.J, g_sin=truth.GRAVITY
)
PLAIN = {"F_C": truth.F_C, "F_v": truth.F_V}
GEARED = br.friction.find("coulomb_viscous+transmitted")(
    kind="rotational", **PLAIN, c_T=truth.SHARE
)
LEVEL = br.friction.coulomb_viscous(kind="rotational", **PLAIN)


def test_built_in_feedforward_of_a_law_passes_the_gear_as_well():
    _, q, v, a = truth.swing(2.0, 1)
    alone = feedforward_effort(Feedforward(friction=GEARED, carries=ARM), q, a, DT)
    load = truth.J * a + truth.GRAVITY * np.sin(q)
    friction, moving = truth.effort(q, v, a) - load, np.abs(v) > 0.05
    assert np.max(np.abs(alone - friction)[moving]) < 0.01 * np.max(np.abs(friction))


def test_without_a_plant_the_feedforward_is_transmitted():
    _, q, _, a = truth.swing(2.0, 1)
    fed = feedforward_effort(Feedforward(mass=truth.J, plant=ARM, friction=GEARED), q, a, DT)
    known = feedforward_effort(
        Feedforward(mass=truth.J, plant=ARM, friction=GEARED, carries=ARM), q, a, DT
    )
    assert fed == pytest.approx(known, abs=1e-15)


def test_a_plant_without_an_inverse_is_refused():
    screw = br.plants.ball_screw(**br.plants.ball_screw.example, kind=GEARED.kind)
    with pytest.raises(
        br.core.InputError,
        match=r"without inverse dynamics.*the transmitted effort is the effort of the feedforward",
    ):
        feedforward_effort(
            Feedforward(friction=GEARED, carries=screw), np.arange(3.0), np.zeros(3), DT
        )


def followed(**fed):
    """Root mean square of the following error of an arm [rad]."""
    variant = Variant(
        "arm",
        ARM,
        GEARED,
        br.controllers.cascade(kind="rotational", k_p=15.0, k_v=1.0, k_i=2.0, k_ff=1.0),
        br.sensors.encoder(kind="rotational", resolution=1e-6),
        br.references.sine(kind="rotational", amplitude=0.9, frequency=0.4),
        Feedforward(mass=truth.J, plant=ARM, **fed),
        Run(duration=2.4, sample_time=4e-3, delay=1, settle=0.4, substeps=2),
    )
    return (
        br.simulate(Experiment("one", "rotational", (variant,))).variants["arm"].following_error.rms
    )


@pytest.mark.parametrize("along", ["desired", "measured"])
def test_a_loop_follows_better_by_it_along_either_motion(along):
    without, with_it = (followed(friction=model, along=along) for model in (LEVEL, GEARED))
    assert 1.5 * with_it < without < followed()


@pytest.mark.slow
def test_transmitted_effort_along_measured_motion_is_that_of_the_named_plant():
    with_it = followed(friction=GEARED, along="measured", carries=ARM)
    assert with_it == pytest.approx(followed(friction=GEARED, along="measured"), rel=1e-6)
    assert with_it < 0.9 * followed(
        friction=GEARED, along="measured", carries=br.plants.inertia(kind="rotational", M=1e-9)
    )


J, M, LEAD, TORQUE = 2e-3, 50.0, 0.02, 3.0
ARM_OF_SCREW = LEAD / (2.0 * np.pi)


def turned_by(motor, table):
    """Angle of the motor of a stiff screw after a second under a constant torque [rad]."""
    plant = br.plants.ball_screw(kind="rotational", J=J, M=M, lead=LEAD, k=1e9, d=1e4)
    trace = br.engine.run_open_loop(plant, motor, np.full(251, TORQUE), 4e-3, steps=2, table=table)
    return trace.motor_position[250]


def test_the_friction_of_a_motor_rises_with_all_that_it_turns_and_pulls():
    motor = br.friction.find("coulomb+transmitted")(kind="rotational", F_C=0.4, c_T=0.25)
    load = (TORQUE - 0.4) / 1.25
    expected = 0.5 * load / (J + M * ARM_OF_SCREW**2)
    assert turned_by(motor, br.friction.viscous(F_v=0.0)) == pytest.approx(expected, rel=2e-3)


@pytest.mark.slow
def test_the_friction_of_a_table_rises_with_its_driving_force():
    table = br.friction.find("coulomb+transmitted")(F_C=100.0, c_T=0.25)
    expected = 0.5 * (TORQUE - 100.0 * ARM_OF_SCREW) / (J + 1.25 * M * ARM_OF_SCREW**2)
    assert turned_by(br.friction.viscous(kind="rotational", F_v=0.0), table) == pytest.approx(
        expected, rel=2e-3
    )


EXPERIMENT = """
schema = 1
kind = "rotational"
[plant]
model = "inertia+gravity"
M = 0.05
g_sin = 2.0
[friction]
model = "coulomb_viscous+transmitted"
F_C = 0.15
F_v = 0.05
c_T = 0.25
[controller]
model = "cascade"
k_p = 15.0
k_v = 1.0
[controller.feedforward.friction]
model = "{model}"
F_C = 0.15
F_v = 0.05
{share}
[reference]
model = "sine"
amplitude = 0.9
frequency = 0.4
[run]
duration = 1.0
sample_time = 1e-3
"""


def test_an_experiment_file_finds_the_transmitted_effort_by_default():
    risen = EXPERIMENT.format(model="coulomb_viscous+transmitted", share="c_T = 0.25").encode()
    plain = EXPERIMENT.format(model="coulomb_viscous", share="").encode()
    carries, nothing = (
        br.read_experiment(text).variants[0].feedforward.carries for text in (risen, plain)
    )
    assert carries == ARM
    assert nothing is None
