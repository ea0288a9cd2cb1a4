"""The example of a virtual ball screw: from an axis file to a compensated loop, command by command."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from tests.cli.conftest import bristle  # noqa: F401
from tests.golden.logs import run_ball_screw

from bristle.cli.main import main
from bristle.files import read_axis, read_log
from bristle.files.model import read_model

pytestmark = pytest.mark.slow

EXAMPLE = Path(__file__).parents[2] / "examples" / "virtual_ball_screw"
BENCH = Path(__file__).parents[2] / "src" / "bristle" / "apps" / "paper" / "experiments"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder of the example after `excite` (without its rehearsal), `run` and `identify`."""
    place = tmp_path_factory.mktemp("virtual") / "ball_screw"
    _, motion = run_ball_screw(place)
    shutil.copyfile(place / "axis.toml", place / "motion" / "axis.toml")
    recorded, requested = (
        str(place / "recorded" / "log.csv"),
        ["--axis", str(place / "motion" / "axis.toml")],
    )
    requested += ["--model", "maxwell_slip", "--draws", "0", "--out", str(place / "fit")]
    assert main(["identify", recorded, *requested]) == 0
    return place, motion


def test_the_rig_is_that_of_the_bench():
    assert (
        read_model(EXAMPLE / "rig.toml").friction == read_model(BENCH / "set_a_rig.toml").friction
    )


def test_the_log_has_the_encoder_and_the_command_without_the_truth(folder):
    place, motion = folder
    head = (place / "recorded" / "log.csv").read_text().partition("\n")[0]
    assert head == "t [s],encoder [um],force command [N],reference [um]"
    log = read_log(place / "recorded" / "log.csv", read_axis(place / "axis.toml"))
    assert log.reference.values == pytest.approx(motion.position, abs=1e-12)
    counts = log.position.values / 0.125e-6
    assert counts == pytest.approx(counts.round(), abs=1e-4)


def test_true_parameters_are_recovered(folder):
    place, _ = folder
    result, truth = (
        read_model(place / "fit" / "model.toml"),
        read_model(EXAMPLE / "rig.toml").friction.values,
    )
    values = result.friction.values
    level = 0.5 * (truth["F_S_pos"] + truth["F_S_neg"])
    x = np.linspace(0.0, 5e-6, 50)[:, None]
    curve, wanted = (
        np.minimum(x * item["k_i"], item["nu_i"] * most).sum(axis=1)
        for item, most in ((values, values["F_C"]), (truth, level))
    )
    assert np.max(np.abs(curve - wanted)) < 0.06 * level
    assert values["sigma_2"] == pytest.approx(truth["sigma_2_pos"], rel=0.1)
    assert result.info["treatment"]["delay"] == pytest.approx(-0.7e-3, abs=0.1e-3)


def test_the_identified_model_compensates(folder, bristle):  # noqa: F811
    place, _ = folder
    result = bristle("run", place / "compensated.toml", "--json")
    peaks = {
        name: 1e6 * item["following_error"]["peak_to_peak"]
        for name, item in result.data["variants"].items()
    }
    assert {item["runs"] for item in result.data["variants"].values()} == {6}
    assert peaks["none"] == pytest.approx(1.48, rel=0.03)
    assert peaks["identified"] <= 0.45
    assert peaks["observer_feedforward"] <= 0.40
    assert peaks["observer_feedforward_1hz"] <= 0.40
    assert peaks["observer_feedforward_2hz"] <= 0.40
    assert peaks["observer_feedforward_4hz"] <= 0.42
