"""Simulate a loop on a series of axes with different friction, on all cores, with one process for each core."""

from concurrent.futures import ProcessPoolExecutor

import numpy as np

import bristle as br
from bristle.core.experiment import Experiment, Feedforward, Run, Variant

NOMINAL = br.friction.lugre(F_C=20.0, F_S=28.0, v_S=2e-3, sigma_0=1e7, sigma_1=1e3, sigma_2=200.0)


def axis(generator: np.random.Generator) -> Experiment:
    """Return an axis with friction within 15 % and stiffness within 30 %, compensated by the nominal model."""
    level, stiffness = generator.uniform(0.85, 1.15), generator.uniform(0.7, 1.3)
    loop = Variant(
        name="compensated",
        plant=br.plants.inertia(M=28.0),
        friction=NOMINAL.with_values(F_C=20.0 * level, F_S=28.0 * level, sigma_0=1e7 * stiffness),
        controller=br.controllers.cascade(k_p=60.0, k_v=6700.0, k_ff=1.0),
        sensor=br.sensors.encoder(resolution=1e-7),
        reference=br.references.sine(amplitude=0.005, frequency=0.5),
        feedforward=Feedforward(mass=28.0, friction=NOMINAL),
        run=Run(duration=20.0, sample_time=1e-3, settle=2.0),
    )
    return Experiment("series", "translational", (loop,))


if __name__ == "__main__":  # worker processes import this file, too, and must not run this part
    experiments = [axis(np.random.default_rng(seed)) for seed in range(100)]
    br.simulate(experiments[0])  # compiles the kernels, once for all processes
    with ProcessPoolExecutor() as pool:
        results = list(pool.map(br.simulate, experiments, chunksize=10))
    errors = [1e6 * one.variants["compensated"].following_error.peak_to_peak for one in results]
    print(
        f"following error of {len(errors)} axes: {min(errors):.2f} to {max(errors):.2f} um peak to peak"
    )
