"""Simulated axes of the score board: their parameters or their friction are drawn by the seed of the table."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.board.record import Data, Record
from bristle import controllers, friction, plants, references, sensors
from bristle.apps.paper.robust.loops import log_of, loop, peak_to_peak, setting
from bristle.apps.paper.robust.truths import SIMULATED, truths_named
from bristle.core import Axis, Experiment, Feedforward, Model, Run, Variant
from bristle.simulation import simulate

# [s, m, m] of the known axes; with a coarser encoder, vibrations of the loop let LuGre creep
DT, RESOLUTION, NOISE = (1e-3, 10e-9, 2e-9)
CUTOFF = 60.0  # [Hz]
BANDWIDTH = 150.0  # [1/s] of their position loop; that of the velocity loop is twice as high


def cases_of(table: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the names of the simulated axes of a task."""
    numbers = [str(number) for number in range(1, table["cases"] + 1)]
    return (
        tuple(numbers)
        if table["simulated"] == "known"
        else tuple(f"{truth} {number}" for truth in SIMULATED for number in numbers)
    )


def simulated(table: Mapping[str, Any], case: str, seed: int) -> Data:
    """Return the data of a simulated axis."""
    rng = np.random.default_rng([seed, zlib.crc32(case.encode())])
    drawn = {
        name: float(np.exp(rng.uniform(*np.log(ends)))) for name, ends in table["draw"].items()
    }
    return (_with_parameters if table["simulated"] == "known" else _in_presliding)(case, drawn, rng)


def _with_parameters(case: str, drawn: Mapping[str, float], rng: np.random.Generator) -> Data:
    """Return the logs of an axis with LuGre friction, its parameters, and the loop along a second motion."""
    mass, damping = drawn["M"], 0.4 * np.sqrt(drawn["sigma_0"] * drawn["M"])
    truth: dict[str, Any] = {name: drawn[name] for name in ("F_C", "v_S", "sigma_0", "sigma_2")} | {
        "F_S": drawn["F_C"] * drawn["stribeck"]
    }
    contact = friction.find("lugre")(**truth, sigma_1=damping)
    law = controllers.cascade(k_p=BANDWIDTH, k_v=2.0 * BANDWIDTH * mass)
    axis = Axis(
        kind="translational",
        resolution=RESOLUTION,
        cutoff=CUTOFF,
        decimation=5,
        held=True,
        controller=law,
    )
    records, desired = [], []
    for shift in (0.0, 0.31):  # the second motion has other amplitudes and frequencies
        reference = _motion(shift)
        result = _followed(
            plants.inertia(M=mass), contact, law, reference, int(rng.integers(2**31 - 1))
        )
        time = DT * np.arange(reference.size)
        records.append(Record.of(time, result.measured, result.command, axis))
        desired.append(Record.of(time, reference, None, axis))
    return Data(
        [records[0]],
        [records[1]],
        desired[1],
        desired[1].position - records[1].position,
        mass,
        truth | {"M": mass},
    )


def _motion(shift: float) -> np.ndarray:
    """Return a motion [m]: fast sines, slow triangles through the Stribeck velocity, and decaying micrometres."""
    t = DT * np.arange(12_000)
    fade = np.minimum(1.0, np.minimum(t, t[::-1]))  # each part begins and ends at rest
    fast = 0.02 * fade * np.sin(np.pi * (1.0 - 0.5 * shift) * t) + 2e-3 * fade * np.sin(
        2.0 * np.pi * (1.9 + shift) * t
    )
    slow = 4e-3 * (1.0 - 0.4 * shift) * np.abs((t / (4.0 + shift)) % 2.0 - 1.0)
    fine = 20e-6 * fade * np.exp(-0.2 * t) * np.sin(2.0 * np.pi * (0.5 + 0.2 * shift) * t)
    return np.concatenate([fast, slow - slow[0], slow[-1] - slow[0] + fine])


def _followed(plant: Model, contact: Model, law: Model, reference: np.ndarray, seed: int) -> Any:
    """Return the result of a loop along a reference."""
    run = Run(duration=DT * reference.size, sample_time=DT)
    sensor = sensors.encoder(resolution=RESOLUTION, noise=NOISE, seed=seed)
    desired = references.recorded(position=reference, sample_time=DT)
    variant = Variant("axis", plant, contact, law, sensor, desired, Feedforward(), run)
    return simulate(Experiment("axis", plant.kind, (variant,))).variants["axis"]


def _in_presliding(case: str, drawn: Mapping[str, float], rng: np.random.Generator) -> Data:
    """Return the log of an axis in pre-sliding, and the loop that a feedforward compensates."""
    (truth,) = truths_named([case.split()[0]])
    contact = truth.friction.with_values(**drawn, wavelength=float(rng.uniform(4e-6, 12e-6)))
    log, axis = log_of(replace(truth, friction=contact))
    variant = loop(
        setting("set_c")["none"], contact.with_values(seed=int(rng.integers(2**30))), None
    )
    without = peak_to_peak(variant, 0)
    run, plain = variant.run, replace(axis, columns={}, text=b"")
    time = run.sample_time * np.arange(round(run.duration / run.sample_time))
    position = np.asarray(variant.reference.component.sample(time, variant.reference.parameters)[0])

    def left(law: Model | None, effort: np.ndarray | None) -> float:
        # The controller knows a feedforward ahead by its delay.
        ahead = (
            None
            if effort is None
            else np.append(effort[run.delay :], np.full(run.delay, effort[-1]))
        )
        return (
            peak_to_peak(replace(variant, controller=law or variant.controller, injected=ahead), 0)
            / without
        )

    assert log.effort is not None
    train = Record.of(log.time.values, log.position.values, log.effort.values, plain)
    desired = Record.of(time, position, None, replace(plain, controller=variant.controller))
    return Data([train], reference=desired, left=left)
