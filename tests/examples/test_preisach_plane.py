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
from bristle.core.experiment import Feedforward
from bristle.files.experiment import read_experiment
from bristle.files.operator import read_operator
from bristle.simulation import simulate
from bristle.simulation.compensation import feedforward_effort

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "preisach_plane"
PAGE = ROOT / "docs" / "how-to" / "curves-to-compensator.md"
RIG = ROOT / "src" / "bristle" / "paper" / "experiments" / "set_a_rig.toml"
SHORT = ('duration = "28 s"           # peak', 'duration = "4 s"           # peak'), ("seeds = 6", "seeds = 1")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder of the example with its hundred branches."""
    place = tmp_path_factory.mktemp("plane") / "branches"
    shutil.copytree(EXAMPLE, place)
    (place / "paper").mkdir()
    shutil.copyfile(RIG, place / "paper" / "set_a_rig.toml")
    subprocess.run([sys.executable, "branches.py"], cwd=place, check=True)
    return place


def only(text, *names):
    """An experiment with only these of its variants."""
    head, *tables = re.split(r"^(?=\[compare\.)", text, flags=re.MULTILINE)
    return head + "".join(table for table in tables if re.match(rf"\[compare\.({'|'.join(names)})[.\]]", table))


def shortened(folder, *names):
    """A run of four seconds of these variants of the example."""
    text = only((folder / "compensated.toml").read_text(), *names)
    for long, short in SHORT:
        assert long in text
        text = text.replace(long, short)
    (folder / "short.toml").write_text(text)
    return folder / "short.toml"


def along_desired(variant):
    """Desired position and acceleration of a variant, and its sample time."""
    dt = variant.run.sample_time
    t = dt * np.arange(round(variant.run.duration / dt))
    position, _, acceleration = variant.reference.component.sample(t, variant.reference.parameters)
    return position, acceleration, dt


def test_a_hundred_branches_become_a_compensator_by_commands(bristle, folder):  # noqa: F811
    requested = ("--axis", folder / "branches.toml", "--model", "reversal_table", "--out", folder / "table", "--json")
    data_of(bristle("identify", folder / "branches.csv", *requested))
    operator, offset, _ = read_operator(folder / "table" / "model.toml")
    assert operator.name == "reversal_table"
    assert operator.reversals.size >= 90
    experiment = shortened(folder, "none", "branches")
    ran = data_of(bristle("run", experiment, "--out", folder / "results", "--json"))
    error = {name: data["following_error"]["peak_to_peak"] for name, data in ran["variants"].items()}
    assert error["branches"] < 0.6 * error["none"]
    # The same from Python, without a file of friction: to the bit.
    in_python = read_experiment(experiment)
    contact = friction.find("preisach_contact")(kernel=operator, offset=offset)
    assert in_python.variants[1].feedforward.friction == contact
    simulated = simulate(in_python)
    assert {name: variant.following_error.peak_to_peak for name, variant in simulated.variants.items()} == error
    # What enters the loop is the operator alone, at the desired position of each sample: the mean of both ends of a step.
    position, acceleration, dt = along_desired(in_python.variants[1])
    effort = feedforward_effort(Feedforward(friction=contact), position, acceleration, dt)
    output = br.response(operator, np.append(position, 2.0 * position[-1] - position[-2]))
    np.testing.assert_allclose(effort, 0.5 * (output[:-1] + output[1:]) + offset, atol=1e-9)


def test_the_page_works_as_written_with_its_numbers(folder, monkeypatch, capsys):
    from bristle.cli.main import main

    monkeypatch.chdir(folder)
    shutil.rmtree("paper")
    page = PAGE.read_text()
    for block in re.findall(r"^```sh\n(.*?)^```$", page, flags=re.MULTILINE | re.DOTALL):
        for line in block.splitlines():
            words = shlex.split(line, comments=True)
            if words[0] == "python":
                subprocess.run([sys.executable, *words[1:]], check=True)
            else:
                assert main([*words[1:], "--force"] if "--out" in words and "export" not in words else words[1:]) == 0
    capsys.readouterr()
    summary = json.loads(Path("results/summary.json").read_text())
    result = {name: data["following_error"]["peak_to_peak"] for name, data in summary["variants"].items()}
    rows = re.findall(r"^\| `(\w+)` \|.*\| ([\d.]+) ± [\d.]+ \|$", page, re.MULTILINE)
    message = {name: float(error) for name, error in rows}
    assert message.keys() == result.keys()
    assert {name: round(1e6 * value, 2) for name, value in result.items()} == message


@pytest.mark.measured
def test_measured_loops_become_friction_and_compensator_by_commands(bristle, tmp_path):  # noqa: F811
    record = measured("friction_damper", "brfd_all.npz")
    for name in ("loops.toml", "moved.toml"):
        shutil.copyfile(ROOT / "examples" / "friction_damper" / name, tmp_path / name)
    requested = ("--axis", tmp_path / "loops.toml", "--model", "prandtl_ishlinskii", "--out", tmp_path / "damper")
    data_of(bristle("identify", record, *requested, "--json"))
    ran = data_of(bristle("run", tmp_path / "moved.toml", "--out", tmp_path / "results", "--json"))
    error = {name: data["following_error"]["peak_to_peak"] for name, data in ran["variants"].items()}
    assert error["fed_forward"] < 1e-3 * error["none"]
    operator, offset, _ = read_operator(tmp_path / "damper" / "model.toml")
    assert offset != 0.0
    experiment = read_experiment(tmp_path / "moved.toml")
    assert experiment.variants[0].friction == friction.find("preisach_contact")(kernel=operator, offset=offset)
