"""The loop of the source paper on its rig."""

import math

from bristle import controllers, friction, plants, references, sensors
from bristle.core.experiment import Feedforward, Run, Variant

RADIAN = 2e-3 * math.pi / 5.0  # of the screw, for a micrometre of the table


def rig(
    delay,
    *,
    slope=340.0,
    gain=340.0,
    switching=5e3 * RADIAN,
    layer=20.0 * RADIAN,
    limit=1.0,
    model=None,
):
    """The rig of the source paper: 4e-4 kg m^2, 2 kHz, current lag 0.2 ms."""
    law = controllers.sliding_mode(
        kind="rotational",
        J=4e-4,
        lambda_=slope,
        K_1=gain,
        K_2=switching,
        phi=layer,
        cutoff=400.0,
        limit=limit,
    )
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
