"""A law and a sensor of a person's own: checked, run, judged and exported without a line in the package."""

import json
import shutil
from pathlib import Path

import pytest

from bristle import plants, references
from bristle.cli.main import main
from bristle.core.errors import InputWarning
from bristle.exports.c import compiler
from bristle.files import read_experiment
from bristle.simulation import simulate

FOLDER = Path(__file__).parents[2] / "examples" / "own_loop"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore:.*the code in .* is run:bristle.core.errors.InputWarning"),
]


@pytest.fixture
def folder(tmp_path) -> Path:
    for file in FOLDER.iterdir():
        if file.is_file():
            shutil.copy(file, tmp_path)
    return tmp_path


def test_code_files_need_permission_to_run(folder, capsys):
    assert main(["run", str(folder / "rig.toml")]) == 2
    assert (
        "sensor.file: names code that needs permission to run: resolver.py"
        in capsys.readouterr().err
    )
    for custom in ("pid.py", "resolver.py"):
        assert main(["check", str(folder / custom)]) == 0
    assert main(["run", str(folder / "rig.toml"), "--json"]) == 0


def test_the_sensor_is_a_cause_under_its_name(folder, capsys):
    assert main(["design", str(folder / "rig.toml"), "--allow-code", "--json"]) == 0
    budget = json.loads(capsys.readouterr().out)["budget"]
    assert "an error of two periods per turn" in budget["causes"]["resolver"]["description"]
    # Of 5 um that the loop mostly follows.
    assert 0.3e-6 < budget["causes"]["resolver"]["alone"]["peak_to_peak"] < 5e-6
    assert budget["nothing"]["peak_to_peak"] < 1e-9


def test_the_law_is_exported_to_c(folder, tmp_path):
    if compiler() is None:
        pytest.skip("no C compiler here")
    out = tmp_path / "c"
    law = str(folder / "rig.toml")
    assert (
        main(
            [
                "export",
                "--to",
                "c",
                "--law",
                law,
                "--allow-code",
                "--name",
                "pid_x",
                "--out",
                str(out),
            ]
        )
        == 0
    )
    assert "K_P" in (out / "pid_x.h").read_text()


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (
            '[sensor]\nfile = "pid.py"',
            "MODEL is not a Sensor; found 'Controller'. End the file with MODEL = Sensor",
        ),
        (
            '[sensor]\nfile = "resolver.txt"',
            "sensor.file: is not a Python file with a sensor; found 'resolver.txt'",
        ),
        (
            '[sensor]\nmodel = "encoder"\nfile = "resolver.py"',
            "sensor: has both a model and a file",
        ),
        (
            '[sensor]\nfile = "../resolver.py"',
            "names code in another folder, so bristle does not run it",
        ),
    ],
)
def test_files_without_a_component_are_refused(folder, capsys, table, said):
    rig = folder / "rig.toml"
    text = rig.read_text(encoding="utf-8").replace('a = "2.5 um"\nL = "10 mm"\n', "")
    rig.write_text(text.replace('[sensor]\nfile = "resolver.py"', table), encoding="utf-8")
    assert main(["run", str(rig), "--allow-code"]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("section", "model", "built_in"),
    [("reference", "sine", references), ("plant", "inertia", plants)],
)
def test_a_copy_of_a_built_in_component_gives_the_same_bits(folder, section, model, built_in):
    rig = folder / "rig.toml"
    text = rig.read_text(encoding="utf-8").replace("[plant]\n", '[plant]\nmodel = "inertia"\n')
    rig.write_text(text, encoding="utf-8")
    (first,) = simulate(read_experiment(rig, allow_code=True)).variants.values()
    shutil.copy(Path(built_in.__file__).with_name(f"{model}.py"), folder / "own.py")
    rig.write_text(text.replace(f'model = "{model}"', 'file = "own.py"'), encoding="utf-8")
    with pytest.warns(InputWarning, match=rf"{section}\.file: the code in own\.py"):
        (second,) = simulate(read_experiment(rig, allow_code=True)).variants.values()
    assert second.position.tobytes() == first.position.tobytes()
