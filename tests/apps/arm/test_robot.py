"""Robots from files: URDF and Denavit-Hartenberg parameters agree, joints are chosen by name, and faults are named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bristle import friction
from bristle.apps.arm.files import arm_scene, with_inertias
from bristle.apps.arm.robot import read_robot
from bristle.core import Content, InputError

CHAIN = """
[[joint]]
name = "turn"
d = "400 mm"
a = 0.1
alpha = "-90 deg"
mass = 8.0

[[joint]]
name = "lift"
a = "0.5 m"
offset = "-90 deg"
mass = "4 kg"
reversed = true
"""
URDF = """<robot name="r"><link name="base"/><link name="l1"/><link name="l2"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="l1"/><origin xyz="0 0 0" rpy="0 0 0"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="9" velocity="9"/></joint>
<joint name="lift" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0.1 0 0.4" rpy="-1.5707963267948966 0 -0.0"/>
<axis xyz="0 0 -1"/><limit lower="-3" upper="3" effort="9" velocity="9"/></joint></robot>"""
BODIES = np.array(
    [
        [8.0, 0.4, 0.1, 0.8, 1.1, 0.01, 1.2, 0.02, -0.03, 0.9],
        [4.0, 0.8, -0.2, 0.1, 0.4, 0.02, 0.6, 0.01, 0.02, 0.5],
    ]
)


def robot(text, name):
    return read_robot(Content(Path(name), text.encode()))


@pytest.fixture
def chain(pin):
    return robot(CHAIN, "robot.toml")


def test_both_kinds_of_files_give_the_same_efforts(chain):
    # In the URDF, the second joint does not turn by the offset: its angle is that much larger, against its direction.
    q, v, a = np.random.default_rng(0).normal(size=(3, 20, 2))
    of_urdf = robot(URDF, "robot.urdf")
    turned = q + np.array([0.0, np.pi / 2])
    np.testing.assert_allclose(
        chain.effort(BODIES, q, v, a), of_urdf.effort(BODIES, turned, v, a), atol=1e-9
    )
    assert chain.names == of_urdf.names == ("turn", "lift")


def test_efforts_are_linear_in_the_dynamic_parameters(chain):
    q, v, a = np.random.default_rng(1).normal(size=(3, 20, 2))
    np.testing.assert_allclose(
        chain.regressor(q, v, a) @ BODIES.ravel(), chain.effort(BODIES, q, v, a), atol=1e-9
    )


def test_gravity_acts_on_the_lifted_arm_only(chain):
    still = np.zeros((1, 2))
    effort = chain.effort(BODIES, still, still, still)[0]
    assert effort[0] == pytest.approx(0.0, abs=1e-12)
    assert abs(effort[1]) > 1.0


def test_joints_outside_the_log_stay_at_zero(chain):
    q, v, a = np.random.default_rng(2).normal(size=(3, 5, 1))
    alone = chain.of(["lift"])
    assert alone.names == ("lift",)
    whole = [np.hstack([np.zeros_like(signal), signal]) for signal in (q, v, a)]
    np.testing.assert_allclose(
        alone.effort(BODIES[1:], q, v, a)[:, 0], chain.effort(BODIES, *whole)[:, 1], atol=1e-9
    )
    with pytest.raises(InputError, match="is not a joint of the robot"):
        chain.of(["lift", "wrist"])


def test_an_identified_urdf_has_the_bodies(pin):
    of_urdf = robot(URDF, "robot.urdf")
    again = robot(with_inertias(of_urdf, BODIES).decode(), "robot.urdf")
    np.testing.assert_allclose(again.prior, BODIES, atol=1e-9)


@pytest.mark.slow
def test_the_scene_has_a_motor_and_friction_for_each_joint(chain):
    frictions = {
        "turn": friction.coulomb_viscous(F_C=3.0, F_v=2.0),
        "lift": friction.dahl(F_C=3.0, sigma_0=1e3),
    }
    text, errors = arm_scene(chain, BODIES, np.array([0.5, 0.25]), frictions)
    assert list(errors) == ["lift"]
    assert "% rms" in errors["lift"]
    assert (
        '<joint name="turn" type="hinge" axis="0.0 0.0 1.0" armature="0.5" frictionloss="3.0" damping="2.0" />'
        in text
    )
    assert text.count("<motor ") == 2
    assert text.count('<joint joint="lift" coef="1" />') == text.count("springyield=") > 2


def test_mujoco_computes_the_same_efforts_from_the_scene(chain):
    mujoco = pytest.importorskip("mujoco", reason="needs pip install bristle[bench]")
    rotors = np.array([0.5, 0.25])
    model = mujoco.MjModel.from_xml_string(arm_scene(chain, BODIES, rotors, {})[0])
    data = mujoco.MjData(model)
    for q, v, a in np.random.default_rng(4).normal(size=(5, 3, 2)):
        data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
        mujoco.mj_inverse(model, data)
        expected = chain.effort(BODIES, q[None], v[None], a[None])[0] + rotors * a
        np.testing.assert_allclose(data.qfrc_inverse, expected, atol=1e-8)


@pytest.mark.parametrize(
    ("text", "name", "message"),
    [
        ("nothing", "robot.urdf", "is not a URDF"),
        ("", "robot.toml", r"joint: is missing"),
        ('[[joint]]\ntheta = "1 rad"', "robot.toml", r"joint\[0\].theta: unknown key"),
        ('[[joint]]\nd = "1 kg"', "robot.toml", r"joint\[0\].d"),
    ],
)
def test_files_that_describe_no_arm_are_refused(pin, text, name, message):
    with pytest.raises(InputError, match=message):
        robot(text, name)
