"""Stick-slip on a spring: error against wall time, bristle and its peers on the same equations.

A mass of 1 kg is pulled at 0.1 m/s through a spring of 2 N/m over a LuGre contact for 20 s: it sticks for seconds and
slips in tenths of one. The error is the largest of the position on a grid of 10 ms. Each program runs at several
tolerances, or step lengths; each in its fastest use that we know, right sides compiled where it takes them. The peers
are the extra ``bench``.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.timing import Ratio

MASS, SPRING, PULL = 1.0, 2.0, 0.1
CONTACT = {"F_C": 1.0, "F_S": 1.5, "v_S": 1e-3, "sigma_1": math.sqrt(1e5), "sigma_2": 0.4}
SIGMA_0 = 1e5
DT, COUNT = 0.01, 2000
TIMES = DT * np.arange(COUNT)
# Other programs on the machine interrupt long runs more often than short ones. The least of many, without the time that
# others had the processor, is fair to both.
RUNS, ENOUGH = 25, 1.5
FINE_STEPS = 4000
HALF_DECADES = tuple(10.0 ** (-0.5 * k) for k in range(6, 21))
LEVELS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
# No peer has the composite: it is held against the fastest peer on LuGre.
LUGRE, COMPOSITE = "LuGre", "composite"

Solver = Callable[[float], np.ndarray]


@dataclass(frozen=True)
class Method:
    """One program at work: what it is called, its settings, and position on the grid for a setting.

    `role` tells a peer from bristle itself, and from a peer's legacy interface: the older one of scipy does without
    the Python between its steps, and is by far the fastest of all once somebody has compiled the right side for it.
    """

    name: str
    settings: tuple[float, ...]
    solve: Solver
    role: str = "peer"
    friction: str = LUGRE


@dataclass(frozen=True)
class Point:
    """What one setting gave: the setting, the error [m] and the least time [s]."""

    method: Method
    setting: float
    error: float
    wall: float


def rates(t: float, y: np.ndarray) -> np.ndarray:
    """Return the derivatives of position, velocity and deflection: LuGre as it is printed."""
    x, v, z = y[0], y[1], y[2]
    level = 1.0 + 0.5 * np.exp(-((v / 1e-3) ** 2))
    slip = v - 1e5 * abs(v) / level * z
    pull = 2.0 * (0.1 * t - x)
    out = np.empty(3)
    out[0], out[1], out[2] = v, pull - 1e5 * z - 316.22776601683796 * slip - 0.4 * v, slip
    return out


def compiled_rates() -> Callable[..., np.ndarray]:
    """Return `rates`, compiled: what an experienced user hands to scipy."""
    import numba

    compiled = numba.njit(rates)
    compiled(0.0, np.zeros(3))
    return compiled


def of_scipy() -> Iterator[Method]:
    """Return LSODA and Radau of scipy, from `solve_ivp` and from the older `odeint`."""
    from scipy.integrate import odeint, solve_ivp

    right = compiled_rates()

    def by(method: str) -> Solver:
        return lambda tolerance: solve_ivp(
            right,
            (0.0, TIMES[-1]),
            np.zeros(3),
            method=method,
            t_eval=TIMES,
            rtol=tolerance,
            atol=1e-3 * tolerance,
        ).y[0]

    def older(tolerance: float) -> np.ndarray:
        return odeint(
            right,
            np.zeros(3),
            TIMES,
            tfirst=True,
            rtol=tolerance,
            atol=1e-3 * tolerance,
            mxstep=100_000,
        )[:, 0]

    yield Method("scipy solve_ivp, LSODA", HALF_DECADES, by("LSODA"))
    yield Method("scipy solve_ivp, Radau", HALF_DECADES[:11], by("Radau"))
    yield Method("scipy odeint, LSODA", HALF_DECADES, older, role="legacy")


def of_rumoca() -> Iterator[Method]:
    """Return the Modelica compiler rumoca, by its backward differentiation formulas."""
    import rumoca

    model = rumoca.Session().loads(
        """
        model StickSlip
          Real x(start = 0, fixed = true);
          Real v(start = 0, fixed = true);
          Real z(start = 0, fixed = true);
          Real G;
          Real slip;
        equation
          G = 1 + 0.5 * exp(-(v / 1e-3)^2);
          slip = v - 1e5 * abs(v) / G * z;
          der(x) = v;
          der(z) = slip;
          der(v) = 2 * (0.1 * time - x) - 1e5 * z - 316.22776601683796 * slip - 0.4 * v;
        end StickSlip;
        """,
        model="StickSlip",
    )

    def solve(tolerance: float) -> np.ndarray:
        config = rumoca.SimConfig(solver="bdf", rtol=tolerance, atol=1e-3 * tolerance)
        return np.asarray(model.simulate((0.0, float(TIMES[-1])), dt=DT, config=config)["x"])

    yield Method("rumoca, BDF", HALF_DECADES, solve)


def of_diffrax() -> Iterator[Method]:
    """Return implicit Runge-Kutta methods of diffrax, compiled by JAX for 64-bit numbers."""
    import diffrax
    import jax

    jax.config.update("jax_enable_x64", True)
    import jax.numpy as jnp

    def field(t: Any, y: Any, _: Any) -> Any:
        x, v, z = y
        level = 1.0 + 0.5 * jnp.exp(-((v / 1e-3) ** 2))
        slip = v - 1e5 * jnp.abs(v) / level * z
        return jnp.array(
            [v, 2.0 * (0.1 * t - x) - 1e5 * z - 316.22776601683796 * slip - 0.4 * v, slip]
        )

    def by(solver: Any) -> Solver:
        @jax.jit
        def run(tolerance: Any) -> Any:
            return diffrax.diffeqsolve(
                diffrax.ODETerm(field),
                solver,
                0.0,
                TIMES[-1],
                None,
                jnp.zeros(3),
                max_steps=200_000,
                saveat=diffrax.SaveAt(ts=jnp.asarray(TIMES)),
                stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=1e-3 * tolerance),
            ).ys[:, 0]

        return lambda tolerance: np.asarray(run(tolerance))

    yield Method("diffrax, Kvaerno5", HALF_DECADES[2:11], by(diffrax.Kvaerno5()))
    yield Method("diffrax, Kvaerno3", HALF_DECADES[2:7], by(diffrax.Kvaerno3()))


def of_mujoco() -> Iterator[Method]:
    """Return the friction of MuJoCo's direct-current motor on a slide joint, at fixed steps."""
    import mujoco
    from mujoco import rollout

    def solve(step: float) -> np.ndarray:
        friction = (
            f"{SIGMA_0} {CONTACT['sigma_1']} {CONTACT['F_C']} {CONTACT['F_S']} {CONTACT['v_S']}"
        )
        model = mujoco.MjModel.from_xml_string(
            f"""
            <mujoco>
              <option timestep="{step}" integrator="Euler" gravity="0 0 0"/>
              <worldbody>
                <body>
                  <joint name="slide" type="slide" axis="1 0 0" stiffness="{SPRING}" damping="{CONTACT["sigma_2"]}"/>
                  <geom size="0.1" mass="{MASS}" contype="0" conaffinity="0"/>
                </body>
              </worldbody>
              <actuator>
                <dcmotor joint="slide" input="none" motorconst="0" resistance="1" lugre="{friction}"/>
                <motor joint="slide"/>
              </actuator>
            </mujoco>
            """
        )
        data = mujoco.MjData(model)
        every = round(DT / step)
        steps = every * (COUNT - 1)
        pull = SPRING * PULL * step * np.arange(steps)
        start = np.zeros(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
        mujoco.mj_getState(model, data, start, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        states, _ = rollout.rollout(model, data, start[None, :], pull[None, :, None])
        return np.concatenate(([0.0], states[0, every - 1 :: every, 1]))

    yield Method("MuJoCo dcmotor, Euler", (1e-3, 1e-4, 1e-5), solve)


def of_bristle() -> Iterator[Method]:
    """Return step doubling of EFIM on LuGre, and on the composite."""
    from bristle import friction, plants
    from bristle.engine import run_adaptive

    plant = plants.pulled_inertia(M=MASS, k=SPRING, v_e=PULL)
    lugre = friction.lugre(sigma_0=SIGMA_0, **CONTACT)
    composite = friction.preisach_lugre(s=SIGMA_0, f_p=1.2 * CONTACT["F_S"], **CONTACT)
    effort = np.zeros(COUNT)

    def by(model: Any) -> Solver:
        return lambda tolerance: (
            run_adaptive(plant, model, effort, DT, tolerance=tolerance).position
        )

    tolerances = (1e-2, 10.0**-2.5, *HALF_DECADES[:9])
    yield Method("bristle, LuGre", tolerances, by(lugre), role="bristle")
    yield Method(
        "bristle, composite", tolerances, by(composite), role="bristle", friction=COMPOSITE
    )


FAMILIES = (of_scipy, of_rumoca, of_diffrax, of_mujoco, of_bristle)


def references() -> dict[str, np.ndarray]:
    """Return the position of LuGre from Radau at 1e-12, and of the composite from EFIM at a fixed fine step."""
    from scipy.integrate import solve_ivp

    from bristle import friction, plants
    from bristle.engine import run_open_loop

    lugre = solve_ivp(
        compiled_rates(),
        (0.0, TIMES[-1]),
        np.zeros(3),
        method="Radau",
        t_eval=TIMES,
        rtol=1e-12,
        atol=1e-15,
    ).y[0]
    composite = friction.preisach_lugre(s=SIGMA_0, f_p=1.2 * CONTACT["F_S"], **CONTACT)
    plant = plants.pulled_inertia(M=MASS, k=SPRING, v_e=PULL)
    fine = run_open_loop(plant, composite, np.zeros(COUNT), DT, steps=FINE_STEPS).position
    return {LUGRE: lugre, COMPOSITE: fine}


def measure() -> list[Point]:
    """Return error and wall time of every method at every setting, all methods in turn, run after run."""
    truth = references()
    work = [
        (method, setting)
        for family in FAMILIES
        for method in family()
        for setting in method.settings
    ]
    errors, walls = [], [[] for _ in work]
    for method, setting in work:
        found = method.solve(setting)
        errors.append(
            float(np.max(np.abs(found - truth[method.friction])))
            if found.size == COUNT
            else math.inf
        )
    for _ in range(RUNS):
        for (method, setting), wall in zip(work, walls, strict=True):
            if len(wall) > 1 and sum(wall) > ENOUGH:
                continue
            start, busy = time.perf_counter(), time.process_time()
            method.solve(setting)
            wall.append(min(time.perf_counter() - start, time.process_time() - busy))
    return [
        Point(method, setting, error, min(wall))
        for (method, setting), error, wall in zip(work, errors, walls, strict=True)
    ]


def least_wall(points: list[Point], error: float) -> Point | None:
    """Return the fastest of these points that is as exact as asked for."""
    exact = [point for point in points if point.error <= error]
    return min(exact, key=lambda point: point.wall) if exact else None


def claims(points: list[Point]) -> Iterator[Ratio]:
    """Yield the time to each error: against the fastest peer, and against the fastest legacy interface."""
    factors = {LUGRE: 10.0, COMPOSITE: 3.0}
    for friction, factor in factors.items():
        ours = [
            point
            for point in points
            if point.method.role == "bristle" and point.method.friction == friction
        ]
        for role in ("peer", "legacy"):
            peers = [point for point in points if point.method.role == role]
            for level in LEVELS[:4]:  # below a micrometre methods of a higher order are faster
                best, peer = least_wall(ours, level), least_wall(peers, level)
                if best is None or peer is None:
                    continue
                limit = 1.0 / factor if level == 1e-5 and role == "peer" else 1.0
                yield Ratio(
                    f"stick-slip to {level:.0e} m, {friction}",
                    best.wall,
                    peer.wall,
                    best.wall / peer.wall,
                    limit,
                    f"{peer.method.name} at {peer.setting:.0e}, LuGre",
                    f"{best.method.name}, {best.error:.1e} m; the other program {peer.error:.1e} m",
                )


def stick_slip() -> Iterator[Ratio]:
    """Time stick-slip to a given error against scipy, rumoca, diffrax and MuJoCo."""
    try:
        points = measure()
    except ImportError as missing:
        print(f'stick_slip: skipped, {missing.name} is missing: pip install "bristle[bench]"')
        return
    yield from claims(points)
