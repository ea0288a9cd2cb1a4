"""Design a motion for identification by the gradient of its information on friction, and try it on simulated measurements.

Needs JAX and a C compiler. The information is log det of J'J, with J the derivatives of the force with respect to the
logarithms of the parameters. Second derivatives do not exist: J is a central difference, and its gradient over the motion
is exact. The simulated measurement, written here, is LuGre friction in small steps, with noise
and other parameters.
"""

import jax
import numpy as np
from jax import numpy as jnp
from scipy.optimize import least_squares, minimize

import bristle as br
from bristle.apps.targets.jax import Friction

jax.config.update("jax_enable_x64", True)
DT, STEPS, SPEED, NOISE = 1e-3, 2000, 0.02, 0.3
NAMES = ["F_C", "F_S", "v_S", "sigma_0", "sigma_1", "sigma_2"]
TRUTH = np.array([20.0, 26.0, 2e-3, 2e6, 2e3, 250.0])
ASSUMED = TRUTH * [0.85, 1.1, 1.3, 0.7, 1.4, 0.8]  # known before the experiment
CONTACT = Friction(br.friction.lugre(**dict(zip(NAMES, ASSUMED, strict=True))))
PHASE = 2.0 * np.pi * np.outer(np.arange(STEPS + 1) / STEPS, np.arange(1, 11))
BASIS = np.hstack([np.sin(PHASE), np.cos(PHASE) - 1.0]) / np.tile(np.arange(1, 11), 2)


def motion(coefficients):
    """Return positions [m] of ten harmonics with a largest speed of 20 mm/s."""
    x = jnp.asarray(BASIS) @ coefficients
    return x * SPEED * DT / jnp.abs(jnp.diff(x)).max()


@jax.jit
def force(logarithms, x):
    """Return the force [N] along positions."""
    return CONTACT.walk(CONTACT.start(), x, DT, dict(zip(NAMES, jnp.exp(logarithms), strict=True)))[
        1
    ][1:]


@jax.jit
@jax.value_and_grad
def lack_of_information(coefficients):
    """Return -log det of the information at the assumed parameters, with its gradient."""
    x, at, h = motion(coefficients), np.log(ASSUMED), 1e-5
    J = (
        jnp.stack(
            [(force(at + h * one, x) - force(at - h * one, x)) / (2.0 * h) for one in np.eye(6)], 1
        )
        / NOISE
    )
    return -jnp.linalg.slogdet(J.T @ J)[1]


def simulated(x, parts=50):
    """Return the mean force [N] over each sample of LuGre friction in small steps."""
    F_C, F_S, v_S, sigma_0, sigma_1, sigma_2 = TRUTH
    z, forces = 0.0, []
    for v in np.diff(x) / DT:
        total, level = 0.0, F_C + (F_S - F_C) * np.exp(-((v / v_S) ** 2))
        for _ in range(parts):
            half = z + 0.5 * DT / parts * (v - sigma_0 * abs(v) * z / level)
            rate = v - sigma_0 * abs(v) * half / level
            z += DT / parts * rate
            total += sigma_0 * half + sigma_1 * rate + sigma_2 * v
        forces.append(total / parts)
    return np.array(forces)


def spread(x, runs=20):
    """Return the rms error [%] of each parameter over fits to measurements with different noise."""
    slopes, generator, clean = jax.jit(jax.jacfwd(force)), np.random.default_rng(7), simulated(x)
    fits = []
    for noisy in clean + NOISE * generator.standard_normal((runs, STEPS)):
        fits.append(
            least_squares(
                lambda at, y: np.asarray(force(at, x)) - y,
                np.log(ASSUMED),
                lambda at, _: np.asarray(slopes(at, x)),
                args=(noisy,),
            ).x
        )
    return 100.0 * np.sqrt(np.mean((np.exp(fits) / TRUTH - 1.0) ** 2, axis=0))


if __name__ == "__main__":
    motions = np.random.default_rng(1).standard_normal((400, BASIS.shape[1]))
    best = min(motions, key=lambda coefficients: lack_of_information(coefficients)[0])
    found = minimize(
        lack_of_information, motions[0], jac=True, method="L-BFGS-B", options={"maxiter": 100}
    )
    for name, coefficients in (
        ("random", motions[0]),
        ("best of 400 random", best),
        (f"designed with {found.nfev} gradients", found.x),
    ):
        errors = spread(np.asarray(motion(coefficients)))
        listed = ", ".join(f"{n} {v:.2f}" for n, v in zip(NAMES, errors, strict=True))
        mean = np.exp(np.mean(np.log(errors)))
        print(
            f"{name}: information {-lack_of_information(coefficients)[0]:.2f}, errors {mean:.3f} % (geometric mean): {listed}"
        )
