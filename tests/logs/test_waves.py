"""Waves over the position."""

import numpy as np
import pytest

from bristle.logs.waves import frequency_in


def test_waves_that_turn_with_the_side_of_motion_are_found_with_the_side_only():
    x, side = np.linspace(0.0, 1.0, 4000), np.where(np.arange(4000) % 2 == 0, 1.0, -1.0)
    residual = side * np.cos(2.0 * np.pi * 17.0 * x)
    assert frequency_in(x, side, residual, 60.0) == pytest.approx(17.0, rel=1e-3)
    assert frequency_in(x, None, residual, 60.0) != pytest.approx(17.0, rel=1e-3)
