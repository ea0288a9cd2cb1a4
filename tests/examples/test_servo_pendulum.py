"""Two servo arms of other people's: gravity in proportion to the weight, error on what was not fitted."""

import os
from pathlib import Path

import pytest

from bristle import identify

FOLDER = Path(__file__).parents[2] / "examples" / "servo_pendulum"
DATA = (
    Path(os.environ.get("BRISTLE_DATA", FOLDER.parents[2] / "shared" / "data")) / "servo_pendulum"
)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not DATA.exists(), reason="the logs of the arms are not here"),
]


@pytest.fixture(scope="module")
def arms():
    pytest.importorskip("bristle.logs.json_records", reason="JSON of records is not read")
    return [
        identify(
            DATA / f"arm_{mass}g.json", "stribeck_free", axis=FOLDER / "axis.toml", draws=0
        ).best
        for mass in (200, 400)
    ]


def test_gravity_is_in_proportion_to_the_weight(arms):
    light, heavy = (fit.plant.values["g_sin"] for fit in arms)
    assert heavy / light == pytest.approx(2.0, rel=0.05)


def test_held_out_data_are_predicted(arms):
    assert [fit.held_out.mean_percent < 22.0 for fit in arms] == [True, True]
