"""Cogging of a gimbal motor: the map of one part of a log, on another part."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bristle import identify, predict
from bristle.files.axis import read_axis
from bristle.models.plants.terms import effort_of_place

FOLDER = Path(__file__).parents[2] / "examples" / "cogging"
LOG = (
    Path(os.environ.get("BRISTLE_DATA", FOLDER.parents[2] / "shared" / "data"))
    / "cogging"
    / "speed_test1.txt"
)
PARTS = ((0.0, 7.5), (7.5, 15.0))  # no map is fed forward before 15 s
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not LOG.exists(), reason="the log of the motor is not here"),
]


def part(span, **changes):
    return replace(read_axis(FOLDER / "axis.toml"), span=span, text=b"", **changes)


@pytest.fixture(scope="module")
def fits():
    pytest.importorskip("bristle.logs.json_records", reason="stamps that come late are refused")
    return [
        identify(LOG, "coulomb_viscous", axis=part(span), draws=0, blocks=0).best for span in PARTS
    ]


def test_the_map_repeats_on_another_part(fits):
    angle = np.linspace(0.0, 2.0 * np.pi, 5000)
    first, second = (effort_of_place(angle, fit.plant.parameters.terms) for fit in fits)
    assert np.std(first - second) < 0.15 * np.std(second)


def test_the_map_of_one_part_lowers_the_error_of_the_current_on_the_other(fits):
    without = identify(
        LOG, "coulomb_viscous", axis=part(PARTS[0], cogging=(), decimation=4), draws=0, blocks=0
    ).best
    errors = [
        predict(fit.plant, fit.friction, LOG, part(PARTS[1]), "inverse", decimation=4).metrics[
            "force_error_percent"
        ]
        for fit in (fits[0], without)
    ]
    assert errors[0] < 0.7 * errors[1]
