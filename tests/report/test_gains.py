"""Gains in the units of the motor."""

from types import SimpleNamespace

import pytest

from bristle.controllers import cascade
from bristle.core.axis import Axis
from bristle.report.loops import controller_text

ARM = 0.8e-3  # m/rad


@pytest.mark.parametrize("arm", [ARM, None])
def test_gain_of_a_screw_is_also_given_at_the_motor(arm):
    law = cascade(k_p="120 1/s", k_v="5000 N*s/m", k_i="250000 N/m")
    variant = SimpleNamespace(controller=law, feedforward=SimpleNamespace(mass=0.0), axis=Axis(arm=arm))
    (line,) = [line for line in controller_text(variant).splitlines() if line.startswith("k_v")]
    gain, _, at_motor = line.partition(" # ")
    assert gain == 'k_v = "5000 N*s/m"'
    assert at_motor == (f"{5000.0 * ARM**2:.4g} N*m*s/rad at the motor" if arm else "")


def test_law_lines_are_valid_in_an_experiment_file():
    import tomllib

    law = cascade(k_p="120 1/s", k_v="5000 N*s/m", k_i="250000 N/m")
    variant = SimpleNamespace(controller=law, feedforward=SimpleNamespace(mass=3.0), axis=Axis(arm=ARM))
    assert tomllib.loads(controller_text(variant))["controller"]["k_v"] == "5000 N*s/m"
