"""Three laws against what bristle has, on an axis simulated by `benchmarks.independent`: ``python -m benchmarks.laws PART``.

``observer``: force and error with the asymptotic observer, beside a disturbance observer and a PID.
``learning``: error at first try on a second reference, after learning on a first one.
``circles``: deviation and quadrant glitches of two axes on a circle.
``python -m benchmarks board --task unknown_axis`` compares the laws in the loop of set C.
The seeds that judge (from 301) chose no parameter: seeds 1 and 101 did.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.independent import (
    DT,
    GAINS,
    Friction,
    M,
    Run,
    dahl,
    follow,
    harmonic,
    lugre,
    sliders,
)
from bristle import controllers, friction
from bristle.core.contracts import Model

JUDGES = (301, 302, 303, 304)
MACHINES = JUDGES[:3]  # of two axes each
OBSERVER: dict[str, Any] = {"g_1": 60.0, "g_2": 600.0, "F_C": 42.7, "sigma_0": 18e6, "band": 0.2e-6}
ADAPTIVE: dict[str, Any] = {"reach": 7e-6, "Gamma": 8e5, "w_max": 60.0, "delta": 2e-5}
STRIBECK: dict[str, Any] = {"F_C": 42.7, "F_S": 50.3, "v_S": 4e-4, "F_v": 4737.0}
PD = controllers.sliding_mode(**GAINS)
FIRST = harmonic([(4.0e-6, 0.25, 0.0), (2.5e-6, 0.61, 1.0)], 13.0)
SECOND = {
    "faster and farther": harmonic([(5.0e-6, 0.40, 0.7), (1.0e-6, 1.30, 0.0)], 13.0),
    "smaller loops": harmonic([(2.0e-6, 0.17, 0.3), (1.5e-6, 0.90, 2.0)], 13.0),
}


def summary(values: list[float]) -> str:
    """Return mean and standard deviation in micrometres or newtons."""
    return f"{np.mean(values):7.3f} ± {np.std(values, ddof=1):5.3f}"


# --- the observer of friction -------------------------------------------------------------------------------------------


def observer() -> None:
    """Print the error of the observed force, and the following error, on frictions of three structures."""
    # An observer that observes nothing.
    plugged: dict[str, Any] = {"g_1": 1e-9, "g_2": 1e9, "F_C": 1e9, "sigma_0": 0.0}
    laws = {
        "PD": PD,
        "disturbance observer, 60 1/s": controllers.disturbance_observer(**GAINS, g=60.0),
        "asymptotic observer, stiffness 0": controllers.asymptotic_observer(
            **GAINS, **{**OBSERVER, "sigma_0": 0.0}
        ),
        "asymptotic observer": controllers.asymptotic_observer(**GAINS, **OBSERVER),
        "PID": controllers.asymptotic_observer(**GAINS, **plugged, K_I=20.0),
        "PID and asymptotic observer": controllers.asymptotic_observer(
            **GAINS, **OBSERVER, K_I=20.0
        ),
    }
    kinds: dict[str, Callable[[int], Friction]] = {
        "Maxwell slip": sliders,
        "LuGre": lambda seed: lugre(),
        "Dahl": lambda seed: dahl(F_C=float(np.random.default_rng(seed).uniform(34.0, 51.0))),
    }
    print(
        f"{'friction':<14}{'law':<34}{'error, µm p-p':>18}{'error of the force, N rms':>28}{'effort, N rms':>16}"
    )
    for kind, made in kinds.items():
        for name, law in laws.items():
            runs = [follow(law, made(seed), FIRST, seed) for seed in JUDGES]
            forces = [observed_force(law, run) for run in runs]
            wrong = [
                float(np.sqrt(np.mean((f - run.friction)[2000:] ** 2)))
                for f, run in zip(forces, runs, strict=True)
                if f is not None
            ]
            effort = np.mean([np.sqrt(np.mean(run.effort**2)) for run in runs])
            text = summary(wrong) if wrong else "–"
            print(
                f"{kind:<14}{name:<34}{summary([1e6 * run.peak() for run in runs]):>18}{text:>28}{effort:>16.1f}",
                flush=True,
            )


def observed_force(law: Model, run: Run) -> np.ndarray | None:
    """Return the friction that a law observes at each sample [N]."""
    if law.name == "disturbance_observer":
        return np.array([state.z - law.values["g"] * M * state.v for state in run.states])
    if law.name == "asymptotic_observer" and law.values["F_C"] < 1e6:
        return np.array([state.f_hat for state in run.states])
    return None


# --- learning that carries ----------------------------------------------------------------------------------------------


def learning() -> None:
    """Print the error on second references at first try, of what was learned on the first."""
    rows: dict[str, dict[str, list[float]]] = {}
    for seed in JUDGES:
        axis, law = sliders(seed), controllers.adaptive_hysteresis(**GAINS, **ADAPTIVE)
        first = []
        for trial in range(3):
            run = follow(law, axis, FIRST, seed + 1000 * trial)
            law = replace(law, parameters=law.component.learned(run.states[-1], law.parameters))
            first.append(1e6 * run.peak())
        effort, trials = iterated(axis, FIRST, seed)
        net, identified = trained(FIRST, effort, seed), identified_friction(axis, seed)
        rows.setdefault("on the first reference", {}).update()
        for name, values in (("stops, three runs", first), ("time-indexed, six trials", trials)):
            rows["on the first reference"].setdefault(f"{name}: last", []).append(values[-1])
        for place, desired in SECOND.items():
            tries = {
                "nothing learned": (PD, desired),
                "stops, weights of zero": (
                    controllers.adaptive_hysteresis(**GAINS, **ADAPTIVE),
                    desired,
                ),
                "stops, carried weights": (law, desired),
                "stops, carried and frozen": (law.with_values(Gamma=0.0), desired),
                "time-indexed, its effort": (PD, added(desired, effort)),
                "time-indexed and net of the reference": (PD, added(desired, net(desired))),
                "Maxwell slip, identified, feedforward": (
                    PD,
                    added(desired, along(identified, desired)),
                ),
                "disturbance observer": (
                    controllers.disturbance_observer(**GAINS, g=60.0),
                    desired,
                ),
            }
            for name, (chosen, motion) in tries.items():
                run = follow(chosen, axis, motion, seed + 5000)
                rows.setdefault(f"{place}, first period", {}).setdefault(name, []).append(
                    1e6 * run.peak(1.0, 4.0)
                )
                rows.setdefault(f"{place}, whole run", {}).setdefault(name, []).append(
                    1e6 * run.peak()
                )
            rows[f"{place}, whole run"].setdefault("time-indexed, six trials on it", []).append(
                iterated(axis, desired, seed)[1][-1]
            )
    for place, table in rows.items():
        print(f"\n{place}: following error, µm peak to peak, {len(JUDGES)} axes")
        for name, values in table.items():
            print(f"  {name:<44}{summary(values)}", flush=True)


def added(desired: np.ndarray, effort: np.ndarray) -> np.ndarray:
    """Return a motion with an effort fed forward, a sample ahead for the delay of the loop."""
    return np.vstack((desired[:3], np.append(effort[1:], effort[-1])))


def iterated(
    axis: Friction, desired: np.ndarray, seed: int, trials: int = 6
) -> tuple[np.ndarray, list[float]]:
    """Return the effort that iterative learning over time finds, and the error of each trial [µm]."""
    from scipy.signal import butter, sosfiltfilt

    effort, errors, low_pass = (
        np.zeros(desired.shape[1]),
        [],
        butter(2, 20.0, fs=1.0 / DT, output="sos"),
    )
    for trial in range(trials):
        run = follow(PD, axis, added(desired, effort), seed + 1000 * trial)
        errors.append(1e6 * run.peak())
        if trial + 1 < trials:
            error = desired[0] - run.measured
            effort = sosfiltfilt(
                low_pass, effort + 14.2e6 * error + 0.19e6 * np.gradient(error, DT)
            )
    return effort, errors


def trained(
    desired: np.ndarray, effort: np.ndarray, seed: int, hidden: int = 10
) -> Callable[[np.ndarray], np.ndarray]:
    """Return a net of one hidden layer from position, velocity and acceleration of a reference to the learned effort."""
    from scipy.optimize import least_squares

    scale = np.std(desired[:3], axis=1)
    rows, size = (desired[:3] / scale[:, None])[:, 2000::40].T, float(np.std(effort))
    wanted, generator = effort[2000::40] / size, np.random.default_rng(seed)

    def output(weights: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        inner, outer = weights[: 4 * hidden].reshape(4, hidden), weights[4 * hidden :]
        return np.tanh(inputs @ inner[:3] + inner[3]) @ outer[:-1] + outer[-1]

    starts = [generator.standard_normal(5 * hidden + 1) for _ in range(2)]
    fits = [
        least_squares(lambda w: np.append(output(w, rows) - wanted, 1e-2 * w), start, max_nfev=60)
        for start in starts
    ]
    best = min(fits, key=lambda fit: fit.cost).x
    return lambda motion: size * output(best, (motion[:3] / scale[:, None]).T)


def identified_friction(axis: Friction, seed: int) -> Model:
    """Return the Maxwell slip that bristle identifies from the log of the first reference, without compensation."""
    import bristle as br

    run = follow(PD, axis, FIRST, seed)
    log = br.Log.from_columns(
        {
            "time": DT * np.arange(run.measured.size),
            "position": run.measured,
            "effort": np.append(0.0, run.effort[:-1]),
        }
    )
    return br.identify(
        log, "maxwell_slip", axis=br.Axis(mass=M), blocks=0, draws=0
    ).finished.best.friction


def along(model: Model, desired: np.ndarray) -> np.ndarray:
    """Return the force of a model along a motion [N]."""
    import bristle as br

    return br.response(model, desired[0], DT)


# --- circles ------------------------------------------------------------------------------------------------------------


def circles() -> None:
    """Print the deviation from a circle and its quadrant glitches, for two feeds and two lags of the drive."""
    observing = (
        controllers.disturbance_observer(**GAINS, g=60.0),
        controllers.asymptotic_observer(**GAINS, **OBSERVER),
    )
    laws: dict[
        str, tuple[Callable[[Friction], Model], Callable[[Friction, np.ndarray], np.ndarray]]
    ] = {
        "constant and viscous force": (lambda axis: PD, smooth),
        "Stribeck, reverses with the velocity": (stribeck(), constant),
        "Stribeck, lead of 2 ms": (stribeck(lead=2e-3), constant),
        "Stribeck, distance of 2 µm": (stribeck(x_0=2e-6), constant),
        "Stribeck, distance of 2 µm, lead of 2 ms": (stribeck(x_0=2e-6, lead=2e-3), constant),
        "Stribeck, distance of 2 µm, lead of 4 ms": (stribeck(x_0=2e-6, lead=4e-3), constant),
        "Maxwell slip": (lambda axis: PD, maxwell),
        "disturbance observer, Maxwell slip": (lambda axis: observing[0], maxwell),
        "disturbance observer": (lambda axis: observing[0], smooth),
        "asymptotic observer": (lambda axis: observing[1], smooth),
    }
    for radius, feed, lag in ((10e-3, 1 / 60, 2e-4), (25e-3, 3 / 60, 2e-4), (25e-3, 3 / 60, 2e-3)):
        print(
            f"\nradius {1e3 * radius:g} mm, {60 * feed:g} m/min, lag of the drive {1e3 * lag:g} ms, {len(MACHINES)} machines"
        )
        print(f"  {'':<44}{'deviation, µm p-p':>17}   {'glitch, µm p-p':>15}")
        for name, (law, fed) in laws.items():
            results = [circle(law, fed, radius, feed, seed, lag) for seed in MACHINES]
            whole, glitch = ([1e6 * pair[i] for pair in results] for i in range(2))
            print(f"  {name:<44}{summary(whole):>17}   {summary(glitch):>15}", flush=True)


def circle(
    law: Callable[[Friction], Model],
    fed: Callable[[Friction, np.ndarray], np.ndarray],
    radius: float,
    feed: float,
    seed: int,
    lag: float,
) -> tuple[float, float]:
    """Return the deviation of two axes from a circle and the mean glitch of the four quadrants, peak to peak [m]."""
    omega = feed / radius
    t = DT * np.arange(round(1.25 * 2.0 * np.pi / omega / DT))
    angle, places = omega * t, []
    for number, phase in enumerate((0.0, 0.5 * np.pi)):
        along_axis, across = radius * np.cos(angle - phase), radius * np.sin(angle - phase)
        axis = sliders(2 * seed + number)
        desired = np.array(
            [along_axis, -omega * across, -(omega**2) * along_axis, np.zeros(t.size)]
        )
        places.append(
            follow(
                law(axis), axis, added(desired, fed(axis, desired)), 2 * seed + number, lag
            ).position
        )
    last = t >= 0.25 * 2.0 * np.pi / omega
    deviation, turned = np.hypot(*places)[last] - radius, angle[last] % (2.0 * np.pi)
    apart = [np.abs((turned - k * 0.5 * np.pi + np.pi) % (2.0 * np.pi) - np.pi) for k in range(4)]
    return float(np.ptp(deviation)), float(
        np.mean([np.ptp(deviation[distance < np.pi / 6.0]) for distance in apart])
    )


def constant(axis: Friction, desired: np.ndarray) -> np.ndarray:
    """Return the mean force of both directions [N]."""
    return np.full(desired.shape[1], axis.numbers[4] + axis.numbers[5] * float(np.sum(axis.limit)))


def smooth(axis: Friction, desired: np.ndarray) -> np.ndarray:
    """Return the part of the friction that does not reverse in a jump [N]."""
    return constant(axis, desired) + axis.numbers[3] * desired[1]


def stribeck(**own: Any) -> Callable[[Friction], Model]:
    """Return the law over a reversal with the true level of each axis."""

    def law(axis: Friction) -> Model:
        level = float(np.sum(axis.limit))
        return controllers.predictive_reversal(
            **GAINS, F_C=level, F_S=1.18 * level, v_S=4e-4, F_v=axis.numbers[3], **own
        )

    return law


def maxwell(axis: Friction, desired: np.ndarray) -> np.ndarray:
    """Return the force of the true sliders with mean limits, without Stribeck's rise [N]."""
    total = float(np.sum(axis.limit))
    model = friction.maxwell_slip(
        F_C=total, k_i=axis.k, nu_i=axis.limit / total, sigma_2=axis.numbers[3]
    )
    return constant(axis, desired) + along(model, desired)


PARTS = {part.__name__: part for part in (observer, learning, circles)}


def main(names: list[str]) -> int:
    """Print the tables of these parts, or all; exit code 2 for an unknown part."""
    unknown = [name for name in names if name not in PARTS]
    if unknown:
        print(f"unknown part: {', '.join(unknown)}; allowed: {', '.join(PARTS)}", file=sys.stderr)
        return 2
    for name in names or PARTS:
        PARTS[name]()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
