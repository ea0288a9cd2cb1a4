"""Results are passed on: they name files, and never the folders in which a person keeps them."""

import shutil

import pytest
from tests.attack.yard import build

from bristle.cli.main import main

pytestmark = pytest.mark.usefixtures("undrawn")

TELLING = "customer_secret"
RESULTS = {
    "identify": "identify {0}/log.csv --axis {0}/axis.toml --model coulomb_viscous --draws 20",
    "identify a model of one's own": "identify {0}/log.csv --axis {0}/axis.toml --model {0}/own.py --draws 0",
    "identify curves": "identify {0}/log.csv --axis {0}/curves.toml",
    "log": "log {0}/log.csv --axis {0}/axis.toml",
    "log with problems": "log {0}/nan.csv --axis {0}/axis.toml",
    "log without a column": "log {0}/nan.csv --axis {0}/bare.toml",
    "predict": "predict {0}/model.toml {0}/log.csv --axis {0}/axis.toml",
    "predict curves": "predict {0}/operator.toml {0}/log.csv --axis {0}/curves.toml",
    "run": "run {0}/experiment.toml",
    "design": "design {0}/experiment.toml",
    "excite": "excite {0}/axis.toml --duration 15s",
    "paper": "paper --figure 1 --from {0}",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("whereabouts") / TELLING / "rig"
    place.mkdir(parents=True)
    build(place)
    rows = (place / "log.csv").read_text().splitlines()
    rows[300] = rows[300].rpartition(",")[0] + ",nan"
    (place / "nan.csv").write_text("\n".join(rows) + "\n")
    (place / "bare.toml").write_text((place / "axis.toml").read_text().replace('column = "u"', 'column = "torque"'))
    return place


LONG = ("identify", "identify a model of one's own", "identify curves", "design", "excite")


@pytest.mark.parametrize("command", [pytest.param(command, marks=pytest.mark.slow if command in LONG else ()) for command in RESULTS])
def test_results_name_no_folder(folder, command, capsys):
    out = folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    assert main([*RESULTS[command].format(folder).split(), "--out", str(out), "--json"]) in (0, 1)
    assert TELLING not in capsys.readouterr().out
    written = [path for path in out.rglob("*") if path.is_file()]
    assert len(written) >= 2
    assert [path.name for path in written if TELLING.encode() in path.read_bytes()] == []


def test_results_of_checks_name_no_folder(folder, capsys):
    for name in ("model.toml", "own.py", "operator.toml"):
        assert main(["check", str(folder / name), "--json"]) in (0, 1)
        assert TELLING not in capsys.readouterr().out


@pytest.mark.slow
def test_terminal_messages_name_the_full_path(folder, capsys):
    shutil.rmtree(folder / "out", ignore_errors=True)
    assert main(["excite", str(folder / "axis.toml"), "--duration", "15s", "--out", str(folder / "out")]) == 0
    assert f"--axis {folder}/out/axis.toml" in capsys.readouterr().out.replace("\n", "")
