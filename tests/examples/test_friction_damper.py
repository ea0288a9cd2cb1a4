"""The friction damper with backlash through the command line: each test held out in turn, another one predicted."""

from pathlib import Path

import numpy as np
import pytest
from tests.cli.conftest import bristle  # noqa: F401
from tests.examples.data import data_of, measured

pytestmark = pytest.mark.slow

AXIS = Path(__file__).parents[2] / "examples" / "friction_damper" / "axis.toml"
TEST = "dataset-1__characterization_datasets__{}tension"
FITTED = ("0.5Hz80lb", "1Hz80lb")


@pytest.mark.measured
def test_a_slider_behind_a_gap_beats_coulomb_and_elements_that_slip(bristle, tmp_path):  # noqa: F811
    file = measured("friction_damper", "brfd_all.npz")
    logs = [f"{file}::{TEST.format(name)}" for name in FITTED]
    models = "coulomb,maxwell_slip,gap_slider+asymmetry"
    out = tmp_path / "out"
    result = data_of(
        bristle("identify", *logs, "--axis", AXIS, "--model", models, "--out", out, "--json")
    )
    assert result["model"] == "gap_slider+asymmetry"
    error = {item["name"]: item["metrics"]["held_out_error_percent"] for item in result["models"]}
    assert error["coulomb"] > 5.0 * error["gap_slider+asymmetry"]
    assert error["gap_slider+asymmetry"] < 0.8 * error["maxwell_slip"]
    known = result["parameters"]
    assert known["F_C_pos"]["status"] == known["F_C_neg"]["status"] == "identified"
    # The same history elsewhere, in a file of its own that holds nothing else: the backlash is found anew.
    array = np.load(file)[TEST.format(FITTED[1])]
    np.savez(tmp_path / "history.npz", history=array[1500:])
    predicted = bristle(
        "predict", out / "model.toml", tmp_path / "history.npz", "--axis", AXIS, "--json"
    )
    assert predicted.data["metrics"]["force_error_percent"] < 16.0
