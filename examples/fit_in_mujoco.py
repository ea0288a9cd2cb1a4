"""Fit the friction of a pendulum through a simulation in MuJoCo, by exact derivatives of the friction and by differences.

Needs MuJoCo and JAX. The torque is known, and only the position is measured. The simulated joint that is measured is an
ordinary differential equation, written here, with other parameters and an encoder.

Both fits end in the same minimum, which is not always that of the true parameters: at steps of 1 ms over 2 s, both end at
the wrong friction. A large rms error shows this.
"""

import time

import jax
import mujoco
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

import bristle as br
from bristle.apps.targets.jax import Friction

jax.config.update("jax_enable_x64", True)
DT, STEPS, NAMES = 5e-4, 3000, ["F_C", "F_S", "v_S", "sigma_0", "sigma_1", "sigma_2"]
TRUTH = np.array([0.50, 0.65, 0.20, 120.0, 0.60, 0.080])
GUESS = np.array([0.35, 0.50, 0.35, 80.0, 0.30, 0.150])
INERTIA, MASS, LENGTH, GRAVITY = 0.02, 0.4, 0.1, 9.81
SCENE = f"""
<mujoco>
  <option timestep="{DT}" integrator="Euler" gravity="0 0 -{GRAVITY}"><flag contact="disable"/></option>
  <worldbody><body>
    <joint name="joint" type="hinge" axis="0 1 0" armature="{INERTIA - MASS * LENGTH**2}"/>
    <inertial pos="0 0 -{LENGTH}" mass="{MASS}" diaginertia="1e-9 1e-9 1e-9"/>
  </body></worldbody>
  <actuator><motor joint="joint"/><motor joint="joint" gear="-1"/></actuator>
</mujoco>"""


def torque(t):
    """Return the known torque [N*m]: slow swings, and faster small ones that hold and break away."""
    return 0.8 * np.sin(2.0 * np.pi * 0.7 * t) + 0.25 * np.sin(2.0 * np.pi * 3.1 * t)


def measured():
    """Return the positions of the measured joint [rad], with an encoder of 1e-5 rad."""
    F_C, F_S, v_S, sigma_0, sigma_1, sigma_2 = TRUTH

    def rates(t, state):
        q, v, z = state
        rate = v - sigma_0 * abs(v) * z / (F_C + (F_S - F_C) * np.exp(-((v / v_S) ** 2)))
        friction = sigma_0 * z + sigma_1 * rate + sigma_2 * v
        held = torque(DT * np.floor(t / DT + 1e-9))
        return v, (held - MASS * GRAVITY * LENGTH * np.sin(q) - friction) / INERTIA, rate

    state, q = np.zeros(3), [0.0]
    for k in range(STEPS):
        state = solve_ivp(
            rates, (k * DT, (k + 1) * DT - 1e-9), state, method="RK45", rtol=1e-8, atol=1e-12
        ).y[:, -1]
        q.append(state[0])
    return 1e-5 * np.round(np.array(q) / 1e-5)


CONTACT = Friction(br.friction.lugre(**dict(zip(NAMES, GUESS, strict=True))))


def contact(parameters, state, q, v):
    """Return the state of the contact at this position, and the mean force of the next step, predicted at this velocity."""
    given = dict(zip(NAMES, parameters, strict=True))
    state, _ = CONTACT.force(state, q, DT, given)
    return state, CONTACT.force(state, q + v * DT, DT, given)[1]


contact_only = jax.jit(contact)
contact_moved = jax.jit(
    lambda values, tangents: (
        contact(*values),
        jax.vmap(lambda *moved: jax.jvp(contact, values, moved)[1])(*tangents),
    )
)


def rolled(parameters, with_tangents):
    """Return the positions of a simulation in MuJoCo [rad], and their derivatives with respect to the parameters."""
    model = mujoco.MjModel.from_xml_string(SCENE)
    data, count = mujoco.MjData(model), len(parameters)
    state, d_state = CONTACT.start(), np.zeros((count, len(CONTACT.start())))
    motion, A, B = np.zeros((2, count)), np.zeros((2, 2)), np.zeros((2, 2))
    q, slopes = np.zeros(STEPS + 1), np.zeros((STEPS + 1, count))
    for k in range(STEPS):
        values = (parameters, state, data.qpos[0], data.qvel[0])
        if with_tangents:
            (state, force), (d_state, d_force) = contact_moved(
                values, (np.eye(count), d_state, motion[0], motion[1])
            )
        else:
            state, force = contact_only(*values)
        data.ctrl[:] = torque(k * DT), float(force)
        if with_tangents:
            mujoco.mjd_transitionFD(model, data, 1e-6, True, A, B, None, None)
            motion = A @ motion + np.outer(B[:, 1], d_force)
            slopes[k + 1] = motion[0]
        mujoco.mj_step(model, data)
        q[k + 1] = data.qpos[0]
    return q, slopes


class Fit:
    """The errors of the positions [encoder steps] over the logarithms of the parameters, with a count of the simulations."""

    def __init__(self, positions, exact):
        self.positions, self.exact, self.count, self.slopes = positions, exact, 0, {}

    def errors(self, logarithms):
        self.count += 1
        parameters = np.exp(logarithms)
        q, slopes = rolled(parameters, self.exact)
        self.slopes = {logarithms.tobytes(): slopes * parameters / 1e-5}
        return (q - self.positions) / 1e-5

    def jacobian(self, logarithms):
        if logarithms.tobytes() not in self.slopes:
            self.errors(logarithms)
        return self.slopes[logarithms.tobytes()]

    def run(self):
        begin = time.perf_counter()
        found = least_squares(
            self.errors,
            np.log(GUESS),
            jac=self.jacobian if self.exact else "2-point",
            x_scale="jac",
            xtol=1e-7,
        )
        return np.exp(found.x), np.sqrt(np.mean(found.fun**2)) * 1e-5, time.perf_counter() - begin


if __name__ == "__main__":
    positions = measured()
    for name, exact in (("derivatives", True), ("differences", False)):
        fit = Fit(positions, exact)
        parameters, rms, seconds = fit.run()
        print(f"{name}: {fit.count} simulations, {seconds:.0f} s, rms {1e6 * rms:.1f} urad")
        print("  " + ", ".join(f"{n} {v:.5g}" for n, v in zip(NAMES, parameters, strict=True)))
