"""Figures 2 and 3: a torque up and down below break-away."""

from __future__ import annotations

import numpy as np

from bristle.core.typography import with_unit
from bristle.paper.reproduced import Reproduced
from bristle.paper.ripple import Rippled, rippled
from bristle.paper.setting import Setting

__all__ = ["figure_2", "figure_3"]

RESTS = 0.02  # of the width of the orbit: what counts as no drift where limits scatter


def figure_2(setting: Setting) -> Reproduced:
    """Return figure 2: LuGre drifts under an oscillating torque, and so does what is to mend it."""
    runs = {name: rippled(setting, model) for name, model in setting.contacts.items()}
    drifts = {name: _drift(one) for name, one in runs.items()}
    found = [f"{name} walks {with_unit(step, 'm')} in every cycle." for name, step in drifts.items()]
    first, *others = drifts.items()
    for name, step in others:
        if step > 0.0 and first[1] > 0.0:
            found.append(f"{name}: {100.0 * (step / first[1] - 1.0):+.0f} % against {first[0]}.".replace("-", "−"))
    return Reproduced(
        number=2,
        title="Drift under an oscillating torque, simulated",
        claim="LuGre drifts under a small oscillating torque.",
        verdict="holds" if drifts.get("LuGre", 0.0) > RESTS * _width(runs["LuGre"]) else "does not hold",
        said="“As shown in Fig. 2(b), the friction torque is continuously drifted for the small oscillated input "
        "torque.” The model (5)–(7) is then suggested because “it is found that the LuGre model should be modified in "
        "the pre-sliding region”.",
        found=found,
        differs="For LuGre it does not differ. The paper does not draw its own model here: (5)–(7) slip a little at every "
        "torque too, in proportion to its share of sliding friction, and drift more. That they do not drift is never "
        "stated, and does not follow.",
        draw=lambda: _draw(runs, drifts),
        alternative="Driving torque over time, and friction torque over position for LuGre and the equations of the paper",
        source=setting.source,
        numbers={"drift_per_cycle": drifts},
    )


def figure_3(setting: Setting) -> Reproduced:
    """Return figure 3: the rig goes round closed orbits."""
    runs = {name: rippled(setting, model) for name, model in setting.contacts.items()}
    drifts = {name: _drift(one) for name, one in runs.items()}
    shares = {name: abs(drifts[name]) / _width(one) for name, one in runs.items()}
    found = [
        f"{name}: {with_unit(abs(drifts[name]), 'm') if shares[name] > 1e-6 else 'nothing'} in a cycle, on an orbit "
        f"{with_unit(_width(one), 'm')} wide."
        for name, one in runs.items()
    ]
    return Reproduced(
        number=3,
        title="The same torque on the rig",
        claim="The real contact does not drift: it runs through closed orbits.",
        verdict="holds" if max(shares.values()) < RESTS else "does not hold",
        said="“However, in the real system shown in Fig. 3, the elliptical orbits of the friction against the small "
        "oscillated input torque were represented.”",
        found=found,
        differs="The orbits are lenses rather than ellipses: hysteresis does not depend on the rate, and its loops have "
        "corners where the torque turns. A torque sensor with a filter rounds them. Every reversal of the rig scatters a "
        "little, so its orbits wander, and cancel out; the model with a gate goes round one orbit for ever.",
        draw=lambda: _draw(runs, drifts),
        alternative="Driving torque over time, and friction torque over position for the virtual rig and the model with a "
        "gate",
        source=setting.source,
        numbers={"drift_per_cycle": drifts, "share_of_the_orbit": shares},
    )


def _drift(one: Rippled) -> float:
    """Return how far the table goes in a cycle, at the mean of the second half [m]."""
    moved = one.moved
    return float(np.mean(moved[moved.size // 2 :]))


def _width(one: Rippled) -> float:
    """Return how wide the last orbit is [m]."""
    return float(np.ptp(one.x[one.cycles[-2] : one.cycles[-1]]))


def _draw(runs: dict[str, Rippled], drifts: dict[str, float]):  # noqa: ANN202
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
