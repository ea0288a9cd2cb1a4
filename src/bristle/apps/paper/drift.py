"""Figures 2 and 3: an inertia on a contact, pushed beyond break-away, at rest, then under a torque ripple below it."""

from typing import NamedTuple

import numpy as np

from bristle.apps.paper.bench import (
    Sensed,
    bench_of,
    plant_of,
    read_torque,
    sensor_numbers,
    sensor_says,
)
from bristle.apps.paper.reproduced import Reproduced, percent, spread, verdict_if
from bristle.apps.paper.setting import Setting
from bristle.core import InputError, Model, with_unit
from bristle.engine import run_open_loop
from bristle.report.figures.small_multiples import ripple

SAMPLE_TIME = 2.5e-4  # [s]


class Rippled(NamedTuple):
    """The response of a contact to a torque ripple."""

    time: np.ndarray
    driving: np.ndarray
    x: np.ndarray
    torque: np.ndarray
    cycles: np.ndarray
    sensed: Sensed | None = None

    @property
    def settled(self) -> np.ndarray:
        """Displacement of the table in each cycle of the second half [m]."""
        moved = np.diff(self.x[self.cycles])
        return moved[moved.size // 2 :]

    @property
    def width(self) -> float:
        """Width of the last orbit [m]."""
        return float(np.ptp(self.x[self.cycles[-2] : self.cycles[-1]]))


def torque_of(setting: Setting) -> tuple[np.ndarray, np.ndarray]:
    """Return the driving torque of an experiment [N*m] at each sample, and the samples at which cycles of the ripple start."""
    top, low, high = (float(setting["torque", key]) for key in ("break_away", "low", "high"))
    if not low < high < top:
        raise InputError(
            "must satisfy low < high < break_away",
            path=f"{setting.source}: torque",
            value=(low, high, top),
        )
    period = round(setting["torque", "period"] / SAMPLE_TIME)
    cycles = round(setting["torque", "cycles"])
    wave = low + (high - low) * np.abs(
        2.0 * ((np.arange(cycles * period + 1) / period) % 1.0) - 1.0
    )
    rise = np.linspace(0.0, top, 4 * period, endpoint=False)
    back = np.linspace(top, high, 2 * period, endpoint=False)
    start = rise.size + back.size
    return np.concatenate((rise, back, wave)), start + period * np.arange(cycles + 1)


def rippled(setting: Setting, friction: Model) -> Rippled:
    """Return the response of a contact to the torque of an experiment."""
    driving, cycles = torque_of(setting)
    arm = setting.arm
    trace = run_open_loop(
        plant_of(setting), friction, driving / arm, SAMPLE_TIME, steps=4, hold="linear"
    )
    torque = trace.friction * arm
    sensed = None
    if "bench" in setting.numbers:
        # Between samples the torque is linear.
        mean = 0.5 * (driving[:-1] + driving[1:])
        sensed = read_torque(
            bench_of(setting), mean, trace.velocity / arm, torque[:-1], SAMPLE_TIME
        )
    return Rippled(trace.time, driving, trace.position, torque, cycles, sensed)


LUGRE = "LuGre"
RIG = "virtual rig"
SENSOR = "torque sensor"
RESTS = 0.02  # of the width of the orbit: tolerance for no drift, if limits scatter


def figure_2(setting: Setting) -> Reproduced:
    """Return figure 2: LuGre drifts under an oscillating torque, and the equations of the paper drift too."""
    setting.contact(LUGRE)
    runs = {name: rippled(setting, model) for name, model in setting.contacts.items()}
    drifts = {name: float(np.mean(run.settled)) for name, run in runs.items()}
    findings = [f"{name}: {with_unit(step, 'm')} per cycle." for name, step in drifts.items()]
    for name, step in drifts.items():
        if name != LUGRE and step > 0.0 and drifts[LUGRE] > 0.0:
            more = step / drifts[LUGRE] - 1.0
            word = "less"
            if more > 0.0:
                word = "more"
            findings.append(f"{name}: {percent(abs(more), 1.0)} {word} than {LUGRE}.")
    return Reproduced(
        number=2,
        verdict=verdict_if(drifts[LUGRE] > RESTS * runs[LUGRE].width),
        found=findings,
        draw=lambda: _draw(runs, drifts),
        origin=setting.origin,
        numbers={"drift_per_cycle": drifts},
    )


def figure_3(setting: Setting) -> Reproduced:
    """Return figure 3: closed orbits of the rig, by its torque sensor and by its friction."""
    bench = bench_of(setting)
    setting.contact(RIG)
    runs = {name: rippled(setting, model) for name, model in setting.contacts.items()}
    drifts = {name: float(np.mean(run.settled)) for name, run in runs.items()}
    shares = {name: abs(drifts[name]) / run.width for name, run in runs.items()}
    sensed = runs[RIG].sensed
    start = int(runs[RIG].cycles[0])
    assert sensed is not None
    ripple, push = (
        sensor_numbers([Sensed(*(torque[part] for torque in sensed))])
        for part in (slice(start, None), slice(start))
    )
    torques = {"friction": sensed.friction, SENSOR: sensed.read}
    # The work of each torque in each cycle of the second half [J].
    turned = (torque * np.diff(runs[RIG].x) / setting.arm for torque in torques.values())
    dissipated, enclosed = (
        np.add.reduceat(work, runs[RIG].cycles[:-1])[-runs[RIG].settled.size :] for work in turned
    )
    return Reproduced(
        number=3,
        verdict=verdict_if(max(shares.values()) < RESTS, "built in"),
        found=[
            *(f"{name}: {_drift(run, shares[name])}." for name, run in runs.items()),
            sensor_says(bench, ripple, "During the torque ripple"),
            f"Friction dissipates {spread(1e6 * dissipated)} µJ per cycle. The orbit of the torque sensor encloses "
            f"{spread(1e6 * enclosed)} µJ, because its filter lags.",
            f"While the rig is pushed beyond break-away, its error is up to {percent(push['apart'])} of the largest friction.",
        ],
        draw=lambda: _draw(runs, drifts, runs[RIG]),
        origin=setting.origin,
        numbers={"drift_per_cycle": drifts, "share_of_the_orbit": shares, "torque_sensor": ripple}
        | {
            "torque_sensor_at_break_away": push,
            "work_of_friction": dissipated,
            "work_by_torque_sensor": enclosed,
        },
    )


def _drift(run: Rippled, share: float) -> str:
    """Return the drift in a cycle and the width of the orbit, as text; `share` is their ratio."""
    step = "no drift"
    if share > 1e-5:
        step = f"{spread(1e9 * run.settled)} nm"
    return f"{step} per cycle, on an orbit {with_unit(run.width, 'm')} wide"


def _draw(runs: dict[str, Rippled], drifts: dict[str, float], measured: Rippled | None = None):
    """Draw the driving torque and the response; for a `measured` rig also the reading of the torque sensor."""
    first = next(iter(runs.values()))
    start = int(first.cycles[0])
    end = int(first.cycles[1])
    widest = max(run.width for run in runs.values())
    traces = {}
    titles = {}
    close_up = None
    if measured is not None and measured.sensed is not None:
        traces[SENSOR] = _since(measured, measured.sensed.read, start)
        titles[SENSOR] = f"{RIG}, {SENSOR}"
        last = int(first.cycles[-2])
        torques = {"friction": measured.sensed.friction, SENSOR: measured.sensed.read}
        close_up = (
            f"{RIG}, last cycle less a line",
            {name: _since(measured, torque, last) for name, torque in torques.items()},
        )
    for name, run in runs.items():
        traces[name] = _since(run, run.torque, start)
        step = "no drift"
        if abs(drifts[name]) > RESTS * widest:
            step = f"{with_unit(drifts[name], 'm')} a cycle"
        titles[name] = f"{name}: {step}"
        if run is measured:
            titles[name] = f"{name}, friction: {step}"
    return ripple(
        first.time,
        first.driving,
        traces,
        end - start,
        titles,
        "translational",
        "rotational",
        close_up=close_up,
    )


def _since(run: Rippled, torque: np.ndarray, start: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the displacement since the start of the ripple [m], and a torque [N*m], from a sample on."""
    return run.x[start : torque.size] - run.x[run.cycles[0]], torque[start:]
