r"""Dynamic parameters of an arm from the efforts of all joints: base parameters with intervals, and the nearest real bodies.

.. math:: \tau_i = Y_i(q, \dot q, \ddot q)\,\pi + J_i \ddot q_i + F_i \beta_i

with the inertia of each rotor :math:`J_i` and columns :math:`F_i` that span the friction of a joint. All joints share
:math:`\pi`. Only base parameters, certain sums of :math:`\pi`, have an effect on the efforts [1]_. Bodies of positive mass
follow from a Cholesky factor of the second moments of their mass [2]_.

References
----------
.. [1] M. Gautier, W. Khalil, "Direct calculation of minimum set of inertial parameters of serial robots", IEEE Trans.
   Robotics and Automation 6(3), 1990. doi:10.1109/70.56655
.. [2] C. Rucker, P. M. Wensing, "Smooth parameterization of rigid-body inertia", IEEE Robotics and Automation Letters
   7(2), 2022. doi:10.1109/LRA.2022.3144517
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.apps.arm.motion import Motion, cable
from bristle.apps.arm.robot import OF_BODY, Robot, pseudo_inertia
from bristle.core import apart_from, unbounded

ALIKE = 1e-8  # relative size of the part of a column that earlier columns do not explain
POSES, SEED = 100, 1  # random poses that decide which parameters have an effect
BLOCKS, BLOCKS_IN_PERIOD = 40, 20  # of time, whose residuals are independent
WEIGHTINGS = 3  # passes with weights by the residual of each joint
SEARCH = 100  # evaluations
ROTOR_SHARE = 0.5  # of the sum of rotor and body, at first
TO_PRIOR = 1e-2  # weight of the bodies in the file, against the residual of one row
ROTOR = "J"
SPRING_GAIN = 0.1  # fall of the held-out error of a joint: a smaller gain can come from wrong bodies or friction


@dataclass(frozen=True)
class BaseParameter:
    """A sum of dynamic parameters: its name, members with factors, estimate and half-width of its 95 % interval [SI]."""

    name: str
    members: tuple[tuple[str, float], ...]
    value: float
    half_width: float


@dataclass(frozen=True)
class Dynamics:
    """Estimates of an arm: base parameters, parameters of real bodies (body, 10), rotor inertias, and the relative errors."""

    base: tuple[BaseParameter, ...]
    bodies: np.ndarray
    rotors: np.ndarray
    errors: np.ndarray
    """Root mean square of the residual over that of the effort of each joint, with `bodies` and any friction in the columns."""

    @property
    def rotors_in_sums(self) -> frozenset[str]:
        """The joints whose rotor inertia is only determined in a sum with parameters of bodies."""
        rotors = (entry for entry in self.base if entry.name.endswith(f".{ROTOR}"))
        return frozenset(
            entry.name.removesuffix(f".{ROTOR}") for entry in rotors if len(entry.members) > 1
        )


def names_of(joints: Sequence[str]) -> list[str]:
    """Return the names of the dynamic parameters: rotors first, then the bodies."""
    return [f"{joint}.{ROTOR}" for joint in joints] + [
        f"{joint}.{name}" for joint in joints for name in OF_BODY
    ]


def base_of(robot: Robot) -> tuple[list[int], np.ndarray]:
    """Return the parameters with independent effects in any motion, and the factors of all parameters in their sums, (base, all)."""
    count = len(robot.names)
    q, v, a = np.random.default_rng(SEED).uniform(-np.pi, np.pi, (3, POSES, count))
    columns = with_rotors(robot.regressor(q, v, a), a).reshape(POSES * count, -1)
    # Each column in turn either adds a direction or is a sum of earlier columns: outer masses move into inner inertias.
    order = [
        *range(count),
        *(count + 10 * body + k for body in range(count) for k in (*range(4, 10), 1, 2, 3, 0)),
    ]
    upper = np.asarray(np.linalg.qr(columns[:, order], mode="r"))
    independent = np.flatnonzero(np.abs(np.diag(upper)) > ALIKE * np.abs(upper).max()).tolist()
    factors = np.zeros((len(independent), len(order)))
    factors[:, order] = unbounded(upper[:, independent], upper)
    factors[np.abs(factors) < ALIKE**0.5] = 0.0
    return [order[place] for place in independent], factors


def with_rotors(columns: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """Return the columns (row, joint, parameter) with those of the rotors before them."""
    return np.concatenate(
        [acceleration[..., None] * np.eye(acceleration.shape[1]), columns], axis=2
    )


def identify_dynamics(robot: Robot, motion: Motion) -> Dynamics:
    """Return the dynamic parameters that explain the efforts of all joints, besides any friction of each joint."""
    q, v, a, effort = (
        signal[motion.rows]
        for signal in (motion.position, motion.velocity, motion.acceleration, motion.effort)
    )
    columns = with_rotors(robot.regressor(q, v, a), a)
    places, factors = base_of(robot)
    dynamic, left, frictions = np.empty_like(columns), np.empty_like(effort), list[np.ndarray]()
    # With the same sums of squares.
    reduced = np.empty((len(robot.names), columns.shape[2] + 1, columns.shape[2] + 1))
    for joint in range(len(robot.names)):
        friction = np.linalg.qr(motion.friction_columns(joint))[0]
        frictions.append(friction)
        dynamic[:, joint], left[:, joint] = (
            apart_from(friction, columns[:, joint]),
            apart_from(friction, effort[:, joint]),
        )
        reduced[joint] = np.linalg.qr(
            np.column_stack([dynamic[:, joint], left[:, joint]]), mode="r"
        )
    design, target, deviation = (
        reduced[..., :-1],
        reduced[..., -1],
        np.sqrt(np.mean(left**2, axis=0)),
    )
    base = np.zeros(len(places))
    for _ in range(WEIGHTINGS):
        weighted, right_side = (
            design[..., places] / deviation[:, None, None],
            target / deviation[:, None],
        )
        base = _least_squares(weighted.reshape(-1, len(places)), right_side.ravel())
        deviation = np.linalg.norm(target - design[..., places] @ base, axis=1) / np.sqrt(len(q))
    residual = (left - dynamic[..., places] @ base) / deviation
    half_widths = _half_widths(
        dynamic[..., places] / deviation[:, None], residual, frictions, _blocks(motion)
    )
    # The base parameters of rotors come first.
    start = np.maximum(ROTOR_SHARE * base[: len(deviation)], 1e-3 * np.abs(base[: len(deviation)]))
    bodies, rotors = _consistent(
        start, robot.prior, design / deviation[:, None, None], target / deviation[:, None], len(q)
    )
    residual = target - design @ np.concatenate([rotors, bodies.ravel()])
    names = names_of(robot.names)
    described = [
        BaseParameter(
            names[place],
            tuple((names[k], float(row[k])) for k in np.flatnonzero(row)),
            float(value),
            float(half),
        )
        for place, row, value, half in zip(places, factors, base, half_widths, strict=True)
    ]
    return Dynamics(
        tuple(described),
        bodies,
        rotors,
        np.linalg.norm(residual, axis=1) / np.linalg.norm(effort, axis=0),
    )


def joints_with_springs(robot: Robot, motion: Motion) -> list[str]:
    """Return the joints whose effort shows a spring or a cable: it lowers the held-out error beside any bodies and friction."""
    q, v, a, effort = (
        signal[motion.rows]
        for signal in (motion.position, motion.velocity, motion.acceleration, motion.effort)
    )
    columns, blocks = (
        with_rotors(robot.regressor(q, v, a), a)[..., base_of(robot)[0]],
        _blocks(motion),
    )
    pulled = list[str]()
    for joint, name in enumerate(robot.names):
        free = np.hstack([motion.friction_columns(joint), columns[:, joint]])
        tried = np.hstack([free, cable(q[:, joint]).T])
        basis, upper = np.linalg.qr(tried / (np.linalg.norm(tried, axis=0) + np.finfo(float).tiny))
        independent = np.abs(np.diag(upper)) > ALIKE**0.5
        without, beside = (
            basis[:, : free.shape[1]][:, independent[: free.shape[1]]],
            basis[:, independent],
        )
        if _held_out(beside, effort[:, joint], blocks) < (1.0 - SPRING_GAIN) * _held_out(
            without, effort[:, joint], blocks
        ):
            pulled.append(name)
    return pulled


def _held_out(basis: np.ndarray, effort: np.ndarray, blocks: Sequence[np.ndarray]) -> float:
    """Return the norm of the residuals of each block with the coefficients of all other blocks, for orthonormal columns."""
    residual, left = effort - basis @ (basis.T @ effort), list[np.ndarray]()
    for rows in blocks:
        part = basis[rows]
        inverse = np.linalg.pinv(np.eye(part.shape[1]) - part.T @ part, rcond=1e-10, hermitian=True)
        left.append(residual[rows] + part @ (inverse @ (part.T @ residual[rows])))
    return float(np.linalg.norm(np.concatenate(left)))


def _least_squares(columns: np.ndarray, right_side: np.ndarray) -> np.ndarray:
    scale = np.linalg.norm(columns, axis=0)
    return unbounded(columns / scale, right_side, rcond=1e-10) / scale


def _half_widths(
    columns: np.ndarray,
    residual: np.ndarray,
    frictions: Sequence[np.ndarray],
    blocks: Sequence[np.ndarray],
) -> np.ndarray:
    """Return half-widths of 95 % intervals: the scatter of the estimates if one block of rows at a time is left out.

    Columns and residual are apart from the orthonormal columns `frictions` of each joint, whose coefficients also change.
    """
    from scipy.stats import t

    scale, count = np.linalg.norm(columns, axis=(0, 1)), len(blocks)
    columns, changes = columns / scale, np.empty((count, columns.shape[2]))
    gram = np.einsum("nji,njk->ik", columns, columns)
    for rows, change in zip(blocks, changes, strict=True):
        left, score = gram.copy(), np.zeros(len(gram))
        for joint, friction in enumerate(frictions):
            part, basis = columns[rows, joint], friction[rows]
            lost = np.linalg.pinv(
                np.eye(basis.shape[1]) - basis.T @ basis, rcond=1e-10, hermitian=True
            )
            freed = part + basis @ (lost @ (basis.T @ part))
            left -= freed.T @ part
            score += freed.T @ residual[rows, joint]
        change[:] = np.linalg.pinv(left, rcond=1e-14, hermitian=True) @ score
    return np.asarray(
        t.ppf(0.975, count - 1) * np.sqrt((count - 1) / count * np.sum(changes**2, axis=0)) / scale
    )


def _blocks(motion: Motion) -> list[np.ndarray]:
    """Return the rows of each block of time; equal phases of a motion that repeats are one block, because errors of a model repeat too."""
    time = motion.time[motion.rows]
    elapsed, count = time - time[0], min(BLOCKS, len(time) // 2)
    if (period := motion.period) is not None:
        elapsed, count = elapsed % period, min(BLOCKS_IN_PERIOD, count)
    number = np.minimum((count * elapsed / (period or elapsed[-1])).astype(int), count - 1)
    rows = [np.flatnonzero(number == block) for block in range(count)]
    return [block for block in rows if block.size]


def _consistent(
    rotors: np.ndarray, prior: np.ndarray, design: np.ndarray, target: np.ndarray, rows: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return bodies and rotors of positive mass that explain the efforts best, near the bodies of the file where these are free."""
    from scipy.optimize import least_squares

    count, weight = len(prior), TO_PRIOR * np.sqrt(rows * len(prior))
    upper = np.asarray(
        np.linalg.qr(np.column_stack([design.reshape(-1, 11 * count), target.ravel()]), mode="r")
    )
    design, target = upper[:-1, :-1], upper[:-1, -1]
    begin = np.concatenate([np.log(rotors), *map(_factor_of, prior)])

    def residual(theta: np.ndarray) -> np.ndarray:
        return np.concatenate(
            [design @ _parameters(theta, count) - target, weight * (theta - begin)]
        )

    def slope(theta: np.ndarray) -> np.ndarray:
        inner = np.zeros((11 * count, 11 * count))
        inner[:count, :count] = np.diag(np.exp(theta[:count]))
        for body in range(count):
            place = slice(count + 10 * body, count + 10 * (body + 1))
            inner[place, place] = _slope_of_body(theta[place])
        return np.vstack([design @ inner, weight * np.eye(len(theta))])

    search: Any = least_squares
    values = _parameters(
        search(residual, begin, jac=slope, x_scale="jac", max_nfev=SEARCH).x, count
    )
    return values[count:].reshape(count, 10), values[:count]


_UPPER = np.triu_indices(4)


def _factor_of(row: np.ndarray) -> np.ndarray:
    """Return the entries of the upper factor U of the second moments U U' of a body, with logarithms on the diagonal."""
    flip = np.eye(4)[::-1]
    factor = flip @ np.linalg.cholesky(flip @ pseudo_inertia(row) @ flip) @ flip
    np.fill_diagonal(factor, np.log(np.diag(factor)))
    return np.asarray(factor[_UPPER])


def _upper(entries: np.ndarray) -> np.ndarray:
    factor = np.zeros((4, 4))
    factor[_UPPER] = entries
    np.fill_diagonal(factor, np.exp(np.diag(factor)))
    return factor


def _rows_of(moments: np.ndarray) -> np.ndarray:
    """Return the dynamic parameters of bodies with these second moments, or of changes, (..., 10); reverses `pseudo_inertia`."""
    about = (
        np.trace(moments[..., :3, :3], axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
        - moments[..., :3, :3]
    )
    inner = [about[..., i, j] for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))]
    return np.stack([moments[..., 3, 3], *np.moveaxis(moments[..., :3, 3], -1, 0), *inner], axis=-1)


def _slope_of_body(entries: np.ndarray) -> np.ndarray:
    factor = _upper(entries)
    changes = np.zeros((10, 4, 4))
    for change, i, j in zip(changes, *_UPPER, strict=True):
        change[i] = (factor[i, i] if i == j else 1.0) * factor[:, j]
    return _rows_of(changes + changes.transpose(0, 2, 1)).T


def _parameters(theta: np.ndarray, count: int) -> np.ndarray:
    factors = map(_upper, theta[count:].reshape(count, 10))
    return np.concatenate(
        [np.exp(theta[:count]), *(_rows_of(factor @ factor.T) for factor in factors)]
    )
