"""Figures 2 and 3: a torque up and down below break-away."""

from __future__ import annotations

import numpy as np

from bristle.core.typography import with_unit
from bristle.paper.reproduced import Reproduced, percent
from bristle.paper.ripple import Rippled, rippled
from bristle.paper.setting import Setting

__all__ = ["figure_2", "figure_3"]

LUGRE, RIG = "LuGre", "virtual rig"
RESTS = 0.02  # of the width of the orbit: what counts as no drift where limits scatter


def figure_2(setting: Setting) -> Reproduced:
    """Return figure 2: LuGre drifts under an oscillating torque, and so does what is to mend it."""
    setting.contact(LUGRE)
    runs = {name: rippled(setting, model) for name, model in setting.contacts.items()}
    drifts = {name: _drift(one) for name, one in runs.items()}
    found = [f"{name}: {with_unit(step, 'm')} in every cycle." for name, step in drifts.items()]
    for name, step in drifts.items():
        if name != LUGRE and step > 0.0 and drifts[LUGRE] > 0.0:
            more = step / drifts[LUGRE] - 1.0
            found.append(f"{name}: {percent(abs(more), 1.0)} {'more' if more > 0.0 else 'less'} than {LUGRE}.")
    return Reproduced(
        number=2,
        verdict="holds" if drifts[LUGRE] > RESTS * _width(runs[LUGRE]) else "does not hold",
        found=found,
        draw=lambda: _draw(runs, drifts),
        origin=setting.origin,
        numbers={"drift_per_cycle": drifts},
    )


def figure_3(setting: Setting) -> Reproduced:
    """Return figure 3: the rig goes round closed orbits."""
    setting.contact(RIG)
    runs = {name: rippled(setting, model) for name, model in setting.contacts.items()}
    drifts = {name: _drift(one) for name, one in runs.items()}
    shares = {name: abs(drifts[name]) / _width(one) for name, one in runs.items()}
    found = [
        f"{name}: {with_unit(abs(drifts[name]), 'm') if shares[name] > 1e-5 else 'nothing'} in a cycle, on an orbit "
        f"{with_unit(_width(one), 'm')} wide."
        for name, one in runs.items()
    ]
    return Reproduced(
        number=3,
        verdict="holds" if max(shares.values()) < RESTS else "does not hold",
        found=found,
        draw=lambda: _draw(runs, drifts),
        origin=setting.origin,
        numbers={"drift_per_cycle": drifts, "share_of_the_orbit": shares},
    )


def _drift(one: Rippled) -> float:
    """Return how far the table goes in a cycle, at the mean of the second half [m]."""
    moved = one.moved
    return float(np.mean(moved[moved.size // 2 :]))


def _width(one: Rippled) -> float:
    """Return how wide the last orbit is [m]."""
    return float(np.ptp(one.x[one.cycles[-2] : one.cycles[-1]]))


def _draw(runs: dict[str, Rippled], drifts: dict[str, float]):
    from bristle.figures import ripple

    one = next(iter(runs.values()))
    start, end = int(one.cycles[0]), int(one.cycles[1])
    widest = max(_width(run) for run in runs.values())
    return ripple(
        one.time, one.driving,
        {name: (run.x[start:] - run.x[start], run.torque[start:]) for name, run in runs.items()}, end - start,
        {name: f"{name}: {with_unit(step, 'm') if abs(step) > RESTS * widest else 'none'}"
         for name, step in drifts.items()},
        "translational", "rotational",
    )  # fmt: skip
