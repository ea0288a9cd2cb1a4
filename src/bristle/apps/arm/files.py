"""Files of an identified arm: a URDF with its bodies, and a scene of MuJoCo with the friction of each joint."""

from collections.abc import Mapping
from xml.etree import ElementTree as Xml

import numpy as np

from bristle.apps.arm.robot import Robot
from bristle.apps.targets.mjcf import ITERATIONS, JointFriction, friction_of_joint
from bristle.core import InputError, Model
from bristle.exports import Request

INERTIAS = (
    ("ixx", 0, 0),
    ("ixy", 0, 1),
    ("ixz", 0, 2),
    ("iyy", 1, 1),
    ("iyz", 1, 2),
    ("izz", 2, 2),
)


def with_inertias(robot: Robot, bodies: np.ndarray) -> bytes:
    """Return the URDF of a robot with the inertia of each moved body, in the frame of its joint; links fixed to it have none."""
    tree = Xml.fromstring(robot.urdf)
    links, at = (
        {link.get("name", ""): link for link in tree.iter("link")},
        dict(zip(robot.names, bodies, strict=True)),
    )
    for joint in tree.iter("joint"):
        child = joint.find("child")
        link = None if child is None else links.get(child.get("link", ""))
        if link is None:
            continue
        for inertial in link.findall("inertial"):
            link.remove(inertial)
        if (row := at.get(joint.get("name", ""))) is not None:
            mass, centre, about = centred(row)
            inertial = Xml.SubElement(link, "inertial")
            Xml.SubElement(inertial, "origin", xyz=_text(centre), rpy="0 0 0")
            Xml.SubElement(inertial, "mass", value=repr(mass))
            Xml.SubElement(
                inertial, "inertia", {name: repr(float(about[i, j])) for name, i, j in INERTIAS}
            )
    return Xml.tostring(tree, encoding="utf-8")


def centred(row: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Return mass [kg], centre of mass [m] and inertia about it [kg*m^2] of the dynamic parameters of a body."""
    mass, centre = float(row[0]), row[1:4] / row[0]
    xx, xy, yy, xz, yz, zz = row[4:]
    about = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return mass, centre, about - mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))


def arm_scene(
    robot: Robot, bodies: np.ndarray, rotors: np.ndarray, frictions: Mapping[str, Model]
) -> tuple[str, dict[str, str]]:
    """Return the scene of an arm with a motor and the friction of each joint, and by joint the error of approximated friction."""
    root = Xml.Element("mujoco", model="arm")
    Xml.SubElement(root, "compiler", angle="radian", autolimits="true")
    Xml.SubElement(
        root, "option", timestep="1e-4", integrator="Euler", noslip_iterations=str(ITERATIONS)
    )
    chain = {0: Xml.SubElement(root, "worldbody")}
    tendons, actuators, notes = (
        Xml.SubElement(root, "tendon"),
        Xml.SubElement(root, "actuator"),
        dict[str, str](),
    )
    model = robot.model
    for body, (name, row, rotor) in enumerate(
        zip(robot.names, bodies, rotors, strict=True), start=1
    ):
        place, joint = model.jointPlacements[body], model.joints[body]
        # The columns of the motion subspace: a translation, then a rotation.
        along = (
            np.asarray(joint.createData().S).ravel()
            if joint.nq == joint.nv
            else np.array([0.0] * 5 + [1.0])
        )
        element = Xml.SubElement(
            chain[model.parents[body]],
            "body",
            name=name,
            pos=_text(place.translation),
            quat=_quaternion(place.rotation),
        )
        slides = bool(np.any(along[:3]))
        attributes = {
            "name": name,
            "type": "slide" if slides else "hinge",
            "axis": _text(along[:3] if slides else along[3:]),
            "armature": repr(float(rotor)),
        }
        friction = JointFriction({}, [], [])
        try:
            friction = (
                friction_of_joint(Request(frictions[name], name, 1e-4))
                if name in frictions
                else friction
            )
        except InputError as error:
            notes[name] = f"no friction, because it {error.message}"
        if friction.deviation is not None and not friction.deviation.is_exact:
            notes[name] = friction.deviation.text(frictions[name].kind)
        Xml.SubElement(element, "joint", attributes | friction.attributes)
        mass, centre, about = centred(row)
        full = " ".join(
            repr(float(about[i, j])) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
        )
        Xml.SubElement(element, "inertial", pos=_text(centre), mass=repr(mass), fullinertia=full)
        Xml.SubElement(actuators, "motor", name=f"{name}_effort", joint=name)
        actuators.extend(friction.actuators)
        tendons.extend(friction.tendons)
        chain[body] = element
    Xml.indent(root)
    return Xml.tostring(root, encoding="unicode") + "\n", notes


def _text(vector: np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in vector)


def _quaternion(rotation: np.ndarray) -> str:
    """Return a rotation as a quaternion, the real part first."""
    from scipy.spatial.transform import Rotation

    return _text(np.roll(Rotation.from_matrix(rotation).as_quat(), 1))
