"""Compare how simulators stick and creep: ``python -m benchmarks.sticking [--json FILE]``.

Each simulator runs four cases with known solutions, at the same step:

- A block rests on a slope. Its weight pulls with 0.8 of the largest friction force. Result: creep [m/s] over 10 s,
  without the first second.
- An axis with Coulomb friction F_C rests under a force of 0.8 F_C. Result: creep [m/s], as above.
- An axis of 1 kg slides from 1 m/s against 1 N, and stops after 1 s and 0.5 m. Result: errors of position and velocity
  at 5 s.
- A spring pulls an axis from rest. The end of the spring moves at v. The axis breaks away at F_C/(k v) and then moves by
  x = v t - (v/w) sin(w t), w^2 = k/M. Result: the largest error over three periods.
"""

from __future__ import annotations

import argparse
import importlib
import json
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["Answers", "answers"]

DT, LASTS, LEFT_OUT = 1e-3, 10.0, 1.0
GRAVITY, MU, SHARE = 9.81, 0.5, 0.8
F_C, M, V_0, K, V_END = 1.0, 1.0, 1.0, 100.0, 0.01
STOPPED = 5.0
W = math.sqrt(K / M)
BREAKS_AWAY = F_C / (K * V_END)
PULLED = BREAKS_AWAY + 3.0 * 2.0 * math.pi / W
SLOPE = math.atan(SHARE * MU)


@dataclass(frozen=True)
class Answers:
    """What a simulator answers; NaN where it has nothing of the kind.

    Parameters
    ----------
    simulator, setting : str
        Which, with its version, and how it was set.
    slope, axis : float
        Creep of the block and of the axis [m/s].
    stop, still : float
        How far from where it should have stopped [m], and how fast it moves there [m/s].
    pulled : float
        Largest error of the pulled axis [m].
    step : float
        Time of a step of the axis [s].
    """

    simulator: str
    setting: str
    slope: float = math.nan
    axis: float = math.nan
    stop: float = math.nan
    still: float = math.nan
    pulled: float = math.nan
    step: float = math.nan


Force = Callable[[float, float], float]  # of the time and the position
Moved = tuple[np.ndarray, np.ndarray]  # position and velocity at each step
Run = Callable[[Force, float, float], Moved]  # force, velocity at first, how long: x, v


def spring(t: float, x: float) -> float:
    """Return what the spring pulls with."""
    return K * (V_END * t - x)


def exact(t: np.ndarray) -> np.ndarray:
    """Return where the pulled axis is."""
    later = np.maximum(t - BREAKS_AWAY, 0.0)
    return V_END * later - V_END / W * np.sin(W * later)


def creep(x: np.ndarray) -> float:
    """Return how fast a position at each step changes on the whole, once it has settled."""
    return abs(float(x[-1] - x[round(LEFT_OUT / DT)])) / (LASTS - LEFT_OUT)


def asked(run: Run) -> dict[str, float]:
    """Put the three questions of an axis."""
    held, _ = run(lambda t, x: SHARE * F_C, 0.0, LASTS)
    begin = time.perf_counter()
    slid, speed = run(lambda t, x: 0.0, V_0, STOPPED)
    seconds = time.perf_counter() - begin
    drawn, _ = run(spring, 0.0, PULLED)
    return {
        "axis": creep(held),
        "stop": abs(float(slid[-1]) - 0.5 * M * V_0**2 / F_C),
        "still": abs(float(speed[-1])),
        "pulled": float(np.max(np.abs(drawn - exact(DT * np.arange(drawn.size))))),
        "step": seconds * DT / STOPPED,
    }


def ours() -> Iterator[Answers]:
    """Ask bristle, of friction that is a force and of friction that is a contact."""
    import bristle as br
    from bristle.engine import run_open_loop
    from bristle.models.plants import inertia, pulled_inertia

    normal = GRAVITY * math.cos(SLOPE)
    models = {
        "coulomb": lambda level: br.friction.coulomb(F_C=level),
        "lugre": lambda level: br.friction.lugre(
            F_C=level, F_S=level, v_S=1e-3, sigma_0=1e5, sigma_1=10.0
        ),
        "preisach_lugre": lambda level: br.friction.preisach_lugre(
            kernel="dahl_masing",
            s=1e5,
            f_p=1.2 * level,
            F_C=level,
            F_S=level,
            v_S=1e-3,
            sigma_1=10.0,
        ),
    }
    for name, of in models.items():
        held = of(F_C)

        def run(force: Force, v: float, lasts: float, model: Any = held) -> Moved:
            count = round(lasts / DT) + 1
            if force is spring:
                made = run_open_loop(
                    pulled_inertia(M=M, k=K, v_e=V_END), model, np.zeros(count), DT
                )
            else:
                made = run_open_loop(inertia(M=M), model, np.full(count, force(0.0, 0.0)), DT, v=v)
            return made.position, made.velocity

        run(lambda t, x: 0.0, 0.0, 0.1)
        weight = np.full(round(LASTS / DT) + 1, GRAVITY * math.sin(SLOPE))
        block = run_open_loop(inertia(M=1.0), of(MU * normal), weight, DT)
        yield Answers(f"bristle {br.__version__}", name, slope=creep(block.position), **asked(run))


def mujoco() -> Iterator[Answers]:
    """Ask MuJoCo: a box on a plane, a joint with frictionloss, both in several settings, and a joint with a tendon that slips."""
    library = importlib.import_module("mujoco")
    settings = {
        "as it comes": "",
        "elliptic cones, impratio 10": '<option cone="elliptic" impratio="10"/>',
        "noslip_iterations 20": '<option noslip_iterations="20"/>',
        "implicitfast": '<option integrator="implicitfast"/>',
    }

    def stepped(text: str, v: float, lasts: float, force: Force) -> Moved:
        model = library.MjModel.from_xml_string(text)
        data = library.MjData(model)
        data.qvel[0] = v
        x, speed = np.empty(round(lasts / DT) + 1), np.empty(round(lasts / DT) + 1)
        for k in range(x.size):
            x[k], speed[k] = data.qpos[0], data.qvel[0]
            data.qfrc_applied[0] = force(k * DT, x[k])
            library.mj_step(model, data)
        return x, speed

    for name, option in settings.items():

        def moved(body: str, v: float, lasts: float, force: Force, option: str = option) -> Moved:
            gravity = f"{GRAVITY * math.sin(SLOPE)} 0 {-GRAVITY * math.cos(SLOPE)}"
            options = f'<option timestep="{DT}" gravity="{gravity}"/>{option}'
            text = f"<mujoco>{options}<worldbody>{body}</worldbody></mujoco>"
            return stepped(text, v, lasts, force)

        box = (
            f'<geom type="plane" size="50 50 1" friction="{MU}"/><body pos="0 0 0.05"><freejoint/>'
            f'<geom type="box" size="0.1 0.1 0.05" mass="1" friction="{MU}"/></body>'
        )
        joint = (
            f'<body gravcomp="1"><joint type="slide" axis="1 0 0" frictionloss="{F_C}"/>'
            f'<geom type="sphere" size="0.1" mass="{M}"/></body>'
        )

        def run(force: Force, v: float, lasts: float, moved=moved, joint: str = joint) -> Moved:
            return moved(joint, v, lasts, force)

        slope = creep(moved(box, 0.0, LASTS, lambda t, x: 0.0)[0])
        yield Answers(f"MuJoCo {library.__version__}", name, slope=slope, **asked(run))

    stiffness = 0.1 * M / DT**2
    tendon = f'<fixed stiffness="{stiffness}" springlength="0" springyield="{F_C / stiffness}"><joint joint="x" coef="1"/></fixed>'
    body = f'<body><joint name="x" type="slide" axis="1 0 0"/><geom type="sphere" size="0.1" mass="{M}"/></body>'
    text = f'<mujoco><option timestep="{DT}" gravity="0 0 0"/><worldbody>{body}</worldbody><tendon>{tendon}</tendon></mujoco>'
    asked_of_tendon = asked(lambda force, v, lasts: stepped(text, v, lasts, force))
    yield Answers(f"MuJoCo {library.__version__}", "tendon with springyield", **asked_of_tendon)


def drake() -> Iterator[Answers]:
    """Ask Drake: a box on a half-space, with each of its discrete contact solvers; its joints have no friction."""
    library = importlib.import_module("pydrake.all")
    version = importlib.import_module("importlib.metadata").version("drake")
    for name, kind in {"SAP": "kSap", "TAMSI": "kTamsi", "similar": "kSimilar"}.items():
        builder = library.DiagramBuilder()
        plant, _ = library.AddMultibodyPlantSceneGraph(builder, DT)
        plant.set_discrete_contact_approximation(
            getattr(library.DiscreteContactApproximation, kind)
        )
        inertia = library.SpatialInertia.SolidBoxWithMass(1.0, 0.2, 0.2, 0.1)
        body = plant.AddRigidBody("block", inertia)
        friction = library.CoulombFriction(MU, MU)
        plant.RegisterCollisionGeometry(
            plant.world_body(), library.RigidTransform(), library.HalfSpace(), "ground", friction
        )
        plant.RegisterCollisionGeometry(
            body, library.RigidTransform(), library.Box(0.2, 0.2, 0.1), "box", friction
        )
        gravity = np.array([math.sin(SLOPE), 0.0, -math.cos(SLOPE)])
        plant.mutable_gravity_field().set_gravity_vector(GRAVITY * gravity)
        plant.Finalize()
        diagram = builder.Build()
        simulator = library.Simulator(diagram)
        context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
        plant.SetFreeBodyPose(context, body, library.RigidTransform([0.0, 0.0, 0.05]))
        simulator.AdvanceTo(LEFT_OUT)
        before = plant.EvalBodyPoseInWorld(context, body).translation()[0]
        simulator.AdvanceTo(LASTS)
        after = plant.EvalBodyPoseInWorld(context, body).translation()[0]
        yield Answers(f"Drake {version}", name, slope=abs(after - before) / (LASTS - LEFT_OUT))


def bullet() -> Iterator[Answers]:
    """Ask Bullet: a box on a plane."""
    library = importlib.import_module("pybullet")
    version = importlib.import_module("importlib.metadata").version("pybullet")
    client = library.connect(library.DIRECT)
    library.setGravity(GRAVITY * math.sin(SLOPE), 0.0, -GRAVITY * math.cos(SLOPE))
    library.setTimeStep(DT)
    ground = library.createMultiBody(0.0, library.createCollisionShape(library.GEOM_PLANE))
    half = [0.1, 0.1, 0.05]
    block = library.createMultiBody(
        1.0,
        library.createCollisionShape(library.GEOM_BOX, halfExtents=half),
        basePosition=[0, 0, 0.05],
    )
    for body in (ground, block):
        library.changeDynamics(body, -1, lateralFriction=math.sqrt(MU))  # it multiplies the two
    library.changeDynamics(block, -1, activationState=library.ACTIVATION_STATE_DISABLE_SLEEPING)
    x = np.empty(round(LASTS / DT) + 1)
    for k in range(x.size):
        x[k] = library.getBasePositionAndOrientation(block)[0][0]
        library.stepSimulation()
    library.disconnect(client)
    yield Answers(f"Bullet {version}", "as it comes, no sleeping", slope=creep(x))


def answers() -> list[Answers]:
    """Ask whoever is installed, ours first."""
    found = list(ours())
    for one in (mujoco, drake, bullet):
        try:
            found += one()
        except ModuleNotFoundError as missing:
            print(f"skipped: {missing.name} is not installed")
    return found


def main() -> None:
    """Ask, and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", type=Path, help="also write the results into this file")
    given = parser.parse_args()
    found = answers()
    for one in found:
        told = {
            name: value
            for name, value in asdict(one).items()
            if isinstance(value, float) and not math.isnan(value)
        }
        print(
            f"{one.simulator}, {one.setting}:",
            ", ".join(f"{name} {value:.1e}" for name, value in told.items()),
        )
    if given.json:
        given.json.write_text(
            json.dumps([asdict(one) for one in found], indent=1) + "\n", encoding="utf-8"
        )


if __name__ == "__main__":
    main()
