"""The tolerances of a linear axis, as the page of the example tells them."""

import re
from pathlib import Path

import numpy as np
import pytest

from bristle.apps.study import read_study_file, run_study
from bristle.apps.study.influence import rank_correlations
from bristle.apps.study.store import runs_in

pytestmark = pytest.mark.slow

EXAMPLE = Path(__file__).parents[2] / "examples" / "study"


def test_the_numbers_of_the_page(tmp_path):
    study = read_study_file(EXAMPLE / "study.toml")
    run_study(study, tmp_path / "out", workers=1)
    runs = runs_in(tmp_path / "out")
    page = (EXAMPLE / "README.md").read_text()
    message = re.search(r"\| Following error.*", page)[0]
    for point, cell in enumerate(message.split("|")[2:5]):
        errors = (
            1e3
            * runs.columns["following_error.peak_to_peak"][
                runs.columns["run"].astype(int) % 3 == point
            ]
        )
        mean, std = (float(text) for text in re.findall(r"[\d.]+", cell))
        assert (round(float(errors.mean()), 4), round(float(np.std(errors, ddof=1)), 4)) == (
            mean,
            std,
        )
    entries = {
        entry["cause"]: entry
        for entry in rank_correlations(runs)
        if entry["metric"].startswith("following")
    }
    assert f"{entries['friction.F_C']['value']:.2f}, 95 % interval" in page
    assert f"({entries['friction.sigma_2']['value']:.2f}," in page
    for name in ("friction.sigma_0", "plant.M"):
        assert f"({entries[name]['value']:.2f},".replace("-", "−") in page
