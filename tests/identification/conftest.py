"""What tests of identification share."""

from importlib import import_module

import pytest


@pytest.fixture(scope="module")
def of_one_mass():
    """Logs of a file are of one mass: the search for an elastic coupling takes most of the time of a quick fit."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(import_module("bristle.identification.identify"), "elastic_coupling", lambda *_: None)
        yield
