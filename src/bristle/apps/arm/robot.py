r"""`Robot`: the rigid bodies of an arm, from a URDF or from Denavit-Hartenberg parameters, with the joint efforts of a motion.

.. math:: \tau = Y(q, \dot q, \ddot q)\,\pi

with the dynamic parameters of each body, :math:`\pi_i = (m, m c_x, m c_y, m c_z, I_{xx}, I_{xy}, I_{yy}, I_{xz}, I_{yz},
I_{zz})`, in the frame of its joint [1]_.

References
----------
.. [1] J. Carpentier et al., "The Pinocchio C++ library", IEEE/SICE Int. Symp. System Integration, 2019.
   doi:10.1109/SII.2019.8700380
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from bristle.core import Content, InputError, MissingExtraError, Variable, quantity
from bristle.files import read_toml

OF_BODY = ("m", "mc_x", "mc_y", "mc_z", "I_xx", "I_xy", "I_yy", "I_xz", "I_yz", "I_zz")
"""Dynamic parameters of a body: mass [kg], first moments [kg*m], moments of inertia about the origin of its joint [kg*m^2]."""
PRIOR_DENSITY = 0.1  # moment of inertia over mass of a body that no file describes [m^2]
PRIOR_MASS = 1.0  # of such a body [kg]
KEYS = {
    "d": "translational",
    "a": "translational",
    "alpha": "rotational",
    "offset": "rotational",
    "mass": "translational",
}


def pinocchio() -> Any:
    """Return the library of rigid-body dynamics."""
    try:
        return import_module("pinocchio")
    except ImportError:
        raise MissingExtraError.of("the dynamics of an arm", "arm") from None


@dataclass(frozen=True)
class Robot:
    """The moved joints of an arm, in the order of the chain."""

    model: Any
    """Model of Pinocchio."""
    urdf: bytes = b""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the joints."""
        return tuple(self.model.names)[1:]

    def of(self, names: Sequence[str]) -> Robot:
        """Return the arm with these joints only; the others stay at 0."""
        if unknown := [name for name in names if name not in self.names]:
            raise InputError(
                "is not a joint of the robot",
                path="joint.name",
                value=unknown[0],
                allowed=", ".join(self.names),
            )
        pin = pinocchio()
        fixed = [self.model.getJointId(name) for name in self.names if name not in names]
        model = (
            pin.buildReducedModel(self.model, fixed, pin.neutral(self.model))
            if fixed
            else self.model
        )
        if tuple(model.names)[1:] != tuple(names):
            raise InputError(
                "are not in the order of the robot",
                path="joint",
                value=", ".join(names),
                allowed=", ".join(model.names[1:]),
            )
        return Robot(model, self.urdf)

    @property
    def prior(self) -> np.ndarray:
        """Dynamic parameters in the file, shape (body, 10); a usual body in place of a body without a valid inertia."""
        usual = np.array(
            [1.0, 0.0, 0.0, 0.0, *(PRIOR_DENSITY * np.array([1.0, 0.0, 1.0, 0.0, 0.0, 1.0]))]
        )
        rows = [
            np.asarray(inertia.toDynamicParameters()) for inertia in list(self.model.inertias)[1:]
        ]
        return np.array(
            [row if is_consistent(row) else usual * max(row[0], PRIOR_MASS) for row in rows]
        )

    def regressor(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Return the columns of the dynamic parameters in the joint efforts, shape (row, joint, 10 * joint), for (row, joint)."""
        pin, data = pinocchio(), self.model.createData()
        columns = np.empty((len(q), self.model.nv, 10 * self.model.nv))
        for row, motion in enumerate(zip(self._configurations(q), v, a, strict=True)):
            columns[row] = pin.computeJointTorqueRegressor(self.model, data, *motion)
        return columns

    def effort(
        self, parameters: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray
    ) -> np.ndarray:
        """Return the joint efforts [N or N*m] of the bodies with these dynamic parameters, shape (row, joint)."""
        pin, model = pinocchio(), self.model.copy()
        for body, row in enumerate(parameters, start=1):
            model.inertias[body] = pin.Inertia.FromDynamicParameters(row)
        data = model.createData()
        motions = zip(self._configurations(q), v, a, strict=True)
        return np.array([pin.rnea(model, data, *motion) for motion in motions])

    def _configurations(self, q: np.ndarray) -> np.ndarray:
        """Return the configurations of Pinocchio: cosine and sine for an endless joint, else the joint coordinate."""
        columns = list[np.ndarray]()
        for joint, values in zip(list(self.model.joints)[1:], q.T, strict=True):
            columns += [values] if joint.nq == 1 else [np.cos(values), np.sin(values)]
        return np.ascontiguousarray(np.stack(columns, axis=1))


def is_consistent(row: np.ndarray) -> bool:
    """Return whether some distribution of positive mass has these dynamic parameters."""
    return bool(np.linalg.eigvalsh(pseudo_inertia(row))[0] > 0.0)


def pseudo_inertia(row: np.ndarray) -> np.ndarray:
    """Return the second moments of the mass of a body about the origin of its joint, shape (4, 4)."""
    m, mx, my, mz, xx, xy, yy, xz, yz, zz = row
    about = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    moments = np.zeros((4, 4))
    moments[:3, :3] = 0.5 * np.trace(about) * np.eye(3) - about
    moments[:3, 3] = moments[3, :3] = mx, my, mz
    moments[3, 3] = m
    return moments


def read_robot(content: Content) -> Robot:
    """Return the robot in a URDF file, or in a TOML file of Denavit-Hartenberg parameters.

    Raises
    ------
    InputError
        If the file describes no arm, or a joint has more than one degree of freedom.
    MissingExtraError
        Without Pinocchio: ``pip install "bristle[arm]"``.
    """
    pin = pinocchio()
    if content.source.suffix.lower() == ".toml":
        return chain_of(read_toml(content).data.get("joint", []))
    try:
        model = pin.buildModelFromXML(content.data.decode("utf-8"))
    except (ValueError, RuntimeError, UnicodeDecodeError) as error:
        raise InputError(
            f"is not a URDF that Pinocchio can read ({error})", path=str(content.source)
        ) from None
    if many := [
        name for name, joint in zip(model.names, model.joints, strict=True) if joint.nv > 1
    ]:
        raise InputError(
            "has several degrees of freedom",
            path=str(content.source),
            value=many[0],
            allowed="revolute and prismatic joints",
        )
    if model.nv == 0:
        raise InputError("has no moved joint", path=str(content.source))
    return Robot(model, content.data)


def chain_of(joints: Sequence[Mapping[str, Any]]) -> Robot:
    """Return a chain of joints that each turn by `offset` + q about z, move by `d` along z and `a` along x, and turn by `alpha` about x."""
    pin = pinocchio()
    model, parent, place = pin.Model(), 0, pin.SE3.Identity()
    if not joints:
        raise InputError(
            "is missing",
            path="joint",
            mend="Write a [[joint]] table with d, a, alpha and offset for each joint, or name a URDF",
        )
    for number, joint in enumerate(joints):
        path = f"joint[{number}]"
        if unknown := set(joint) - {"name", "reversed", *KEYS}:
            raise InputError(
                "unknown key",
                path=f"{path}.{min(unknown)}",
                allowed=f"name, reversed, {', '.join(KEYS)}",
            )
        values = {key: _value(joint, key, path) for key in KEYS}
        turned = pin.SE3(pin.utils.rotate("z", values["offset"]), np.zeros(3))
        axis = [0.0, 0.0, -1.0 if joint.get("reversed", False) else 1.0]
        parent = model.addJoint(
            parent,
            pin.JointModelRevoluteUnaligned(*axis),
            place * turned,
            str(joint.get("name", f"joint_{number + 1}")),
        )
        density = values["mass"] * PRIOR_DENSITY
        model.addJointFrame(parent)
        model.appendBodyToJoint(
            parent,
            pin.Inertia(values["mass"], np.zeros(3), density * np.eye(3)),
            pin.SE3.Identity(),
        )
        along = pin.SE3(np.eye(3), np.array([values["a"], 0.0, values["d"]]))
        place = along * pin.SE3(pin.utils.rotate("x", values["alpha"]), np.zeros(3))
    return Robot(model)


def _value(joint: Mapping[str, Any], key: str, path: str) -> float:
    if key == "mass":
        return quantity(
            joint.get(key, PRIOR_MASS),
            Variable("mass", "mass of a body", min=0.0),
            "translational",
            path=f"{path}.{key}",
        )
    return quantity(
        joint.get(key, 0.0),
        Variable("length", "Denavit-Hartenberg parameter"),
        KEYS[key],  # type: ignore[arg-type]
        path=f"{path}.{key}",
    )
