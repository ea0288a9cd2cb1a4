"""Bands around the effort along a measured motion: the width of each known source."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import TRUTH, log_of, sines, sliding_effort

from bristle import friction, plants
from bristle.identification.simulated_bands import Bands
from bristle.prediction import predict

NOISE = 0.3
PLANT = plants.inertia(M=TRUTH["M"])
FRICTION = friction.coulomb_viscous(**{name: TRUTH[name] for name in ("F_C", "F_v")})


# Bands of a model that is known exactly, and has no noise.
CERTAIN = Bands({name: np.full(40, TRUTH[name]) for name in ("M", "F_C", "F_v")}, scatter=0.0, noise=0.0, unexplained=0.0)


@pytest.fixture(scope="module")
def log():
    motion = sines(6.0)
    return log_of(motion, sliding_effort(motion, noise=NOISE, offset=0.0))


@pytest.mark.parametrize(("cutoff", "decimation"), [(100.0, 10), (100.0, 1), (30.0, 5), (200.0, 2)])
def test_bands_of_noise_contain_19_of_20_rows(log, cutoff, decimation):
    assert (
        92.0
        < predict(PLANT, FRICTION, log, cutoff=cutoff, decimation=decimation, bands=replace(CERTAIN, noise=NOISE)).inside_percent
        < 98.0
    )


def test_unexplained_force_and_uncertainty_add_their_squares(log):
    levels = TRUTH["F_C"] + np.random.default_rng(0).normal(0.0, 0.5, 40)
    lacking, unsure, both = (
        np.median(predict(PLANT, FRICTION, log, bands=replace(CERTAIN, **changes)).half_width)
        for changes in (
            {"unexplained": 0.7},
            {"draws": CERTAIN.draws | {"F_C": levels}},
            {"unexplained": 0.7, "draws": CERTAIN.draws | {"F_C": levels}},
        )
    )
    assert lacking == pytest.approx(1.96 * 0.7, rel=1e-3)
    # Sliding, the force is as unsure as its level.
    assert unsure == pytest.approx(1.96 * np.std(levels, ddof=1), rel=0.02)
    assert both == pytest.approx(np.hypot(lacking, unsure), rel=1e-3)


def test_bands_of_a_scattering_level_are_as_wide_as_its_friction(log):
    half_width = predict(PLANT, FRICTION, log, bands=replace(CERTAIN, scatter=0.05)).half_width
    assert np.median(half_width) == pytest.approx(1.96 * 0.05 * TRUTH["F_C"], rel=0.15)
