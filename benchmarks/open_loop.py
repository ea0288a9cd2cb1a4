"""Open loops simulated with a tolerance, against steps of one length at the same error.

Both go through `simulate`, as an experiment file does. The error is the largest of the position over the samples,
against steps of one length 100 times as short as those beside it. Beside a run with a tolerance stands the one with
the fewest steps whose error is no larger.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from benchmarks.timing import Ratio, busy_side_by_side

DT, COUNT = 0.01, 1000
SUBSTEPS = tuple(2**k for k in range(14))  # of one length, in a sample
FINER, RUNS = 100, 25
CONTACT = {"F_C": 1.0, "F_S": 1.5, "v_S": 1e-3, "sigma_1": 316.0, "sigma_2": 0.4}
LIMIT = 1.0


class Case(NamedTuple):
    """An open loop, the tolerance that it is given [m], and the largest ratio of times that is claimed, if one is."""

    name: str
    plant: Any
    friction: Any
    effort: np.ndarray
    tolerance: float
    limit: float = LIMIT


def cases() -> Iterator[Case]:
    """Yield what is simulated: pulled and left alone, switched, and driven by a sine whose samples are held."""
    from bristle import friction, plants

    pulled, mass = plants.pulled_inertia(M=1.0, k=2.0, v_e=0.2), plants.inertia(M=1.0)
    spring = plants.oscillator(M=1.0, c=0.5, k=40.0)
    time = DT * np.arange(COUNT)
    rest, switched, sine = (
        np.zeros(COUNT),
        3.0 * np.sign(np.sin(2.0 * time)),
        3.0 * np.sin(2.0 * time),
    )
    models = {
        "LuGre": friction.lugre(sigma_0=1e5, **CONTACT),
        "Preisach-LuGre": friction.preisach_lugre(s=1e5, f_p=1.8, **CONTACT),
        "elastoplastic": friction.elastoplastic(sigma_0=1e5, z_ba=5e-6, **CONTACT),
        "Stribeck": friction.stribeck(F_C=1.0, F_S=1.5, v_S=1e-2, F_v=0.4),
        "Coulomb": friction.coulomb(F_C=1.0),
        "Dahl": friction.dahl(F_C=1.0, sigma_0=1e4),
    }
    for name in ("LuGre", "Preisach-LuGre", "elastoplastic", "Stribeck", "Coulomb"):
        yield Case(f"{name}, pulled", pulled, models[name], rest, 1e-5)
    for name in ("LuGre", "Stribeck"):
        yield Case(f"{name}, force switched", mass, models[name], switched, 1e-5)
    # smooth: as many steps as of one length
    yield Case("Dahl on a spring, sine", spring, models["Dahl"], sine, 1e-6, 1.5)
    for name in ("LuGre", "Preisach-LuGre", "Stribeck"):
        yield Case(f"{name}, sine held from sample to sample", mass, models[name], sine, 1e-5)


def open_loop() -> Iterator[Ratio]:
    """Time `simulate` with a tolerance against the fewest steps of one length that err no more."""
    from bristle.engine import run_open_loop
    from bristle.simulation import open_loop_experiment, simulate

    for case in cases():
        machine = (case.plant, case.friction, case.effort, DT)

        def run(machine: Any = machine, **steps: Any) -> np.ndarray:
            return simulate(open_loop_experiment(*machine, **steps)).variants["base"].position

        def error(found: np.ndarray, substeps: int, machine: Any = machine) -> float:
            exact = run_open_loop(*machine, steps=min(FINER * substeps, 10 * SUBSTEPS[-1])).position
            return float(np.max(np.abs(found - exact)))

        by_tolerance, substeps, reached, beside = run(tolerance=case.tolerance), 0, 0.0, np.inf
        for substeps in SUBSTEPS:
            reached = error(by_tolerance, substeps)
            beside = error(run(substeps=substeps), substeps)
            if beside <= reached:
                break
        ours, theirs, ratio = busy_side_by_side(
            lambda run=run, tolerance=case.tolerance: run(tolerance=tolerance),
            lambda run=run, substeps=substeps: run(substeps=substeps),
            RUNS,
        )
        yield Ratio(
            case.name,
            ours,
            theirs,
            ratio,
            case.limit,
            f"{substeps} steps in a sample, {beside:.1e} m",
            f"{reached:.1e} m for {case.tolerance:.0e} m",
        )
