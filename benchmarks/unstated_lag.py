"""Does a proposal of `design` ring on an axis whose current loop has a lag that no file states?

Thirty axes of another simulator, each with a lag of 0.2 to 1 ms. `design` proposes gains without that lag and with it;
both are run on the axis. A loop that rings takes more effort. The same for 0.5 ms more lag than is stated.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks.coverage import Share
from benchmarks.rigs import Rig, drawn, motion
from bristle import controllers, friction, plants, references, sensors
from bristle.core.contracts import Model, Reference
from bristle.core.experiment import Feedforward, Run, Variant
from bristle.simulation.tuning import tuned

__all__ = ["efforts_of", "unstated_lag"]

AXES, SEED = 30, 4200
LEAST, MOST, FURTHER = 2e-4, 1e-3, 5e-4  # lags [s]
RINGS = 1.1  # of the effort
REACH, SPEED, DURATION = 0.01, 0.05, 4.0
LAWS = ("cascade", "disturbance_observer")


def variant_of(rig: Rig, reference: np.ndarray, lag: float) -> Variant:
    """Return the axis as a person knows it: its inertia and friction, and the lag that the file states (0: none)."""
    known = friction.lugre(
        F_C=rig.coulomb,
        F_S=rig.static,
        v_S=rig.stribeck,
        sigma_0=rig.coulomb / rig.reach,
        sigma_2=rig.viscous,
    )
    law = controllers.cascade(k_p=20.0, k_v=80.0 * rig.mass, k_i=400.0 * rig.mass, k_ff=1.0)
    return Variant(
        "axis",
        plants.inertia(M=rig.mass),
        known,
        law,
        sensors.encoder(resolution=rig.resolution),
        references.recorded(position=reference, sample_time=rig.dt),
        Feedforward(mass=rig.mass),
        Run(rig.dt * reference.size, rig.dt, delay=rig.delay, current_lag=lag),
    )


def efforts_of(rig: Rig, law: Model, reference: np.ndarray) -> float:
    """Return the root mean square of the effort with which an axis follows a reference."""
    component, p, dt = law.component, law.parameters, rig.dt
    v = np.gradient(reference, dt)
    a = np.gradient(v, dt)
    own = 0.0 if "J" in component.variables else rig.mass
    fed = own * a + rig.gravity
    state = [component.start(reference[0], 0.0, 0.0, dt, p)]

    def command(k: int, read: float) -> float:
        effort, state[0] = component.step(
            state[0], Reference(reference[k], v[k], a[k], fed[k]), read, dt, p
        )
        return float(effort)

    return rig.follow(command, reference).rms


def unstated_lag() -> Iterator[Share]:
    """Count proposals that take no more than 1.1 times the effort of those with the lag stated."""
    rng = np.random.default_rng(SEED)
    worst = {name: [] for name in ("not stated", "0.5 ms more than stated")}
    for number in range(AXES):
        lag = float(rng.uniform(LEAST, MOST))
        rig = replace(drawn(SEED + number), lag=lag, delay=int(rng.integers(0, 2)))
        reference = motion(rig, DURATION, SEED + number, REACH, SPEED)
        late = replace(rig, lag=lag + FURTHER)
        for law in LAWS:
            without, stated = (tuned(variant_of(rig, reference, each), law) for each in (0.0, lag))
            if without is None or stated is None:
                raise RuntimeError(f"no gains keep the margins on axis {number} with {law}")
            named = efforts_of(rig, stated.law, reference)
            worst["not stated"].append(efforts_of(rig, without.law, reference) / named)
            worst["0.5 ms more than stated"].append(efforts_of(late, stated.law, reference) / named)
    for name, ratios in worst.items():
        quiet = 100.0 * float(np.mean(np.array(ratios) <= RINGS))
        yield Share(
            f"gains do not oscillate, lag {name}",
            quiet,
            100.0,
            100.0,
            len(ratios),
            f"at most {max(ratios):.3f} times the effort",
        )
