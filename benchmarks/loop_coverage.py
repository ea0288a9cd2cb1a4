"""Do 95 % intervals of fits to a closed loop hold the truth? Synthetic logs of a loop whose friction is known."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from benchmarks.coverage import Share
from benchmarks.loops import AXIS, MASS, recorded_in_loop
from bristle import friction
from bristle.core.cores import core_count
from bristle.core.normal import NORMAL_95
from bristle.identification import identify

__all__ = ["loop_coverage"]

TRIALS, DRAWS = 36, 100
CASES = {
    "coulomb_viscous": friction.coulomb_viscous(F_C=20.0, F_v=200.0),
    "stribeck": friction.stribeck(F_C=20.0, F_S=28.0, v_S=3e-3, F_v=200.0),
    "lugre": friction.lugre(F_C=20.0, F_S=28.0, v_S=2e-3, sigma_0=5e6, sigma_1=1e3, sigma_2=200.0),
}


def tried(name: str, seed: int) -> dict[str, tuple[bool, bool]]:
    """Record a log of a case and fit it; return, for each parameter, whether its intervals hold the truth.

    The first interval is that of twins, the second one plus and minus 1.96 plain standard errors.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        log = recorded_in_loop(CASES[name], seed)
        fit = identify(log, name, axis=AXIS, blocks=0, draws=DRAWS).best
    known = {**CASES[name].values, "M": MASS, "offset": 0.0}
    return {
        one.name: (
            one.interval[0] <= known[one.name] <= one.interval[1],
            one.std is not None and abs(one.value - known[one.name]) <= NORMAL_95 * one.std,
        )
        for one in fit.estimates
        if one.status == "identified" and one.interval is not None
    }


def loop_coverage() -> Iterator[Share]:
    """Coverage of the intervals of each case, pooled and for each parameter."""
    with ProcessPoolExecutor(core_count()) as pool:
        for name in CASES:
            trials = list(pool.map(tried, [name] * TRIALS, range(TRIALS)))
            every = [inside for one in trials for inside in one.values()]
            by_twins, plain = (100.0 * float(np.mean(one)) for one in zip(*every, strict=True))
            yield Share(
                f"{name}, pooled",
                by_twins,
                90.0,
                98.0,
                len(every),
                f"plain standard errors {plain:.0f} %",
            )
            for parameter in dict.fromkeys(key for one in trials for key in one):
                inside = [one[parameter][0] for one in trials if parameter in one]
                yield Share(
                    f"{name}, {parameter}", 100.0 * float(np.mean(inside)), 85.0, 100.0, len(inside)
                )
