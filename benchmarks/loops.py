"""Logs of a closed loop whose friction is known: what its controller recorded, and what can be found in it."""

from __future__ import annotations

import numpy as np

from benchmarks.legs import Leg, along
from benchmarks.scattering import scattering
from bristle import controllers, plants, sensors
from bristle.core import Axis, Model
from bristle.core.experiment import substeps_for
from bristle.engine import run_closed_loop
from bristle.logs.log import Channel, Log

__all__ = ["AXIS", "LAW", "MASS", "recorded_in_loop"]

MASS = 20.0  # kg
ENCODER, DT = 0.125e-6, 1e-3  # m, s
# Of the level of friction from reversal to reversal; of the largest friction.
SCATTER, NOISE = (0.05, 0.005)
FINER = 8  # times as many steps as an identification takes
LAW = controllers.cascade(k_p=120.0, k_v=6000.0, k_i=2e5)
AXIS = Axis(resolution=ENCODER, controller=LAW, method="output_error", held=True)
SPEEDS = (1e-3, 4e-3, 20e-3, 2e-3, 40e-3, 10e-3)
SMALL = (6e-6, 18e-6, 12e-6)


def _reference(pairs: int) -> np.ndarray:
    """Strokes at several speeds, in turn with small ones about one place."""
    legs, centre = [Leg(4e-3, 10e-3)], 4e-3
    for number in range(pairs):
        small = number % 3 == 2
        reach = (
            SMALL[number // 3 % len(SMALL)]
            if small
            else max(0.1e-3, 0.1 * SPEEDS[number % len(SPEEDS)])
        )
        speed = 60e-6 if small else SPEEDS[number % len(SPEEDS)]
        legs += [Leg(centre + reach, speed), Leg(centre - reach, speed), Leg(centre, speed)]
    return along(legs, 0.2, DT).position


def recorded_in_loop(
    truth: Model,
    seed: int,
    pairs: int = 12,
    scatter: float = SCATTER,
    encoder: float = ENCODER,
    noise: float = NOISE,
    lag: float = 0.0,
    pulses: float = 0.0,
) -> Log:
    """Return the log of an axis that follows strokes: effort as the controller asks for it, read with noise.

    The level of friction is another one after each reversal, and the axis is integrated much more finely than an
    identification does.
    """
    rng, reference = np.random.default_rng(seed), _reference(pairs)
    reference = reference + rng.uniform(0.0, encoder)
    velocity = np.gradient(reference, DT)
    desired = np.stack([reference, velocity, np.gradient(velocity, DT), np.zeros(reference.size)])
    injected = pulses * (np.arange(reference.size) % 2000 < 60)

    acting = scattering(truth, scatter, seed) if scatter else truth
    trace = run_closed_loop(
        plants.inertia(M=MASS),
        acting,
        LAW,
        sensors.encoder(resolution=encoder),
        desired,
        DT,
        steps=FINER * substeps_for(DT),
        injected=injected,
        lag=lag,
        x=reference[0],
    )
    effort = trace.command + noise * np.max(np.abs(trace.friction)) * rng.standard_normal(
        reference.size
    )
    return Log(
        time=Channel(trace.time, "s", "t"),
        position=Channel(trace.measured, "m", "q"),
        effort=Channel(effort, "N", "u"),
        reference=Channel(reference, "m", "r"),
        injected=(Channel(injected, "N", "pulses"),),
        sample_time=DT,
        segments=(slice(0, reference.size),),
    )
