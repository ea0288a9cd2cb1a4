"""Friction in Drake: a mass at rest, the motion of bristle, and state in the context only."""

import numpy as np
import pytest

import bristle as br

pytest.importorskip("pydrake")
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, Demultiplexer, LogVectorOutput

from bristle.apps.targets.drake import DrakeFriction

DT, MASS = 5e-4, 28.0
ELEMENTS = br.friction.maxwell_slip(F_C="20 N", k_i=["6 N/um", "3 N/um"], nu_i=[0.4, 0.6])
LUGRE = br.friction.lugre(
    F_C="20 N", F_S="28 N", v_S="2 mm/s", sigma_0="1 N/um", sigma_1="1 kN*s/m", sigma_2="200 N*s/m"
)


def moved(friction, effort, duration):
    """Return the positions of a mass of Drake on friction under a constant effort, and its simulator."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(DT))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    body = plant.AddRigidBody(
        "table", SpatialInertia(MASS, np.zeros(3), UnitInertia(1.0, 1.0, 1.0))
    )
    joint = plant.AddJoint(
        PrismaticJoint("axis", plant.world_frame(), body.body_frame(), [1.0, 0.0, 0.0])
    )
    plant.AddJointActuator("motor", joint)
    plant.Finalize()
    contact, halves, total = (
        builder.AddSystem(part)
        for part in (DrakeFriction(friction, DT), Demultiplexer(2), Adder(2, 1))
    )
    constant = builder.AddSystem(ConstantVectorSource([effort]))
    builder.Connect(plant.get_state_output_port(), halves.get_input_port())
    for at, name in enumerate(("position", "velocity")):
        builder.Connect(halves.get_output_port(at), contact.GetInputPort(name))
    builder.Connect(contact.GetOutputPort("effort"), total.get_input_port(0))
    builder.Connect(constant.get_output_port(), total.get_input_port(1))
    builder.Connect(total.get_output_port(), plant.get_actuation_input_port())
    logger = LogVectorOutput(plant.get_state_output_port(), builder, DT)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(duration)
    return logger.FindLog(simulator.get_context()).data()[0], simulator


def test_a_mass_below_break_away_holds_without_drift():
    x, _ = moved(ELEMENTS, 15.0, 1.5)
    bristle = br.engine.run_open_loop(
        br.plants.inertia(M=MASS), ELEMENTS, np.full(x.size, 15.0), DT
    ).position
    assert np.ptp(x[-1000:]) < 1e-12
    assert abs(x[-1] - bristle[-1]) < 0.15 * bristle[-1]


@pytest.mark.parametrize("friction", [ELEMENTS, LUGRE], ids=["maxwell_slip", "lugre"])
def test_a_sliding_mass_moves_as_in_bristle(friction):
    x, _ = moved(friction, 60.0, 0.5)
    bristle = br.engine.run_open_loop(
        br.plants.inertia(M=MASS), friction, np.full(x.size, 60.0), DT
    ).position
    assert np.max(np.abs(x - bristle)) < 2e-3 * np.max(np.abs(bristle))


def test_the_force_after_moves_is_that_of_bristle_and_a_copy_of_the_context_goes_its_own_way():
    contact = DrakeFriction(ELEMENTS, DT)
    context, x = (
        contact.CreateDefaultContext(),
        np.cumsum(1e-6 * np.random.default_rng(2).standard_normal(200)) + 0.3,
    )
    contact.GetInputPort("velocity").FixValue(context, [0.0])

    def efforts(context, positions):
        given = []
        for place in positions:
            contact.GetInputPort("position").FixValue(context, [place])
            given.append(contact.GetOutputPort("effort").Eval(context)[0])
            context.SetDiscreteState(contact.EvalUniquePeriodicDiscreteUpdate(context))
        return np.array(given)

    first = efforts(context, x[:100])
    # Predicted at rest, the force is that of a step of length 0 after the step to x.
    expected = -br.response(ELEMENTS, np.repeat(x, 2), DT)[1::2]
    assert np.allclose(first, expected[:100], rtol=0.0, atol=1e-9)
    copy = context.Clone()
    efforts(copy, x[:50])
    assert np.allclose(efforts(context, x[100:]), expected[100:], rtol=0.0, atol=1e-9)
