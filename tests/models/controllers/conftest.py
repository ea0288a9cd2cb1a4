"""Fixtures of the tests of control laws."""

import pytest
from benchmarks.independent import follow, harmonic, sliders

from bristle import controllers


@pytest.fixture(scope="session")
def compiled_axis():
    """The axis that shares no code with bristle is compiled."""
    follow(
        controllers.sliding_mode(J=600.0, lambda_=1.0, K_1=1.0), sliders(7), harmonic([], 0.01), 0
    )
