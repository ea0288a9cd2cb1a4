"""``bristle export``: what is written, what is said, and what is refused."""

import json
import re
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest
from tests.cli.conftest import written_in

import bristle as br
from bristle.exports import fmu
from bristle.files.operator import write_operator

pytestmark = pytest.mark.usefixtures("undrawn")


@pytest.mark.slow
def test_the_error_of_a_table_on_the_log_of_the_model_is_reported(bristle, place, remembered):
    line = ("identify", "log.csv", "--axis", "axis.toml", "--model", "viscous,coulomb_viscous", "--draws", 0, "--out", "fit", "--json")
    assert bristle(*line).code == 0
    words = "along the log of the identification"
    result = bristle(
        "export", "fit", "--to", "table", "--points", "3", "--axis", "axis.toml", "--log", "log.csv", "--out", "out", "--json", code=0
    )
    message = next(note for note in result.data["notes"] if "largest error" in note)
    assert float(message.partition(words)[2].split()[1]) < 1e-6  # a line on a line


def test_an_operator_keeps_its_constant(bristle, place):
    write_operator("operator.toml", br.hysteresis.preisach(s=1e7, f_p=20.0), offset=1.5)
    bristle("export", "operator.toml", "--to", "c", "--out", "as_c", code=0)
    header = Path("as_c/axis_x.h").read_text()
    assert "axis_x_output(axis_x *axis, double x)" in header
    assert re.search(r"offset +1\.5 +N +constant added to the output of the operator", header)
    assert bristle("export", "operator.toml", "--to", "wasm", "--out", "other").code == 2


def test_the_law_of_a_variant_is_exported_as_c(bristle, place):
    line = ("export", "--law", "experiment.toml", "--variant", "base", "--to", "c", "--out", "law")
    result = bristle(*line, "--json", code=0)
    assert result.data["model"] == "cascade of base"
    assert written_in("law") == {*result.data["files"], "summary.json"}
    header = Path("law/axis_x.h").read_text()
    assert "friction along the desired motion by coulomb_viscous" in header
    assert "experiment: experiment.toml" in header
    bristle("export", "--law", "experiment.toml", "--variant", "none", "--to", "c", "--out", "bare", code=0)
    assert "place_ahead" not in Path("bare/axis_x.h").read_text()


def test_a_model_and_a_law_are_exported_as_structured_text(bristle, place):
    law = bristle("export", "--law", "experiment.toml", "--variant", "base", "--to", "st", "--out", "law_st", "--json", code=0)
    assert law.data["files"][:3] == ["axis_x.st", "axis_x_selftest.st", "axis_x_plcopen.xml"]
    head = Path("law_st/axis_x.st").read_text().split("*)")[4]  # behind four lines on the rights
    assert "friction along the desired motion by coulomb_viscous" in head
    assert "place_ahead[0] to [" in head
    single = bristle("export", "model.toml", "--to", "st", "--float32", "--tunable", "--out", "single", code=0)
    assert "single precision" in single.out.replace("\n", " ")
    assert ": REAL := REAL#" in Path("single/axis_x.st").read_text()


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("to", ["fmu2", "fmu3"])
def test_the_law_of_a_variant_is_exported_as_an_fmu(bristle, place, monkeypatch, to):
    monkeypatch.setattr(fmu, "zig", list)
    monkeypatch.setattr(fmu, "compiler", lambda: None)
    result = bristle("export", "--law", "experiment.toml", "--variant", "base", "--to", to, "--out", "law", "--json", code=0)
    assert result.data["files"] == ["axis_x.fmu"]
    assert written_in("law") == {"axis_x.fmu", "summary.json"}
    assert any(note.startswith("the internal step is the sample time") for note in result.data["notes"])
    assert any("place_ahead" in note for note in result.data["notes"])
    as_c = bristle("export", "--law", "experiment.toml", "--variant", "base", "--to", "c", "--out", "as_c", "--json")
    assert result.data["effect"] == as_c.data["effect"]
    with zipfile.ZipFile("law/axis_x.fmu") as archive:
        described = ElementTree.fromstring(archive.read("modelDescription.xml"))
    message = described.find(".//Model[@sha256]").get("sha256")
    assert f"Hash of the model: sha256 {message}" in Path("as_c/axis_x.h").read_text()
    assert described.get("author").endswith(", from experiment.toml")


def test_a_law_is_exported_tunable_and_in_single_precision(bristle, place):
    line = ("export", "--law", "experiment.toml", "--variant", "base", "--to", "c", "--tunable", "--float32")
    assert bristle(*line, "--out", "law").code == 0
    header = Path("law/axis_x.h").read_text()
    assert "float controller_k_p;" in header
    assert "float friction_F_C;" in header
    assert "Single precision" in Path("law/README.md").read_text()


@pytest.mark.parametrize(
    "command",
    [
        ("export", "--law", "experiment.toml", "--variant", "base", "--to", "c"),
        ("export", "model.toml", "--to", "c", "--step", "1ms"),
        ("predict", "model.toml", "log.csv", "--axis", "axis.toml"),
        ("run", "experiment.toml"),
        ("design", "experiment.toml"),
        ("lab", "model.toml"),
        ("paper", "--robust", "model.toml"),
        ("identify", "log.csv", "--axis", "axis.toml", "--model", "own.py"),
        ("models", "own.py+asymmetry"),
    ],
)
def test_each_command_tests_the_friction_of_its_model(bristle, place, monkeypatch, command):
    def refused(friction):
        raise br.core.InputError("cannot be used", path="own.py")

    monkeypatch.setattr("bristle.testing.admit", refused)
    monkeypatch.setattr("bristle.testing.admit_friction_of", refused)
    ended = bristle(*command, *(() if command[0] == "models" else ("--out", "written")))
    assert (ended.code, ended.err) == (2, "bristle: own.py: cannot be used\n")
    assert not Path("written").exists()


def test_the_summary_of_a_scene_states_its_force_error(bristle, place):
    Path("dahl.toml").write_text('schema = 1\nkind = "translational"\n\n[friction]\nmodel = "dahl"\nF_C = 20.0\nsigma_0 = 5e6\n')
    result = bristle("export", "dahl.toml", "--to", "mjcf", "--out", "scene", "--json")
    error = json.loads(Path("scene/summary.json").read_text())["error"]
    assert error == result.data["error"]
    assert 0.1 < error["rms"] < error["largest"] < 40.0
    assert any(f"{error['rms']:.2f} % rms" in note for note in result.data["notes"])
