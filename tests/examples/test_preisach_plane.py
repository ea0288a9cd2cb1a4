"""From curves to a compensated loop by commands alone: branches of the virtual rig, and loops of a measured damper."""

import json
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tests.cli.conftest import bristle  # noqa: F401
from tests.examples.data import data_of, measured

import bristle as br
from bristle import friction
from bristle.cli.main import main
from bristle.core.experiment import Feedforward
from bristle.files.experiment import read_experiment
from bristle.files.operator import read_operator
from bristle.simulation.compensation import feedforward_effort

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "preisach_plane"
PAGE = ROOT / "docs" / "how-to" / "curves-to-compensator.md"


def test_the_page_works_as_written_with_its_numbers(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(shutil.copytree(EXAMPLE, tmp_path / "branches"))
    page = PAGE.read_text()
    for block in re.findall(r"^```sh\n(.*?)^```$", page, flags=re.MULTILINE | re.DOTALL):
        for line in block.splitlines():
            words = shlex.split(line, comments=True)
            if words[0] == "python":
                subprocess.run([sys.executable, *words[1:]], check=True)
            else:
                assert (
                    main(
                        [*words[1:], "--force"]
                        if "--out" in words and "export" not in words
                        else words[1:]
                    )
                    == 0
                )
    capsys.readouterr()
    summary = json.loads(Path("results/summary.json").read_text())
    result = {
        name: data["following_error"]["peak_to_peak"] for name, data in summary["variants"].items()
    }
    rows = re.findall(r"^\| `(\w+)` \|.*\| ([\d.]+) ± [\d.]+ \|$", page, re.MULTILINE)
    message = {name: float(error) for name, error in rows}
    assert message.keys() == result.keys()
    assert {name: round(1e6 * value, 2) for name, value in result.items()} == message
    # The same from Python, without a file of friction.
    operator, offset, _ = read_operator("table/model.toml")
    assert (operator.name, operator.reversals.size >= 90) == ("reversal_table", True)
    variant = next(
        variant
        for variant in read_experiment("compensated.toml").variants
        if variant.name == "branches"
    )
    assert variant.feedforward.friction == friction.find("preisach_contact")(
        kernel=operator, offset=offset
    )
    # What enters the loop is the operator alone, at the desired position of each sample: the mean of both ends of a step.
    dt = variant.run.sample_time
    position, _, acceleration = variant.reference.component.sample(
        dt * np.arange(8000), variant.reference.parameters
    )
    effort = feedforward_effort(
        Feedforward(friction=variant.feedforward.friction), position, acceleration, dt
    )
    output = br.response(operator, np.append(position, 2.0 * position[-1] - position[-2]))
    np.testing.assert_allclose(effort, 0.5 * (output[:-1] + output[1:]) + offset, atol=1e-9)


@pytest.mark.measured
def test_measured_loops_become_friction_and_compensator_by_commands(bristle, tmp_path):  # noqa: F811
    record = measured("friction_damper", "brfd_all.npz")
    for name in ("loops.toml", "moved.toml"):
        shutil.copyfile(ROOT / "examples" / "friction_damper" / name, tmp_path / name)
    requested = (
        "--axis",
        tmp_path / "loops.toml",
        "--model",
        "prandtl_ishlinskii",
        "--out",
        tmp_path / "damper",
    )
    data_of(bristle("identify", record, *requested, "--json"))
    ran = data_of(bristle("run", tmp_path / "moved.toml", "--out", tmp_path / "results", "--json"))
    error = {
        name: data["following_error"]["peak_to_peak"] for name, data in ran["variants"].items()
    }
    assert error["fed_forward"] < 1e-3 * error["none"]
    operator, offset, _ = read_operator(tmp_path / "damper" / "model.toml")
    assert offset != 0.0
    experiment = read_experiment(tmp_path / "moved.toml")
    assert experiment.variants[0].friction == friction.find("preisach_contact")(
        kernel=operator, offset=offset
    )
