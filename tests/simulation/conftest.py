"""Fixtures of the tests of simulations."""

import pytest

from bristle.engine import interpreted


@pytest.fixture
def in_plain_python():
    """Nothing is compiled: for loops of so few steps that the compiler would take longer."""
    with interpreted():
        yield
