"""A control law of one's own: proportional-derivative in the surface, stronger inside a boundary layer."""

import math
from typing import Annotated, NamedTuple

from bristle import friction, plants, references, sensors
from bristle.core.contracts import Controller
from bristle.core.experiment import Feedforward, Run, Variant
from bristle.core.variable import Variable

RADIAN = 2e-3 * math.pi / 5.0  # of the screw, for a micrometre of the table


class Parameters(NamedTuple):
    J: Annotated[float, Variable("mass", "inertia")]
    slope: Annotated[float, Variable("1/time", "slope of the surface")]
    gain: Annotated[float, Variable("1/time", "gain outside the layer")]
    switching: Annotated[float, Variable("length/time^2", "switching gain")]
    layer: Annotated[float, Variable("length/time", "boundary layer")]
    cutoff: Annotated[float, Variable("frequency", "cut-off of the velocity")] = 400.0
    limit: Annotated[float, Variable("force", "largest effort")] = math.inf


class State(NamedTuple):
    q: Annotated[float, Variable("length", "position one sample ago")] = 0.0
    v: Annotated[float, Variable("length/time", "filtered velocity")] = 0.0
    samples: Annotated[int, Variable("1", "samples so far")] = 0


def step(state, reference, measured, dt, p):
    v = state.v - math.expm1(-2.0 * math.pi * p.cutoff * dt) * ((measured - state.q) / dt - state.v)
    e, e_dot = reference.position - measured, reference.velocity - v
    surface = e_dot + p.slope * e
    if abs(surface) >= p.layer:
        switched = 0.0 if surface == 0.0 else math.copysign(p.switching, surface)
    else:
        switched = p.switching * surface / p.layer
    wanted = p.J * (p.slope * e_dot + p.gain * surface + switched)
    return max(-p.limit, min(p.limit, wanted)), State(measured, v, state.samples + 1)


def start(measured, velocity, acceleration, dt, p):
    return State(measured, velocity, 0)


LAYERED = Controller(name="layered", description="stronger inside a layer", Parameters=Parameters, State=State, step=step, start=start)


def rig(delay, *, slope=340.0, gain=340.0, switching=5e3 * RADIAN, layer=20.0 * RADIAN, limit=1.0, model=None):
    """The rig of the source paper: 4e-4 kg m^2, 2 kHz, current lag 0.2 ms."""
    law = LAYERED(kind="rotational", J=4e-4, slope=slope, gain=gain, switching=switching, layer=layer, limit=limit)
    return Variant(
        name="rig",
        plant=plants.inertia(kind="rotational", M=4e-4),
        friction=model or friction.coulomb(kind="rotational", F_C=0.034),
        controller=law,
        sensor=sensors.encoder(kind="rotational", resolution=0.125 * RADIAN),
        reference=references.sine(kind="rotational", amplitude=6.8 * RADIAN, frequency=0.25),
        feedforward=Feedforward(),
        run=Run(28.0, 5e-4, substeps=25, delay=delay, current_lag=2e-4, effort_limit=limit),
    )
