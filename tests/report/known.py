"""Fits and assessments of loops with known numbers, for tests of reports."""

import math

import numpy as np

from bristle import friction, plants
from bristle.identification.estimate import Estimate
from bristle.identification.result import Fit, Traces
from bristle.simulation import Statistics, assessment, linear_system


def errors(peak, rms=0.0, mean=0.0):
    """Statistics of an error of this size, peak to peak."""
    return Statistics(peak_to_peak=peak, rms=rms, mean=mean, std=0.0, min=-peak, max=0.5 * peak)


def columns():
    """The columns of a log of an inertia with Coulomb and viscous friction."""
    t = np.arange(2500) * 1e-3
    velocity = 0.06 * np.cos(3.0 * t) + 0.11 * np.cos(11.0 * t)
    effort = 12.0 * np.gradient(velocity, t) + 5.0 * np.sign(velocity) + 80.0 * velocity
    effort += 0.1 * np.random.default_rng(1).normal(size=t.size)
    return {
        "time": t,
        "position": 0.02 * np.sin(3.0 * t) + 0.01 * np.sin(11.0 * t),
        "effort": effort,
    }


UNSTABLE = 2.5  # gain of a loop that diverges


def fit(*estimates, kind="translational", velocity=(), **changes):
    """A fit of an inertia and Coulomb friction, without a log."""
    nothing = np.zeros(len(velocity))
    known = {
        "plant": plants.inertia(kind=kind, M=12.0),
        "friction": friction.coulomb_viscous(kind=kind, F_C=8.0, F_v=30.0),
        "estimates": estimates,
        "correlation": np.zeros((0, 0)),
        "correlation_names": (),
        "condition_number": 1.0,
        "traces": Traces(nothing, np.array(velocity), *[nothing] * 4),
        "force_error_percent": 5.0,
    }
    return Fit(**known | changes)


def estimate(name, value=1.0, status="identified", half=None, **changes):
    """A parameter with a 95 % interval of given half-width in percent."""
    interval = None if half is None else ((1.0 - 0.01 * half) * value, (1.0 + 0.01 * half) * value)
    return Estimate(name, "N", "level", value, None, status, interval=interval, **changes)


def point(phase=45.0, *, gain=0.05, crossover=2.0 * math.pi * 30.0):
    """An integrator with a gain, a pole at 1 - gain, and a given phase margin [°]."""
    still = np.zeros(0)
    plant, law = (
        linear_system.LinearSystem(np.eye(1), np.ones(1), np.ones(1), 0.0),
        linear_system.LinearSystem(np.zeros((0, 0)), still, still, -gain),
    )
    made = assessment.WorkingPoint(
        assessment.Motions.ALL,
        assessment.Friction.NONE,
        linear_system.SampledLoop(plant, law, 0, 1e-3),
    )
    vars(made)["margins"] = linear_system.Margins(
        phase=phase, gain=2.5, crossover=crossover, delay=None, sensitivity=1.5
    )
    return made


def assessed(name="plain", *phases, gain=0.05, switches=False):
    """The assessment of a loop with these phase margins [°]."""
    return assessment.Assessment(
        name,
        "translational",
        tuple(point(phase, gain=gain) for phase in phases or (45.0,)),
        switches,
    )
