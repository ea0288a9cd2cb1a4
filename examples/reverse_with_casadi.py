"""Plan the effort of an axis through a reversal with CasADi, and try the plan on a simulated rig with other friction.

Needs CasADi and a C compiler. The drive filters the feedforward, and changes it every 4 ms: a force that changes sign at
the reversal arrives late. The plan knows filter, controller and LuGre friction, identified from another motion of the
rig. The rig, written here, has sixty elements that stick and slip, and Stribeck friction.

Without a limit of its change, a feedforward through the inverse of the filter is better than the plan. With a limit, it begins
too late, and the plan is better.
"""

import subprocess
import tempfile
from pathlib import Path

import casadi
import numpy as np

import bristle as br

DT, STEPS, HOLD, PARTS = 1e-3, 400, 4, 4
MASS, LAG, K_P, K_D = 20.0, 5e-3, 3e5, 3.5e3
TIME = DT * np.arange(STEPS)
PATH = 2.5e-3 * (1.0 - np.cos(2.0 * np.pi * TIME / (DT * STEPS)))  # forth and back in 0.4 s
REVERSAL = slice(STEPS // 2 - 50, STEPS // 2 + 50)
LEVELS = np.linspace(0.2, 1.8, 60)
# Share of the force, and deflection at which an element slips [m]
SHARE, SLIP = (LEVELS**-0.5 / np.sum(LEVELS**-0.5), 8e-6 * LEVELS**2)


def on_rig(path, feedforward, parts=20):
    """Return position [m] and effort [N] of the rig at each sample."""
    x, v, filtered, e, step, out = 0.0, 0.0, 0.0, np.zeros(60), DT / parts, []
    for place, speed, ahead in zip(path, np.gradient(path, DT), feedforward, strict=True):
        filtered += (ahead - filtered) * (1.0 - np.exp(-DT / LAG))
        effort = filtered + K_P * (place - x) + K_D * (speed - v)
        out.append((x, effort))
        for _ in range(parts):
            level = 21.0 + 6.0 * np.exp(-abs(v) / 3e-3)
            v += step * (effort - level * np.sum(SHARE * e / SLIP) - 250.0 * v) / MASS
            x += step * v
            e = np.clip(e + step * v, -SLIP, SLIP)
    return np.array(out).T


def identified():
    """Return LuGre friction, identified from six seconds of another motion."""
    t = DT * np.arange(6000)
    path = 3e-3 * np.sin(2.0 * np.pi * 0.7 * t) + 4e-4 * np.sin(2.0 * np.pi * 4.1 * t)
    position, effort = on_rig(path, 0.0 * t)
    fit = br.identify(
        {"time": t, "position": position, "effort": effort}, "lugre", mass=MASS, draws=0, blocks=0
    ).best
    return fit.friction


def limited(feedforward, change):
    """Return the feedforward as the drive applies it: constant over 4 ms, with a limited change."""
    out = feedforward[::HOLD].copy()
    for k in range(1, len(out)):
        out[k] = np.clip(out[k], out[k - 1] - change, out[k - 1] + change)
    return np.repeat(out, HOLD)


def model_of_axis(friction, folder):
    """Return a sample of the axis as a function of CasADi: (state, path) -> (next state, error); and its first state."""
    br.export(friction, "casadi", folder)
    line = [
        "cc",
        "-O2",
        "-ffp-contract=off",
        "-shared",
        "-fPIC",
        "axis_x.c",
        "axis_x_casadi.c",
        "-o",
        "axis_x.so",
        "-lm",
    ]
    subprocess.run(line, cwd=folder, check=True)
    contact, initial = (
        casadi.external(f"axis_x_{part}", str(folder / "axis_x.so")) for part in ("step", "initial")
    )
    virgin, p = initial.call([])
    state, path = casadi.MX.sym("state", virgin.numel() + 3), casadi.MX.sym("path", 3)
    after, x, v, filtered = casadi.vertsplit(
        state, [0, virgin.numel(), *range(virgin.numel() + 1, virgin.numel() + 4)]
    )
    place, speed, ahead = casadi.vertsplit(path)
    error, step = place - x, DT / PARTS
    filtered += (ahead - filtered) * (1.0 - np.exp(-DT / LAG))
    effort = filtered + K_P * error + K_D * (speed - v)
    for _ in range(PARTS):
        v += step * (effort - contact(after, x + step * v, step, p)[1]) / MASS
        x += step * v
        after = contact(after, x, step, p)[0]
    sample = casadi.Function(
        "sample", [state, path], [casadi.vertcat(after, x, v, filtered), error]
    )
    return sample, casadi.vertcat(virgin, casadi.DM.zeros(3))


def planned(sample, begin, start, change):
    """Return the feedforward [N] with the least squared error of the model, from a start."""
    u = casadi.MX.sym("u", STEPS // HOLD)
    speed = np.gradient(PATH, DT)
    _, errors = sample.mapaccum(STEPS)(
        begin, casadi.vertcat(PATH[None], speed[None], casadi.vec(casadi.repmat(u.T, HOLD, 1)).T)
    )
    cost = casadi.sumsqr(1e6 * errors) / STEPS + 1e-3 * casadi.sumsqr(casadi.diff(u))
    options = {
        "print_time": False,
        "ipopt": {
            "hessian_approximation": "limited-memory",
            "max_iter": 300,
            "print_level": 0,
            "sb": "yes",
        },
    }
    solver = casadi.nlpsol("plan", "ipopt", {"x": u, "f": cost, "g": casadi.diff(u)}, options)
    solution = solver(x0=start[::HOLD], lbg=-change, ubg=change)
    assert solver.stats()["success"], solver.stats()["return_status"]
    return np.repeat(np.array(solution["x"]).ravel(), HOLD)


if __name__ == "__main__":
    friction = identified()
    print(friction)
    inertia = MASS * np.gradient(np.gradient(PATH, DT), DT)
    force = inertia + br.response(friction, PATH, DT)
    inverted = force + LAG * np.gradient(force, DT)
    with tempfile.TemporaryDirectory() as folder:
        axis = model_of_axis(friction, Path(folder) / "axis")
        for change in (np.inf, 6.0):
            print(f"feedforward that changes by at most {change} N in 4 ms:")
            plans = {
                "mass only": inertia,
                "force along the path": force,
                "the same, filter inverted": inverted,
            }
            plans = {name: limited(plan, change) for name, plan in plans.items()}
            plans["planned"] = planned(*axis, plans["force along the path"], change)
            for name, plan in plans.items():
                error = 1e6 * np.abs(PATH - on_rig(PATH, limited(plan, change))[0])
                print(
                    f"  {name}: {error[REVERSAL].max():.1f} um at the reversal, rms {np.sqrt(np.mean(error**2)):.1f} um"
                )
