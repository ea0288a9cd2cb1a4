"""A small compensated loop that errs by everything a loop can err by."""

from dataclasses import replace

import pytest

from bristle import controllers, friction, plants, references, sensors
from bristle.apps.design import design
from bristle.core.experiment import Experiment, Feedforward, Run, Variant

SLIDING = {"v_S": 5e-3, "sigma_0": 5e6, "sigma_1": 1e3}
TRUTH = friction.find("lugre+asymmetry")(
    F_C_pos=24.0,
    F_C_neg=16.0,
    F_S_pos=30.0,
    F_S_neg=22.0,
    sigma_2_pos=100.0,
    sigma_2_neg=100.0,
    offset=2.0,
    **SLIDING,
)
COMPENSATOR = friction.lugre(F_C=18.0, F_S=22.0, sigma_2=80.0, **SLIDING)


def loop(name="fed", compensator=COMPENSATOR, **changed):
    parts = {
        "plant": plants.inertia(M=20.0),
        "friction": TRUTH,
        "controller": controllers.cascade(k_p=80.0, k_v=4000.0, k_ff=1.0),
        "sensor": sensors.encoder(resolution=1e-6),
        "reference": references.sine(amplitude=5e-3, frequency=0.5),
        "feedforward": Feedforward(mass=20.0, friction=compensator),
        "run": Run(4.0, 1e-3, delay=1, settle=1.0),
    } | changed
    of_axis = {
        part: replace(parts[part], kind=parts["plant"].kind)
        for part in ("friction", "controller", "sensor", "reference")
    }
    return Variant(name=name, **(parts | of_axis))


@pytest.fixture(scope="session")
def designed():
    return design(Experiment("bench", "translational", (loop("plain", None), loop())))
