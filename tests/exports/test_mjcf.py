"""Scenes of MuJoCo: what they hold, what they refuse, and, where MuJoCo is installed, that they slip alike."""

import importlib.util
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import bristle as br
from bristle.exports.mjcf import write
from bristle.exports.targets import Request

needs_mujoco = pytest.mark.skipif(importlib.util.find_spec("mujoco") is None, reason="needs mujoco")
LUGRE = br.friction.lugre(F_C=1.0, F_S=1.5, v_S=1e-3, sigma_0=1e5, sigma_1=316.0, sigma_2=0.4)


def scene(model, folder, **options):
    result = br.export(model, "mjcf", folder / "out", **options)
    return ElementTree.parse(folder / "out" / "axis_x.xml").getroot(), result.notes


def test_lugre_is_a_passive_motor_and_the_integrator_is_euler(tmp_path):
    root, notes = scene(LUGRE, tmp_path, mass="2 kg")
    motor = root.find("actuator/dcmotor").attrib
    assert [float(number) for number in motor["lugre"].split()] == [1e5, 316.0, 1.0, 1.5, 1e-3]
    assert float(motor["damping"]) == 0.4
    assert root.find("option").attrib["integrator"] == "Euler"
    assert float(root.find("worldbody/body/inertial").attrib["mass"]) == 2.0
    assert "Euler" in notes[0]


def test_dry_and_viscous_friction_belong_to_the_joint_and_an_offset_is_a_motor(tmp_path):
    friction = br.friction.with_slots(br.friction.coulomb_viscous, [])
    root, notes = scene(friction(kind="rotational", F_C=0.2, F_v=0.03, offset=0.1), tmp_path)
    joint = root.find("worldbody/body/joint").attrib
    assert (joint["type"], float(joint["frictionloss"]), float(joint["damping"])) == ("hinge", 0.2, 0.03)
    assert root.find("keyframe/key").attrib["ctrl"] == "0 -0.1"
    assert len(notes) == 2


@pytest.mark.parametrize(("kind", "inertia", "axis"), [("translational", "1 1 1", "1 0 0"), ("rotational", "0.5 0.5 0.5", "0 0 1")])
def test_the_body_is_a_sliding_mass_or_a_hinged_inertia(kind, inertia, axis):
    friction = br.friction.coulomb(kind=kind, F_C=0.2)
    root = ElementTree.fromstring(write(Request(friction, "axis_x", 1e-3, mass=0.5)).files["axis_x.xml"])
    body = root.find("worldbody/body")
    assert body.find("inertial").attrib["diaginertia"] == inertia
    assert float(body.find("inertial").attrib["mass"]) == (0.5 if kind == "translational" else 1.0)
    assert body.find("joint").attrib["axis"] == axis
    assert "damping" not in body.find("joint").attrib
    assert root.find("keyframe") is None
    assert root.find("actuator/dcmotor") is None


def test_the_scene_states_the_time_constant_of_the_bristles():
    text = write(Request(LUGRE, "axis_x", 1e-3, mass=4.0)).files["axis_x.xml"]
    assert f"{(4.0 / 1e5) ** 0.5:.2g}" in text
    assert "--" not in text.partition("<!--")[2].partition("-->")[0]


@pytest.mark.parametrize(
    ("model", "words"),
    [
        (br.friction.dahl(F_C=1.0, sigma_0=1e5), "lacks this friction model"),
        (br.friction.with_slots(br.friction.coulomb, ["asymmetry"])(F_C_pos=1.0, F_C_neg=2.0), "both directions"),
        (LUGRE.with_values(v_d=0.1), "does not fade"),
    ],
)
def test_models_that_mujoco_lacks_are_refused_by_name(model, words, tmp_path):
    with pytest.raises(br.core.InputError, match=words):
        br.export(model, "mjcf", tmp_path / "out")


@needs_mujoco
def test_stick_slip_converges_to_bristle_with_first_order(tmp_path):
    import mujoco

    br.export(LUGRE, "mjcf", tmp_path / "out")
    text = (tmp_path / "out" / "axis_x.xml").read_text()
    if int(mujoco.__version__.partition(".")[0]) < 4:  # before, the electrical branch could not be switched off
        text = text.replace('motorconst="0"', 'motorconst="1e-9"')
    pulled = br.plants.pulled_inertia(M=1.0, k=2.0, v_e=0.1)
    expected = np.array(br.engine.run_open_loop(pulled, LUGRE, np.zeros(400_000), 1e-5).position)[::1000]
    errors = []
    for step in (1e-4, 5e-5):
        made = mujoco.MjModel.from_xml_string(text.replace('timestep="0.0001"', f'timestep="{step}"'))
        data, every, x = mujoco.MjData(made), round(0.01 / step), []
        for k in range(400 * every):
            if k % every == 0:
                x.append(data.qpos[0])
            data.ctrl[0] = 2.0 * (0.1 * k * step - data.qpos[0])
            mujoco.mj_step(made, data)
        errors.append(np.max(np.abs(np.array(x) - expected)))
    assert errors[0] < 2e-4
    assert errors[1] == pytest.approx(0.5 * errors[0], rel=0.2)
