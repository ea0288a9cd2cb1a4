"""``bristle export``: what is written, what is said, and what is refused; operators, from curves to a file and back."""

import json
import re
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from tests.cli.conftest import written_in
from tests.golden.yard import CURVES

import bristle as br
from bristle.apps.targets import fmu
from bristle.files.operator import write_operator
from bristle.identification.hysteresis import FITTED


@pytest.mark.usefixtures("undrawn")
@pytest.mark.slow
def test_the_error_of_a_table_on_the_log_of_the_model_is_reported(bristle, place, remembered):
    line = (
        "identify",
        "log.csv",
        "--axis",
        "axis.toml",
        "--model",
        "viscous,coulomb_viscous",
        "--draws",
        0,
        "--out",
        "fit",
        "--json",
    )
    assert bristle(*line).code == 0
    words = "along the log of the identification"
    result = bristle(
        "export",
        "fit",
        "--to",
        "table",
        "--points",
        "3",
        "--axis",
        "axis.toml",
        "--log",
        "log.csv",
        "--out",
        "out",
        "--json",
        code=0,
    )
    message = next(note for note in result.data["notes"] if "largest error" in note)
    assert float(message.partition(words)[2].split()[1]) < 1e-6  # a line on a line


@pytest.mark.usefixtures("undrawn")
def test_an_operator_keeps_its_constant(bristle, place):
    write_operator("operator.toml", br.hysteresis.preisach(s=1e7, f_p=20.0), offset=1.5)
    bristle("export", "operator.toml", "--to", "c", "--out", "as_c", code=0)
    header = Path("as_c/axis_x.h").read_text()
    assert "axis_x_output(axis_x *axis, double x)" in header
    assert re.search(r"offset +1\.5 +N +constant added to the output of the operator", header)
    assert bristle("export", "operator.toml", "--to", "wasm", "--out", "other").code == 2


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_the_law_of_a_variant_is_exported_as_c(bristle, place):
    line = ("export", "--law", "experiment.toml", "--variant", "base", "--to", "c", "--out", "law")
    result = bristle(*line, "--json", code=0)
    assert result.data["model"] == "cascade of base"
    assert written_in("law") == {*result.data["files"], "summary.json"}
    header = Path("law/axis_x.h").read_text()
    assert "friction along the desired motion by coulomb_viscous" in header
    assert "experiment: experiment.toml" in header
    bristle(
        "export",
        "--law",
        "experiment.toml",
        "--variant",
        "none",
        "--to",
        "c",
        "--out",
        "bare",
        code=0,
    )
    assert "place_ahead" not in Path("bare/axis_x.h").read_text()


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_model_and_a_law_are_exported_as_structured_text(bristle, place):
    law = bristle(
        "export",
        "--law",
        "experiment.toml",
        "--variant",
        "base",
        "--to",
        "st",
        "--out",
        "law_st",
        "--json",
        code=0,
    )
    assert law.data["files"][:3] == ["axis_x.st", "axis_x_selftest.st", "axis_x_plcopen.xml"]
    head = Path("law_st/axis_x.st").read_text().split("*)")[4]  # behind four lines on the rights
    assert "friction along the desired motion by coulomb_viscous" in head
    assert "place_ahead[0] to [" in head
    single = bristle(
        "export", "model.toml", "--to", "st", "--float32", "--tunable", "--out", "single", code=0
    )
    assert "single precision" in single.out.replace("\n", " ")
    assert ": REAL := REAL#" in Path("single/axis_x.st").read_text()


@pytest.mark.usefixtures("undrawn")
@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("to", ["fmu2", "fmu3"])
def test_the_law_of_a_variant_is_exported_as_an_fmu(bristle, place, monkeypatch, to):
    monkeypatch.setattr(fmu, "zig", list)
    monkeypatch.setattr(fmu, "compiler", lambda: None)
    result = bristle(
        "export",
        "--law",
        "experiment.toml",
        "--variant",
        "base",
        "--to",
        to,
        "--out",
        "law",
        "--json",
        code=0,
    )
    assert result.data["files"] == ["axis_x.fmu"]
    assert written_in("law") == {"axis_x.fmu", "summary.json"}
    assert any(
        note.startswith("the internal step is the sample time") for note in result.data["notes"]
    )
    assert any("place_ahead" in note for note in result.data["notes"])
    as_c = bristle(
        "export",
        "--law",
        "experiment.toml",
        "--variant",
        "base",
        "--to",
        "c",
        "--out",
        "as_c",
        "--json",
    )
    assert result.data["effect"] == as_c.data["effect"]
    with zipfile.ZipFile("law/axis_x.fmu") as archive:
        described = ElementTree.fromstring(archive.read("modelDescription.xml"))
    message = described.find(".//Model[@sha256]").get("sha256")
    assert f"Hash of the model: sha256 {message}" in Path("as_c/axis_x.h").read_text()
    assert described.get("author").endswith(", from experiment.toml")


@pytest.mark.usefixtures("undrawn")
def test_a_law_is_exported_tunable_and_in_single_precision(bristle, place):
    line = (
        "export",
        "--law",
        "experiment.toml",
        "--variant",
        "base",
        "--to",
        "c",
        "--tunable",
        "--float32",
    )
    assert bristle(*line, "--out", "law").code == 0
    header = Path("law/axis_x.h").read_text()
    assert "float controller_k_p;" in header
    assert "float friction_F_C;" in header
    assert "Single precision" in Path("law/README.md").read_text()


@pytest.mark.usefixtures("undrawn")
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

    monkeypatch.setattr("bristle.contract.admit", refused)
    monkeypatch.setattr("bristle.contract.admit_friction_of", refused)
    ended = bristle(*command, *(() if command[0] == "models" else ("--out", "written")))
    assert (ended.code, ended.err) == (2, "bristle: own.py: cannot be used\n")
    assert not Path("written").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_the_summary_of_a_scene_states_its_force_error(bristle, place):
    Path("dahl.toml").write_text(
        'schema = 1\nkind = "translational"\n\n[friction]\nmodel = "dahl"\nF_C = 20.0\nsigma_0 = 5e6\n'
    )
    result = bristle("export", "dahl.toml", "--to", "mjcf", "--out", "scene", "--json")
    error = json.loads(Path("scene/summary.json").read_text())["error"]
    assert error == result.data["error"]
    assert 0.1 < error["rms"] < error["largest"] < 40.0
    assert any(f"{error['rms']:.2f} % rms" in note for note in result.data["notes"])


# --- operators -------------------------------------------------------------------------------------------------------


@pytest.fixture
def loops(tmp_path):
    truth = br.hysteresis.preisach(s="10 N/um", f_p="20 N")
    turns = np.array([0, 6, -6, 4, -3, 3, -2, 5, -5, 1, -1, 6])
    u = np.interp(np.linspace(0, turns.size - 1, 700), np.arange(turns.size), turns)
    f = br.response(truth, 1e-6 * u) + 0.02 * np.random.default_rng(0).standard_normal(u.size)
    (tmp_path / "axis.toml").write_text(CURVES)
    rows = [f"{a:.9g},{b:.9g}" for a, b in zip(u, f, strict=True)]
    (tmp_path / "loops.csv").write_text("\n".join(["x,F", *rows]) + "\n")
    return tmp_path


@pytest.mark.slow
def test_operators_are_identified_checked_and_predict(bristle, loops, undrawn):
    log, axis, model = loops / "loops.csv", loops / "axis.toml", loops / "out" / "model.toml"
    result = bristle(
        "identify",
        log,
        "--model",
        "prandtl_ishlinskii,preisach",
        "--axis",
        axis,
        "--out",
        loops / "out",
        "--json",
        code=0,
    )
    assert json.loads((loops / "out" / "summary.json").read_text()) == result.data
    assert result.data["model"] == "preisach"
    assert result.data["parameters"]["s"]["value"] == pytest.approx(1e7, rel=0.02)
    assert result.data["parameters"]["s"]["unit"] == "N/m"
    assert [item["rank"] for item in result.data["models"]] == [1, 2]
    assert result.data["metrics"]["held_out_error_percent"] < 0.3
    checked = bristle("check", model, "--json", code=0)
    assert checked.data["certificates"]["dissipation"]["passed"]
    predicted = bristle(
        "predict", model, log, "--axis", axis, "--json", "--out", loops / "said", code=0
    )
    assert predicted.data["metrics"]["error_percent"] == pytest.approx(
        result.data["metrics"]["error_percent"]
    )
    assert predicted.data["metrics"]["unit"] == "N"
    for folder, title in (
        ("out", "loops: preisach identified"),
        ("said", "loops: prediction by preisach"),
    ):
        page = (loops / folder / "report.html").read_text()
        assert title in page
        assert page.count("<svg") == 2


@pytest.mark.slow
def test_figures_of_operators_are_files(bristle, loops):
    line = (
        "identify",
        loops / "loops.csv",
        "--model",
        "preisach",
        "--axis",
        loops / "axis.toml",
        "--out",
        loops / "out",
    )
    assert bristle(*line, "--format", "svg", "--format", "csv").code == 0
    names = {item.name for item in (loops / "out" / "figures").iterdir()}
    assert {"curves.svg", "errors.svg", "captions.txt"} <= names
    assert any(name.startswith("curves") and name.endswith(".csv") for name in names)


def test_fits_before_an_interruption_are_written_and_marked(bristle, loops, monkeypatch, undrawn):
    def interrupted(*values, **options):
        raise KeyboardInterrupt

    monkeypatch.setitem(FITTED, "preisach_grid", interrupted)
    requested = (
        "identify",
        loops / "loops.csv",
        "--axis",
        loops / "axis.toml",
        "--out",
        loops / "part",
    )
    result = bristle(
        *requested, "--model", "prandtl_ishlinskii,preisach_grid,preisach", "--json", code=130
    )
    words = "interrupted: preisach_grid, preisach were not fitted"
    assert result.data["unfinished"] == words
    assert words in result.err
    assert [item["name"] for item in result.data["models"]] == ["prandtl_ishlinskii"]
    assert f'unfinished = "{words}"' in (loops / "part" / "model.toml").read_text()
    assert f"Unfinished; {words}." in (loops / "part" / "report.html").read_text()
    bristle(*requested[:-1], loops / "none", "--model", "preisach_grid", code=130)
    assert not (loops / "none").exists()


@pytest.mark.slow
def test_readable_output_of_operators(bristle, loops):
    bristle(
        "identify",
        loops / "loops.csv",
        "--axis",
        loops / "axis.toml",
        "--model",
        "preisach_grid",
        code=0,
        shown=("Operators compared", "the sign of a friction"),
    )


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--model", "lugre"), "is not a valid choice"),
        (("--model", "reversal_table"), "needs reversal curves"),
    ],
)
def test_unsuitable_curves_end_with_a_message(bristle, loops, arguments, said):
    bristle(
        "identify",
        loops / "loops.csv",
        "--axis",
        loops / "axis.toml",
        *arguments,
        code=2,
        said=said,
    )


def test_two_files_and_a_missing_axis_are_refused(bristle, loops):
    log = loops / "loops.csv"
    bristle(
        "identify",
        log,
        log,
        "--axis",
        loops / "axis.toml",
        code=2,
        said="needs a single file of curves",
    )
    write_operator(loops / "model.toml", br.hysteresis.preisach(s=1e7, f_p=20.0))
    bristle(
        "predict", loops / "model.toml", log, code=2, said="names the columns of input and output"
    )
