"""The kind of axis and magnitudes change only the units of a result."""

import numpy as np
import pytest
from tests.identification.known_logs import STATED, Motion, log_of, slow_log

from bristle import friction
from bristle.core import InputError
from bristle.identification import identify

pytestmark = pytest.mark.usefixtures("of_one_mass")

# By what the parameters change where lengths are multiplied by the first number and forces by the second.
POWERS = {
    "M": (-1, 1),
    "F_C": (0, 1),
    "F_S": (0, 1),
    "F_v": (-1, 1),
    "sigma_2": (-1, 1),
    "v_S": (1, 0),
    "sigma_0": (-1, 1),
    "offset": (0, 1),
}


TRUTHS = {
    "coulomb_viscous": {"F_C": 8.0, "F_v": 30.0, "offset": 0.5},
    "stribeck": {"F_C": 8.0, "F_S": 11.0, "v_S": 4e-3, "F_v": 30.0, "offset": 0.5},
    "lugre": {"F_C": 8.0, "F_S": 11.0, "v_S": 4e-3, "sigma_0": 1e5, "sigma_1": 60.0, "sigma_2": 30.0, "offset": 0.5},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", list(TRUTHS))
def test_magnitudes_scale(name):
    log = slow_log(friction.find(name)(**TRUTHS[name]), duration=10.0)
    length, force = 2.0**9, 2.0**-12
    motion = Motion(log.time.values, length * log.position.values, log.position.values, log.position.values)
    small = log_of(motion, force * log.effort.values, kind="rotational")
    item, other = identify(log, name, blocks=0, draws=0).best, identify(small, name, blocks=0, draws=0).best
    assert other.force_error_percent == pytest.approx(item.force_error_percent, rel=1e-4)
    for parameter, estimate in item.parameters.items():
        if parameter not in POWERS:
            continue
        of_length, of_force = POWERS[parameter]
        scale = length**of_length * force**of_force
        scaled = other.parameters[parameter]
        assert scaled.value == pytest.approx(scale * estimate.value, rel=2e-3), parameter
        assert scaled.std == pytest.approx(scale * estimate.std, rel=0.02), parameter
        assert scaled.status == estimate.status
    assert other.parameters["M"].unit == "kg*m^2"
    assert other.parameters["F_C"].unit == "N*m"
    assert other.plant.kind == other.friction.kind == "rotational"


def test_a_log_of_impossible_extent_is_reported_with_its_units():
    log = slow_log(friction.find("stribeck")(**TRUTHS["stribeck"]), duration=10.0)
    slow = Motion(1e11 * log.time.values, log.position.values, log.position.values, log.position.values)
    with pytest.raises(InputError, match=r"v_S: would have the range .* for the extent of this log.* units of time"):
        identify(log_of(slow, log.effort.values), "stribeck", blocks=0, draws=0)


def test_reversing_the_axis_exchanges_the_directions():
    truth = friction.find("coulomb_viscous+asymmetry")(F_C_pos=9.0, F_C_neg=6.0, F_v_pos=20.0, F_v_neg=40.0)
    log = slow_log(truth, duration=5.0)
    motion = Motion(log.time.values, -log.position.values, log.position.values, log.position.values)
    turned = log_of(motion, -log.effort.values)
    name = "coulomb_viscous+asymmetry"
    item, other = (identify(entry, name, axis=STATED, blocks=0, draws=0).best.friction.values for entry in (log, turned))
    for parameter in ("F_C", "F_v"):
        assert other[f"{parameter}_pos"] == pytest.approx(item[f"{parameter}_neg"], rel=1e-9)
        assert other[f"{parameter}_neg"] == pytest.approx(item[f"{parameter}_pos"], rel=1e-9)
    assert np.isfinite(list(item.values())).all()
