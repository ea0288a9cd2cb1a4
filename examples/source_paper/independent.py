"""The loop of sets A and C a second time, from the equations alone: its author had not read the code of bristle.

A ball-screw table under a sliding mode controller with a boundary layer. The friction of the rig is thirty spring-slider
elements in parallel. Three compensators. Forces act at the table, in SI units. Needs NumPy, SciPy and numba,
and nothing of bristle. CHOICE marks a choice where the statement leaves room.
"""

import functools
import math

import numpy as np
from numba import njit
from scipy.interpolate import PchipInterpolator

# plant, encoder, timing
MASS = 631.65  # kg
SAMPLE = 0.5e-3  # s
LAG = 0.2e-3  # s, first-order lag of the current loop
ENCODER_STEP = 0.125e-6  # m
ENCODER_NOISE = 0.01e-6  # m, standard deviation, before rounding
VELOCITY_CUTOFF = 400.0  # Hz
TIME = SAMPLE * np.arange(56000)  # 28 s
SCORED = TIME >= 2.0

# friction of the rig
V_STRIBECK = 397.887e-6  # m/s
FORWARD = (55.5434, 65.3451)  # N, (F_C, F_S) while v > 0
BACKWARD = (29.9080, 35.1858)  # N, (F_C, F_S) while v < 0
SIGMA_1 = 52429.3  # N s/m
SIGMA_2 = 4737.41  # N s/m
RIG_OFFSET = 6.2832  # N
SCATTER = 0.05  # standard deviation of the factor gamma
COUNTED_SPEED = 5e-8  # m/s, slower reversals do not draw a new gamma
# the model's friction, used by the compensators (with sigma_1, sigma_2 and v_S as above)
MODEL_F_C, MODEL_F_S = 42.725, 50.265  # N
SLOPE = 36.066e6  # N/m, stiffness at a reversal
F_PEAK = 81.933  # N, saturation of the reformed Dahl curve

# sliding-mode controllers: lambda (1/s), K_1 (1/s), K_2 (m/s^2), phi (m/s)
CONTROLLERS = {"A": (340.0, 340.0, 5e-3, 20e-6), "C": (150.0, 150.0, 0.0, 20e-6)}
COMPENSATORS = ("none", "printed", "position")
AMPLITUDES = 1e-6 * np.array([0.0, 6.8, 5.0, 3.4, 6.0, 2.2, 4.4, 6.8])  # m, at t = 0, 4, ..., 28 s
OMEGA = 2.0 * math.pi * 0.25


def reference(t):
    """Return r, r', r'' of r = A(t) sin(omega t), with A monotone between its values (the motion of sets A and C)."""
    amplitude = PchipInterpolator(4.0 * np.arange(AMPLITUDES.size), AMPLITUDES)
    (a, da, dda), s, c = (
        (amplitude(t, order) for order in range(3)),
        np.sin(OMEGA * t),
        np.cos(OMEGA * t),
    )
    return a * s, da * s + a * OMEGA * c, (dda - a * OMEGA**2) * s + 2.0 * da * OMEGA * c


def rig_elements():
    """Shares nu_j and stiffnesses k_j of the thirty elements."""
    r = 7e-6 * np.linspace(0.15, 1.0, 30) ** 1.6  # break-away distances
    w = (r / 7e-6) ** -0.75 * np.exp(0.35 * np.random.default_rng(7).standard_normal(30))
    share = w * r / np.sum(w * r)
    return share, share * (0.04 * 2.0 * math.pi / 0.005) / r


# Hysteresis: a Preisach operator kept as the staircase of its turning points, summed with its Everett function.
# The printed branch that leaves the tip of a symmetric loop (reversal at -m, up to h <= m) gives the Everett function
# at every pair lo < h with |h| <= |lo|; odd symmetry gives the pairs with |lo| <= |h|.  So it is known everywhere.


@njit
def tip_force(m):
    """Force at the tip of the loop between -m and m; it is the first loading curve of the operator as well."""
    k = SLOPE * m / F_PEAK
    return 0.5 * F_PEAK * (math.sqrt((1.0 + k) ** 2 + 4.0 * k) - (1.0 + k))


@njit
def branch(a, b):
    """Change of force along the branch from a reversal at a to b (twice the Everett function, signed)."""
    reach = F_PEAK + tip_force(max(abs(a), abs(b)))
    k = SLOPE * abs(b - a) / reach
    return math.copysign(reach * k / (1.0 + k), b - a)


@njit
def move(corner, count, last, x):
    """Bring the staircase from input `last` to input x: new turning point, wiping out.  Returns the count."""
    toward, before = x - last, corner[count - 1] if count > 0 else 0.0
    if toward != 0.0:
        if (last - before) * toward < 0.0:  # last was a turning point
            corner[count] = last
            count += 1
        # Passed the last but one: the loop is closed.
        while count > 1 and (x - corner[count - 2]) * toward >= 0.0:
            count -= 2
        if count > 0 and abs(x) >= abs(corner[0]):  # beyond all history: first loading again
            count = 0
    return count


@njit
def force(corner, count, x):
    """Force at input x: first loading to the first corner, then branch by branch."""
    if count == 0:
        return math.copysign(tip_force(abs(x)), x)
    total = math.copysign(tip_force(abs(corner[0])), corner[0])
    for i in range(1, count):
        total += branch(corner[i - 1], corner[i])
    return total + branch(corner[count - 1], x)


@njit
def hysteresis_of(path):
    """Force of the operator along a sampled path that starts at zero."""
    corner, count, last = np.zeros(1000), 0, 0.0
    out = np.zeros(len(path))
    for n, x in enumerate(path):
        count = move(corner, count, last, x)
        out[n], last = force(corner, count, x), x
    return out


@njit
def printed_model(velocity, fine, step):
    """f_h(z) + sigma_1 z' + sigma_2 v, z' = v (1 - f_h(z) sgn(v) / G(v)); every fine-th value is returned."""
    corner, count, z = np.zeros(1000), 0, 0.0
    out = np.zeros(len(velocity) // fine)
    for n, v in enumerate(velocity):
        f = force(corner, count, z)
        limit = MODEL_F_C + (MODEL_F_S - MODEL_F_C) * math.exp(-((v / V_STRIBECK) ** 2))
        rate = v * (1.0 - f * np.sign(v) / limit)
        if n % fine == 0:
            out[n // fine] = f + SIGMA_1 * rate + SIGMA_2 * v
        count = move(corner, count, z, z + step * rate)
        z += step * rate
    return out


@functools.lru_cache
def compensation(name, fine=10):
    """The compensator's force at every sample; open loop, from the reference only."""
    if name == "printed":
        step = SAMPLE / fine
        return printed_model(reference(step * np.arange(len(TIME) * fine))[1], fine, step)
    # CHOICE: the two halves are scaled first, the offset is added afterwards.
    if name == "position":
        f = 0.64 * hysteresis_of(reference(TIME)[0])
        return np.where(f > 0.0, 1.15, 0.85) * f + 3.1416
    return np.zeros(len(TIME))


@njit
def closed_loop(r, dr, ddr, f_hat, control, share, stiffness, noise, gammas, substeps, two_sided):
    """Encoder reading and effort at every sample.

    With two_sided, the upper bound of an element is that of the forward curve and the lower bound that of the backward
    curve. Without, both bounds follow the present direction, and a bent element loses force when the table turns.
    """
    lam, k1, k2, phi = control
    dt = SAMPLE / substeps
    lag_gain = 1.0 - math.exp(-dt / LAG)
    filter_gain = 1.0 - math.exp(-2.0 * math.pi * VELOCITY_CUTOFF * SAMPLE)
    held = np.zeros(len(share))  # forces of the elements
    x = v = applied = previous_effort = v_hat = q_last = springs = 0.0
    stuck = len(held)
    forward, counted, drawn, gamma = True, 0.0, 0, 1.0 + SCATTER * gammas[0]
    q_log, u_log = np.zeros((2, len(r)))
    for n in range(len(r)):
        q = ENCODER_STEP * math.floor((x + ENCODER_NOISE * noise[n]) / ENCODER_STEP + 0.5)
        v_hat += filter_gain * ((q - q_last) / SAMPLE - v_hat)
        q_last, rate_error = q, dr[n] - v_hat
        surface = rate_error + lam * (r[n] - q)
        effort = (
            MASS
            * (ddr[n] + lam * rate_error + k1 * surface + k2 * min(1.0, max(-1.0, surface / phi)))
            + f_hat[n]
        )
        q_log[n], u_log[n] = q, effort
        for _ in range(substeps):
            applied += lag_gain * (previous_effort - applied)
            # implicit in the damping, explicit in the springs
            damping = SIGMA_1 * stuck / len(held) + SIGMA_2
            v = (v + dt / MASS * (applied - RIG_OFFSET - springs)) / (1.0 + dt / MASS * damping)
            x += dt * v
            if v != 0.0:
                forward = v > 0.0
            if abs(v) >= COUNTED_SPEED:  # a counted reversal draws a new gamma
                drawn += v * counted < 0.0
                gamma = 1.0 + SCATTER * gammas[drawn % len(gammas)]
                counted = v
            fall = math.exp(-((v / V_STRIBECK) ** 2))
            upper = gamma * (FORWARD[0] + (FORWARD[1] - FORWARD[0]) * fall)
            lower = gamma * (BACKWARD[0] + (BACKWARD[1] - BACKWARD[0]) * fall)
            if not two_sided:
                upper = lower = upper if forward else lower
            springs, stuck = 0.0, 0
            for j in range(len(held)):
                trial = held[j] + stiffness[j] * v * dt
                held[j] = min(share[j] * upper, max(-share[j] * lower, trial))
                stuck += held[j] == trial
                springs += held[j]
        previous_effort = effort  # one sample of delay
    return q_log, u_log


def one_run(set_name, compensator, seed, substeps=25, two_sided=True):
    """Peak to peak and rms of r - q (micrometres) and rms of the effort (N), all over t >= 2 s."""
    r, dr, ddr = reference(TIME)
    noise, gammas = np.random.default_rng(seed).standard_normal((2, len(TIME)))
    q, u = closed_loop(
        r,
        dr,
        ddr,
        compensation(compensator),
        CONTROLLERS[set_name],
        *rig_elements(),
        noise,
        gammas,
        substeps,
        two_sided,
    )
    e, u = 1e6 * (r - q)[SCORED], u[SCORED]
    return np.ptp(e), math.sqrt(np.mean(e**2)), math.sqrt(np.mean(u**2))


def peak_to_peak(set_name, compensator, seeds=range(6), substeps=25, two_sided=True):
    """Mean and standard deviation over the seeds of the following error, peak to peak, in micrometres."""
    values = [one_run(set_name, compensator, seed, substeps, two_sided)[0] for seed in seeds]
    return float(np.mean(values)), float(np.std(values, ddof=1))


def results(seeds=range(6), substeps=25, two_sided=True):
    """{(set, compensator): {quantity: (mean, standard deviation)}} for all pairs."""
    table = {}
    for key in [
        (set_name, compensator) for set_name in CONTROLLERS for compensator in COMPENSATORS
    ]:
        runs = np.array([one_run(*key, seed, substeps, two_sided) for seed in seeds])
        pairs = [(float(column.mean()), float(column.std(ddof=1))) for column in runs.T]
        table[key] = dict(zip(("peak_to_peak_um", "rms_um", "effort_rms_N"), pairs, strict=True))
    return table


if __name__ == "__main__":
    tables = {
        "25 substeps": {},
        "50 substeps": {"substeps": 50},
        "bounds of the present direction": {"two_sided": False},
    }
    for title, changes in tables.items():
        print(f"\n{title:<32}  peak to peak [µm]   rms [µm]           effort rms [N]")
        for (name, compensator), row in results(**changes).items():
            print(
                f"{name} {compensator:<30}",
                *(f"{mean:7.3f} ± {spread:5.3f}   " for mean, spread in row.values()),
            )
