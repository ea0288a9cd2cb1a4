"""Fixtures of the tests of friction models and plants."""

import pytest

from bristle.engine import interpreted


@pytest.fixture
def in_plain_python():
    """Nothing is compiled: for motions of so few steps that the compiler would take longer."""
    with interpreted():
        yield
