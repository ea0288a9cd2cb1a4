"""Slip laws: the share of the motion that is lost to slip, and how it rises."""

import numpy as np
import pytest

from bristle.models.friction.slip_law import SlipLaw, slip, slip_point, slip_weight

RATIOS = np.linspace(-1.3, 1.3, 131).tolist()
LAWS = {
    "gate": SlipLaw(0.6, 1.0, 1.0),
    "linear": SlipLaw(-1.0, 1.0, 1.0),
    "fourth power": SlipLaw(-1.0, 4.0, 1.0),
    "odd power": SlipLaw(-1.0, 2.7, 1.0),
    "unloading without slip": SlipLaw(-1.0, 3.0, 0.0),
    "unloading with some": SlipLaw(-1.0, 2.0, 0.4),
}


@pytest.mark.parametrize("name", LAWS)
def test_slip_and_slope_together_equal_each_alone(name):
    law, h = LAWS[name], 1e-6
    for r in RATIOS:
        value, slope = slip_point(r, law)
        assert value == pytest.approx(slip(r, law), rel=1e-15, abs=1e-300)
        if min(abs(r), abs(r - 1.0), abs(r - law.rho)) > h:
            assert slope == pytest.approx(
                (slip(r + h, law) - slip(r - h, law)) / (2.0 * h), rel=1e-7, abs=1e-7
            )


@pytest.mark.parametrize("name", LAWS)
def test_in_steady_sliding_all_of_the_motion_slips(name):
    assert slip(1.0, LAWS[name]) == 1.0
    assert slip_point(1.0, LAWS[name])[0] == 1.0
    assert slip_weight(0.5, 2.0, LAWS[name]) == pytest.approx(
        max(LAWS[name].exponent, 1.0), rel=1e-15
    )


def test_an_unloading_contact_slips_backward_by_its_share():
    law = LAWS["unloading with some"]
    assert slip(-0.5, law) == slip_point(-0.5, law)[0] == -0.4 * 0.25
    assert slip_point(-0.5, law)[1] == 0.4 * 2.0 * 0.5
    assert slip(-0.5, LAWS["gate"]) == 0.0
