"""An arm behind a gear whose friction rises with what it carries: numpy alone, nothing of the package."""

import math

import numpy as np
from tests.identification.known_logs import sines

J, GRAVITY, F_C, F_V, SHARE = 0.05, 2.0, 0.15, 0.05, 0.25
RATE = 1000.0


def swing(seconds, seed):
    return sines(
        seconds,
        1.0 / RATE,
        (0.9, 0.35, 0.15),
        (0.21, 0.57, 1.13),
        np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, 3),
    )


def effort(q, v, a, share=SHARE):
    """What the arm takes: the load, and friction that rises with it by `share`."""
    load = J * a + GRAVITY * np.sin(q)
    return load + (F_C + share * np.abs(load)) * np.sign(v) + F_V * v


def log(share=SHARE, seconds=25.0, seed=0, noise=2e-3):
    t, q, v, a = swing(seconds, seed)
    u = effort(q, v, a, share) + noise * np.random.default_rng(seed + 100).standard_normal(t.size)
    return {"t": t, "q": q, "u": u}


def fall(seconds, x, applied=0.0, share=SHARE, steps=20_000):
    """Where the arm gets to from rest under a constant effort, by small steps, holding where friction can hold it."""
    h, v = seconds / steps, 0.0
    for _ in range(steps):
        drive = applied - GRAVITY * math.sin(x)
        if v == 0.0:
            # At rest all of gravity passes the gear, and nothing of the effort is lost to anything else.
            if abs(drive) <= F_C + share * abs(GRAVITY * math.sin(x)):
                return x
            side = math.copysign(1.0, drive)
        else:
            side = math.copysign(1.0, v)
        # load = J a + G sin x = applied - F with F = side (F_C + share |load|) + F_V v: solved for either sign of load
        rest = applied - side * F_C - F_V * v
        load = rest / (1.0 + side * share * math.copysign(1.0, rest))
        after = v + h * (load - GRAVITY * math.sin(x)) / J
        if v != 0.0 and after * v < 0.0:
            after = 0.0
        x, v = x + 0.5 * h * (v + after), after
    return x
