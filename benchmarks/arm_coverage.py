"""Coverage of the intervals of base parameters: ``python -m benchmarks.arm_coverage [ARMS]``. Simulated arms with six joints.

Pinocchio computes the efforts of random bodies along random motions. The friction of each joint is LuGre with random values;
the angles have an encoder step, the efforts noise.
"""

from __future__ import annotations

import sys

import numpy as np

from bristle import friction
from bristle.apps.arm.motion import BANDWIDTH, motion_of
from bristle.apps.arm.parameters import identify_dynamics, names_of
from bristle.apps.arm.robot import Robot, chain_of
from bristle.engine.motion import along
from bristle.logs import Log

DT, SECONDS, STEP = 0.002, 90.0, 2e-6  # [s], [s], encoder step [rad]
GEOMETRY = (
    (0.4, 0.1, -90),
    (0.0, 0.5, 0),
    (0.0, 0.05, -90),
    (0.4, 0.0, 90),
    (0.0, 0.0, -90),
    (0.1, 0.0, 0),
)
MASSES = (20.0, 15.0, 10.0, 4.0, 3.0, 1.5)


def robot() -> Robot:
    """Return an arm with a spherical wrist."""
    entries = zip(GEOMETRY, MASSES, strict=True)
    return chain_of(
        [{"d": d, "a": a, "alpha": f"{alpha} deg", "mass": mass} for (d, a, alpha), mass in entries]
    )


def bodies_of(rng: np.random.Generator) -> np.ndarray:
    """Return random bodies of positive mass, shape (body, 10)."""
    rows = []
    for mass in MASSES:
        points, parts = (
            rng.normal(0.0, 0.12, (8, 3)) + rng.normal(0.0, 0.08, 3),
            mass * rng.dirichlet(np.ones(8)),
        )
        about = sum(
            part * (point @ point * np.eye(3) - np.outer(point, point))
            for part, point in zip(parts, points, strict=True)
        )
        moments = parts @ points
        rows.append(
            [
                mass,
                *moments,
                about[0, 0],
                about[0, 1],
                about[1, 1],
                about[0, 2],
                about[1, 2],
                about[2, 2],
            ]
        )
    return np.array(rows)


def motion(rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Return time and angles, speeds and accelerations of all joints, (sample, joint) each: sums of seven waves."""
    t = np.arange(0.0, SECONDS, DT)
    q, v, a = np.zeros((3, t.size, 6))
    for joint in range(6):
        for frequency in rng.uniform(0.05, 0.9, 7):
            size, phase, w = (
                rng.uniform(0.1, 0.4),
                rng.uniform(0.0, 2.0 * np.pi),
                2.0 * np.pi * frequency,
            )
            q[:, joint] += size * np.sin(w * t + phase)
            v[:, joint] += size * w * np.cos(w * t + phase)
            a[:, joint] -= size * w**2 * np.sin(w * t + phase)
    return t, q, v, a


def covered(arm: Robot, seed: int) -> list[bool]:
    """Return whether the interval of each base parameter of a random arm contains its true value."""
    rng = np.random.default_rng(seed)
    bodies, rotors = bodies_of(rng), rng.uniform(0.05, 0.6, 6)
    t, q, v, a = motion(rng)
    effort = arm.effort(bodies, q, v, a) + rotors * a
    for joint, level in enumerate(
        np.array([20.0, 20.0, 12.0, 5.0, 4.0, 2.0]) * rng.uniform(0.5, 1.5, 6)
    ):
        values = {
            "F_C": level,
            "F_S": level * rng.uniform(1.0, 1.6),
            "v_S": rng.uniform(0.01, 0.1),
            "sigma_2": level * rng.uniform(0.1, 0.8),
        }
        law = friction.lugre(**values, sigma_0=level / rng.uniform(1e-4, 2e-3), sigma_1=0.0)
        speed = np.ascontiguousarray(v[:, joint])
        effort[:, joint] += along(
            law, dt=DT, v=speed, x=np.ascontiguousarray(q[:, joint] + 0.5 * DT * speed)
        )
    effort += rng.normal(size=effort.shape) * 0.02 * np.std(effort, axis=0)
    measured = STEP * np.round(q / STEP)
    logs = [
        Log.from_columns(
            {"time": t, "position": measured[:, joint], "effort": effort[:, joint]},
            kind="rotational",
        )
        for joint in range(6)
    ]
    true = dict(zip(names_of(arm.names), [*rotors.tolist(), *bodies.ravel().tolist()], strict=True))
    base = identify_dynamics(arm, motion_of(logs, arm.names)).base
    return [
        abs(entry.value - sum(factor * true[name] for name, factor in entry.members))
        <= entry.half_width
        for entry in base
    ]


def main() -> int:
    """Print the coverage; return 1 if it is not between 92 and 98 %."""
    arm, count = robot(), int(sys.argv[1]) if len(sys.argv) > 1 else 10
    inside = [within for seed in range(count) for within in covered(arm, seed)]
    share = 100.0 * sum(inside) / len(inside)
    print(
        f"{share:.1f} % of {len(inside)} intervals of base parameters of {count} arms contain the true value (92 to 98 %; {BANDWIDTH:g} Hz)"
    )
    return int(not 92.0 <= share <= 98.0)


if __name__ == "__main__":
    sys.exit(main())
