"""The virtual rig: its two sets, its elements, and which files its models are written to."""

import numpy as np
import pytest

from bristle.files import read_model
from bristle.paper import EXPERIMENTS, rig


@pytest.mark.parametrize("name", ["set_a", "set_b"])
def test_files_of_the_sets_contain_the_friction_of_the_rig(name):
    written, made = (model.values for model in (read_model(EXPERIMENTS / f"{name}_rig.toml").friction, rig.rig_friction(*rig.SETS[name])))
    assert set(written) == set(made)
    for key, value in made.items():
        assert np.asarray(written[key]) == pytest.approx(np.asarray(value), rel=1e-9), key


def test_elements_are_uneven_in_strength_by_their_seed_alone():
    shares, distances = rig.spectrum(5, 2.0, 3)
    rho = np.array([0.15, 0.3625, 0.575, 0.7875, 1.0])
    assert distances == pytest.approx(2.0 * rho**1.6)
    weights = (distances / 2.0) ** -0.75 * np.exp(0.35 * np.random.default_rng(3).standard_normal(5)) * distances
    assert shares == pytest.approx(weights / np.sum(weights))
    assert rig.screw_ratio(0.5) == pytest.approx(12.566370614)
