"""Figures 2 and 3: a torque up and down below break-away."""

from __future__ import annotations

import numpy as np

from bristle.core.typography import with_unit
from bristle.paper.reproduced import Reproduced, percent, spread
from bristle.paper.ripple import Rippled, rippled
from bristle.paper.setting import Setting
from bristle.paper.torque_bench import Sensed, bench_of, sensor_numbers, sensor_says

__all__ = ["figure_2", "figure_3"]

LUGRE, RIG, SENSOR = "LuGre", "virtual rig", "torque sensor"
RESTS = 0.02  # of the width of the orbit: what counts as no drift where limits scatter
COURSE = (
    "Torque over position from the start on, as the torque sensor reads it and as friction is",
    "The rig from the start on, pushed over break-away and let back: what the torque sensor reads, narrow and dark, "
    "and the friction torque itself. Where the table slows down, the inertia behind the sensor pushes against it.",
)


def figure_2(setting: Setting) -> Reproduced:
    """Return figure 2: LuGre drifts under an oscillating torque, and so does what is to mend it."""
    setting.contact(LUGRE)
    runs = {name: rippled(setting, model) for name, model in setting.contacts.items()}
    drifts = {name: _drift(run) for name, run in runs.items()}
    findings = [f"{name}: {with_unit(step, 'm')} in every cycle." for name, step in drifts.items()]
    for name, step in drifts.items():
        if name != LUGRE and step > 0.0 and drifts[LUGRE] > 0.0:
            more = step / drifts[LUGRE] - 1.0
            findings.append(f"{name}: {percent(abs(more), 1.0)} {'more' if more > 0.0 else 'less'} than {LUGRE}.")
    return Reproduced(
        number=2,
        verdict="found" if drifts[LUGRE] > RESTS * _width(runs[LUGRE]) else "refuted",
        found=findings,
        draw=lambda: _draw(runs, drifts),
        origin=setting.origin,
        numbers={"drift_per_cycle": drifts},
    )


def figure_3(setting: Setting) -> Reproduced:
    """Return figure 3: the rig goes round closed orbits, by its torque sensor and by its friction."""
    bench = bench_of(setting)
    setting.contact(RIG)
    runs = {name: rippled(setting, model) for name, model in setting.contacts.items()}
    drifts = {name: _drift(run) for name, run in runs.items()}
    shares = {name: abs(drifts[name]) / _width(run) for name, run in runs.items()}
    sensed, start = runs[RIG].sensed, int(runs[RIG].cycles[0])
    assert sensed is not None
    ripple, push = (sensor_numbers([Sensed(*(torque[part] for torque in sensed))]) for part in (slice(start, None), slice(start)))
    dissipated, enclosed = (_work(setting, runs[RIG], torque) for torque in (sensed.friction, sensed.read))
    return Reproduced(
        number=3,
        verdict="built in" if max(shares.values()) < RESTS else "refuted",
        found=[
            *(_goes_round(name, run, shares[name]) for name, run in runs.items()),
            sensor_says(bench, ripple, "While the torque goes up and down"),
            f"In a cycle friction takes {_microjoules(dissipated)}; the orbit by the torque sensor encloses "
            f"{_microjoules(enclosed)}, as its filter is late.",
            f"Where the rig is pushed over break-away, it reads up to {percent(push['apart'])} beside friction.",
        ],
        draw=lambda: _draw(runs, drifts, runs[RIG]),
        origin=setting.origin,
        numbers={
            "drift_per_cycle": drifts,
            "share_of_the_orbit": shares,
            "torque_sensor": ripple,
            "torque_sensor_at_break_away": push,
            "work_of_friction": dissipated,
            "work_by_torque_sensor": enclosed,
        },
        extras={"course": (lambda: _draw_all(sensed, runs[RIG].x), *COURSE)},
    )


def _goes_round(name: str, run: Rippled, share: float) -> str:
    """Return in words how far a contact drifts in a cycle, on how wide an orbit, with the spread of the cycles."""
    moved = run.moved[run.moved.size // 2 :]
    step = f"{spread(1e9 * moved)} nm" if share > 1e-5 else "nothing"
    return f"{name}: {step} in a cycle, on an orbit {with_unit(_width(run), 'm')} wide."


def _work(setting: Setting, run: Rippled, torque: np.ndarray) -> np.ndarray:
    """Return the work of a torque [N*m] in each cycle of the second half [J]."""
    turned = torque * np.diff(run.x) / setting.arm
    return np.add.reduceat(turned, run.cycles[:-1])[run.moved.size // 2 :]


def _microjoules(work: np.ndarray) -> str:
    return f"{spread(1e6 * work)} µJ"


def _drift(run: Rippled) -> float:
    """Return how far the table goes in a cycle, at the mean of the second half [m]."""
    moved = run.moved
    return float(np.mean(moved[moved.size // 2 :]))


def _width(run: Rippled) -> float:
    """Return how wide the last orbit is [m]."""
    return float(np.ptp(run.x[run.cycles[-2] : run.cycles[-1]]))


def _draw(runs: dict[str, Rippled], drifts: dict[str, float], measured: Rippled | None = None):
    """Draw the driving torque and what it does; of a rig that is `measured`, what the torque sensor reads as well."""
    from bristle.figures import ripple

    first = next(iter(runs.values()))
    start, end = int(first.cycles[0]), int(first.cycles[1])
    widest = max(_width(run) for run in runs.values())
    traces, titles, close_up = {}, {}, None
    if measured is not None and measured.sensed is not None:
        traces[SENSOR] = _since(measured, measured.sensed.read, start)
        titles[SENSOR] = f"{RIG}, {SENSOR}"
        last = int(first.cycles[-2])
        torques = {"friction": measured.sensed.friction, SENSOR: measured.sensed.read}
        close_up = (f"{RIG}, last cycle less a line", {name: _since(measured, torque, last) for name, torque in torques.items()})
    for name, run in runs.items():
        traces[name] = _since(run, run.torque, start)
        step = f"{with_unit(drifts[name], 'm')} a cycle" if abs(drifts[name]) > RESTS * widest else "no drift"
        titles[name] = f"{name}, friction: {step}" if run is measured else f"{name}: {step}"
    return ripple(first.time, first.driving, traces, end - start, titles, "translational", "rotational", close_up=close_up)


def _since(run: Rippled, torque: np.ndarray, start: int) -> tuple[np.ndarray, np.ndarray]:
    """Return how far the table has gone since the ripple began [m], and a torque [N*m], from a sample on."""
    return run.x[start : torque.size] - run.x[run.cycles[0]], torque[start:]


def _draw_all(sensed: Sensed, x: np.ndarray):
    """Draw the whole course of a contact, as the torque sensor reads it and as friction is."""
    from bristle.figures import loop_family

    torques = {"friction": sensed.friction, SENSOR: sensed.read}
    panel = {name: [(x[: torque.size], torque)] for name, torque in torques.items()}
    return loop_family({"from the start on": panel}, "translational", "rotational")
