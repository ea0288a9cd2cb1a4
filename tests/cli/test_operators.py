"""Hysteresis operators through the command line: from curves to a model file and back."""

import json

import numpy as np
import pytest
from tests.cli.conftest import bristle  # noqa: F401
from tests.golden.yard import CURVES

from bristle import hysteresis, response
from bristle.hysteresis.identification import FITTED


@pytest.fixture
def loops(tmp_path):
    truth = hysteresis.preisach(s="10 N/um", f_p="20 N")
    turns = np.array([0, 6, -6, 4, -3, 3, -2, 5, -5, 1, -1, 6])
    u = np.interp(np.linspace(0, turns.size - 1, 700), np.arange(turns.size), turns)
    f = response(truth, 1e-6 * u) + 0.02 * np.random.default_rng(0).standard_normal(u.size)
    (tmp_path / "axis.toml").write_text(CURVES)
    rows = [f"{a:.9g},{b:.9g}" for a, b in zip(u, f, strict=True)]
    (tmp_path / "loops.csv").write_text("\n".join(["x,F", *rows]) + "\n")
    return tmp_path


def test_identify_and_predict(bristle, loops):  # noqa: F811
    requested = ("--model", "prandtl_ishlinskii,preisach", "--axis", loops / "axis.toml")
    result = bristle("identify", loops / "loops.csv", *requested, "--out", loops / "out", "--json", "--format", "svg")
    assert result.code == 0, result.err
    assert {item.name for item in (loops / "out" / "figures").glob("*.svg")} == {"curves.svg", "errors.svg"}
    assert json.loads((loops / "out" / "summary.json").read_text()) == result.data
    assert result.data["model"] == "preisach"
    assert result.data["parameters"]["s"]["value"] == pytest.approx(1e7, rel=0.02)
    assert result.data["parameters"]["s"]["unit"] == "N/m"
    assert [item["rank"] for item in result.data["models"]] == [1, 2]
    assert result.data["metrics"]["held_out_error_percent"] < 0.3
    text = bristle(
        "predict",
        loops / "out" / "model.toml",
        loops / "loops.csv",
        "--axis",
        loops / "axis.toml",
        "--json",
        "--out",
        loops / "said",
        "--format",
        "pdf",
        "--format",
        "csv",
    )
    assert text.code == 0, text.err
    assert text.data["metrics"]["error_percent"] == pytest.approx(result.data["metrics"]["error_percent"])
    assert text.data["metrics"]["unit"] == "N"
    names = {item.name for item in (loops / "said" / "figures").iterdir()}
    assert {"curves.pdf", "captions.txt"} <= names
    assert any(name.startswith("curves") and name.endswith(".csv") for name in names)


def test_fits_before_an_interruption_are_written_and_marked(bristle, loops, monkeypatch):  # noqa: F811
    def interrupted(*values, **options):
        raise KeyboardInterrupt

    monkeypatch.setitem(FITTED, "preisach_grid", interrupted)
    requested = ("identify", loops / "loops.csv", "--axis", loops / "axis.toml", "--out", loops / "part")
    result = bristle(*requested, "--model", "prandtl_ishlinskii,preisach_grid,preisach", "--json")
    assert result.code == 130
    words = "interrupted: preisach_grid, preisach were not fitted"
    assert result.data["unfinished"] == words
    assert words in result.err
    assert [item["name"] for item in result.data["models"]] == ["prandtl_ishlinskii"]
    assert f'unfinished = "{words}"' in (loops / "part" / "model.toml").read_text()
    assert f"Unfinished; {words}." in (loops / "part" / "report.html").read_text()
    nothing = bristle(*requested[:-1], loops / "none", "--model", "preisach_grid")
    assert nothing.code == 130
    assert not (loops / "none").exists()


def test_readable_output_of_operators(bristle, loops):  # noqa: F811
    message = bristle("identify", loops / "loops.csv", "--axis", loops / "axis.toml", "--model", "preisach_grid")
    assert message.code == 0, message.err
    assert "Operators compared" in message.out
    assert "the sign of a friction" in message.out


def test_an_operator_has_its_certificates_and_its_reports(bristle, loops):  # noqa: F811
    model = loops / "out" / "model.toml"
    log, axis = loops / "loops.csv", loops / "axis.toml"
    assert bristle("identify", log, "--axis", axis, "--model", "preisach", "--out", loops / "out").code == 0
    checked = bristle("check", model, "--json")
    assert checked.code == 0, checked.err
    assert checked.data["certificates"]["dissipation"]["passed"]
    assert bristle("predict", model, log, "--axis", axis, "--out", loops / "said").code == 0
    for folder, title in (("out", "loops: preisach identified"), ("said", "loops: prediction by preisach")):
        page = (loops / folder / "report.html").read_text()
        assert title in page
        assert page.count("<svg") == 2


@pytest.mark.parametrize(
    ("arguments", "said"), [(("--model", "lugre"), "is not a valid choice"), (("--model", "reversal_table"), "needs reversal curves")]
)
def test_unsuitable_curves_end_with_a_message(bristle, loops, arguments, said):  # noqa: F811
    refused = bristle("identify", loops / "loops.csv", "--axis", loops / "axis.toml", *arguments)
    assert refused.code == 2
    assert said in refused.err


def test_two_files_and_a_missing_axis_are_refused(bristle, loops):  # noqa: F811
    log = loops / "loops.csv"
    refused = bristle("identify", log, log, "--axis", loops / "axis.toml")
    assert (refused.code, "needs a single file of curves" in refused.err) == (2, True)
    done = bristle("identify", log, "--axis", loops / "axis.toml", "--model", "preisach", "--out", loops / "out")
    assert done.code == 0
    refused = bristle("predict", loops / "out" / "model.toml", log)
    assert (refused.code, "names the columns of input and output" in refused.err) == (2, True)
