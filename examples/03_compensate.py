"""Compare a loop without friction compensation, with a crude friction model, and with the exact friction model."""

import bristle as br
from bristle.core.experiment import Experiment, Feedforward, Run, Variant

axis = br.friction.lugre(F_C=20.0, F_S=28.0, v_S=2e-3, sigma_0=1e7, sigma_1=1e3, sigma_2=200.0)
exact = Feedforward(mass=28.0, friction=axis)
crude = Feedforward(mass=28.0, friction=br.friction.coulomb(F_C=14.0))


def loop(name: str, feedforward: Feedforward) -> Variant:
    return Variant(
        name=name,
        plant=br.plants.inertia(M=28.0),
        friction=axis,
        controller=br.controllers.cascade(k_p=60.0, k_v=6700.0, k_ff=1.0),
        sensor=br.sensors.encoder(resolution=1e-7),
        reference=br.references.sine(amplitude=0.005, frequency=0.5),
        feedforward=feedforward,
        run=Run(duration=8.0, sample_time=1e-3, settle=2.0),
    )


variants = (loop("none", Feedforward(mass=28.0)), loop("crude", crude), loop("exact", exact))
result = br.simulate(Experiment("sine", "translational", variants))
for name, one in result.variants.items():
    print(
        f"{name}: {1e6 * one.following_error.peak_to_peak:.2f} um peak to peak, {one.status.sentence}"
    )
