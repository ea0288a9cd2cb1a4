r"""Gains for a loop: as high as its delay allows, none higher than its encoder stands.

Each law has one number that all its gains follow from, the bandwidth :math:`\omega`:

=================== ======================================================================================
cascade             :math:`k_v = M\omega,\ k_p = \omega/4,\ k_i = k_v\,\omega/10` where it has an integral
sliding mode        :math:`\lambda = \omega,\ K_1 = \tfrac23\omega,\ K_2/\phi = \tfrac13\omega`; :math:`\phi` is
                    what one count of the encoder makes of the surface, so that no count leaves the layer
disturbance         :math:`\lambda = K_1 = \omega,\ g = \omega/5`
observer
=================== ======================================================================================

:math:`\omega` is the largest with which the exact sampled loop keeps a phase margin of 40 degrees and a factor of two
on its gain. With 0.5 ms more lag of the current loop than is stated, 30 degrees and the same factor must be left. No
current loop is without a lag: where none is stated, the margins must hold from 0.2 to 1 ms. The rule of thumb
:math:`(\lambda + K_1)\,T_\text{tot} \lesssim \tfrac12` is close to that.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from bristle.controllers import CONTROLLERS
from bristle.core.contracts import Model, make_model
from bristle.core.experiment import Variant
from bristle.stability import SampledLoop, margins_of
from bristle.stability.linear_plant import linear_plant
from bristle.stability.linear_system import LARGE, SMALL, linear_law
from bristle.stability.measured_feedforward import Stiffness

__all__ = ["PHASE", "UNSTATED", "Tuned", "count_response", "inertia_of", "lagging", "stiffness_of", "tuned"]

PHASE, GAIN = 40.0, 2.0  # margins that the loop is to keep: degrees, and a factor
UNSTATED = (2e-4, 1e-3)  # lags of a current loop that nobody stated: the least and the largest [s]
FURTHER, PHASE_LATE = 5e-4, 30.0  # more lag than is stated [s], and the phase margin that is left then [deg]
WIDEST, NARROWEST = 3.0, 1e-4  # bandwidths that are tried, in 1/sample time
COARSE, HALVINGS = 1.25, 12
RESPONSE = 50  # samples after a count

Gains = Callable[[float, Mapping[str, Any], Variant], dict[str, Any]]


class Tuned(NamedTuple):
    """A control law, and the bandwidth that its gains follow from [rad/s]."""

    law: Model
    bandwidth: float


def tuned(variant: Variant, name: str, bandwidth: float | None = None) -> Tuned | None:
    """Return a control law with the gains that a loop allows it.

    Parameters
    ----------
    variant : Variant
        The loop. What of its own law is no gain, such as the cut-off of its velocity, is kept.
    name : str
        Name of the law.
    bandwidth : float, optional
        No more than this [rad/s]; by default as much as the margins allow.

    Returns
    -------
    Tuned or None
        None for a law that no gains are known for, or where no gains keep the margins.
    """
    if name not in GAINS:
        return None

    def law(omega: float) -> Model:
        component = CONTROLLERS[name]
        own = {key: value for key, value in variant.controller.values.items() if key in component.variables}
        fixed = {"J": inertia_of(variant)} | own if "J" in component.variables else own
        gains = GAINS[name](omega, fixed, variant)
        return make_model(component, fixed | gains, kind=variant.plant.kind, validate=True)

    run = variant.run
    plants = [
        (amplitude, phase, linear_plant(lagging(variant, lag), amplitude))
        for lag, phase in _lags(run.current_lag)
        for amplitude in (SMALL, LARGE)
    ]

    def keeps_margins(omega: float) -> bool:
        controllers = {amplitude: linear_law(law(omega), run.sample_time, amplitude) for amplitude in (SMALL, LARGE)}
        return all(
            _is_safe(SampledLoop(plant, controllers[amplitude], run.delay, run.sample_time), phase) for amplitude, phase, plant in plants
        )

    if bandwidth is not None and keeps_margins(bandwidth):
        return Tuned(law(bandwidth), bandwidth)
    widest = _widest(keeps_margins, 1.0 / run.sample_time, bandwidth)
    return None if widest is None else Tuned(law(_round(widest)), _round(widest))


def lagging(variant: Variant, lag: float) -> Variant:
    """Return a loop with another lag of its current control [s]."""
    return replace(variant, run=replace(variant.run, current_lag=lag))


def _lags(stated: float) -> tuple[tuple[float, float], ...]:
    """Return lags of the current loop [s], each with the phase margin [deg] that a loop must keep there."""
    if stated > 0.0:
        return (stated, PHASE), (stated + FURTHER, PHASE_LATE)
    return tuple((lag, PHASE) for lag in UNSTATED)


def _is_safe(loop: SampledLoop, phase: float) -> bool:
    if loop.is_unstable:
        return False
    margins = margins_of(loop)
    return margins.phase is not None and margins.phase >= phase and (margins.gain is None or margins.gain >= GAIN)


def _widest(keeps: Callable[[float], bool], rate: float, most: float | None) -> float | None:
    """Return the largest bandwidth that keeps the margins, found from above."""
    high = WIDEST * rate if most is None else min(WIDEST * rate, most)
    while not keeps(high / COARSE):
        high /= COARSE
        if high < NARROWEST * rate:
            return None
    low = high / COARSE
    for _ in range(HALVINGS):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if keeps(middle) else (low, middle)
    return low


def _round(value: float) -> float:
    """Return a number to two digits, rounded down."""
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return step * math.floor(value / step)


def _cascade(bandwidth: float, fixed: Mapping[str, Any], variant: Variant) -> dict[str, Any]:
    k_v = inertia_of(variant) * bandwidth
    integral = fixed.get("k_i", 0.0) > 0.0
    return {"k_v": k_v, "k_p": 0.25 * bandwidth, "k_i": 0.1 * k_v * bandwidth if integral else 0.0}


def _sliding_mode(bandwidth: float, fixed: Mapping[str, Any], variant: Variant) -> dict[str, Any]:
    if fixed.get("K_2", 0.0) == 0.0:
        return {"lambda_": bandwidth, "K_1": bandwidth}
    count, dt = variant.sensor.values.get("resolution", 0.0), variant.run.sample_time
    # With these gains the effort of the law is the velocity that it estimates.
    estimate = dict(fixed, J=1.0, lambda_=0.0, K_1=1.0, K_2=0.0)
    bare = make_model(CONTROLLERS["sliding_mode"], estimate, kind=variant.plant.kind, validate=True)
    surface = count * (bandwidth + float(np.max(np.abs(_step_response(bare, dt)))))
    phi = max(surface, fixed.get("phi", 0.0))
    return {"lambda_": bandwidth, "K_1": bandwidth / 1.5, "K_2": phi * bandwidth / 3.0, "phi": phi}


def _disturbance_observer(bandwidth: float, fixed: Mapping[str, Any], variant: Variant) -> dict[str, Any]:
    return {"lambda_": bandwidth, "K_1": bandwidth, "g": 0.2 * bandwidth}


GAINS: dict[str, Gains] = {"cascade": _cascade, "sliding_mode": _sliding_mode, "disturbance_observer": _disturbance_observer}


def inertia_of(variant: Variant) -> float:
    """Return the mass or inertia that the effort moves, as it shows well below the sample rate [kg or kg*m^2]."""
    run = variant.run
    plant = linear_plant(variant, LARGE)
    omega = 1e-2 / run.sample_time
    return float(1.0 / (omega**2 * np.abs(plant.response(np.exp([1j * omega * run.sample_time]))[0])))


def stiffness_of(controller: Model, dt: float, amplitude: float = LARGE) -> float:
    """Return the effort over a deviation that lasts [N/m or N*m/rad], without end for a law with an integral."""
    return Stiffness.of(linear_law(controller, dt, amplitude), 0.0, 0.0).law


def count_response(variant: Variant) -> float:
    """Return the effort that one count of the encoder calls up, at its peak [N or N*m]."""
    count = variant.sensor.values.get("resolution", 0.0)
    peaks = np.abs(_step_response(variant.controller, variant.run.sample_time, SMALL))
    return float(count * np.max(peaks))


def _step_response(controller: Model, dt: float, amplitude: float = LARGE) -> np.ndarray:
    """Return the effort of a law after the position has stepped by 1, shape (RESPONSE,)."""
    law = linear_law(controller, dt, amplitude)
    state, outputs = np.zeros(law.B.size), []
    for _ in range(RESPONSE):
        outputs.append(law.C @ state + law.D)
        state = law.A @ state + law.B
    return np.array(outputs)
