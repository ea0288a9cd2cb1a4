"""Hysteresis operators through the command line: from curves to a model file and back."""

import json

import numpy as np
import pytest
from tests.cli.conftest import bristle  # noqa: F401
from tests.golden.yard import CURVES

from bristle import hysteresis, response
from bristle.files.operator import write_operator
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


def test_operators_are_identified_checked_and_predict(bristle, loops, undrawn):  # noqa: F811
    log, axis, model = loops / "loops.csv", loops / "axis.toml", loops / "out" / "model.toml"
    result = bristle("identify", log, "--model", "prandtl_ishlinskii,preisach", "--axis", axis, "--out", loops / "out", "--json", code=0)
    assert json.loads((loops / "out" / "summary.json").read_text()) == result.data
    assert result.data["model"] == "preisach"
    assert result.data["parameters"]["s"]["value"] == pytest.approx(1e7, rel=0.02)
    assert result.data["parameters"]["s"]["unit"] == "N/m"
    assert [item["rank"] for item in result.data["models"]] == [1, 2]
    assert result.data["metrics"]["held_out_error_percent"] < 0.3
    checked = bristle("check", model, "--json", code=0)
    assert checked.data["certificates"]["dissipation"]["passed"]
    predicted = bristle("predict", model, log, "--axis", axis, "--json", "--out", loops / "said", code=0)
    assert predicted.data["metrics"]["error_percent"] == pytest.approx(result.data["metrics"]["error_percent"])
    assert predicted.data["metrics"]["unit"] == "N"
    for folder, title in (("out", "loops: preisach identified"), ("said", "loops: prediction by preisach")):
        page = (loops / folder / "report.html").read_text()
        assert title in page
        assert page.count("<svg") == 2


@pytest.mark.slow
def test_figures_of_operators_are_files(bristle, loops):  # noqa: F811
    line = ("identify", loops / "loops.csv", "--model", "preisach", "--axis", loops / "axis.toml", "--out", loops / "out")
    assert bristle(*line, "--format", "svg", "--format", "csv").code == 0
    names = {item.name for item in (loops / "out" / "figures").iterdir()}
    assert {"curves.svg", "errors.svg", "captions.txt"} <= names
    assert any(name.startswith("curves") and name.endswith(".csv") for name in names)


def test_fits_before_an_interruption_are_written_and_marked(bristle, loops, monkeypatch, undrawn):  # noqa: F811
    def interrupted(*values, **options):
        raise KeyboardInterrupt

    monkeypatch.setitem(FITTED, "preisach_grid", interrupted)
    requested = ("identify", loops / "loops.csv", "--axis", loops / "axis.toml", "--out", loops / "part")
    result = bristle(*requested, "--model", "prandtl_ishlinskii,preisach_grid,preisach", "--json", code=130)
    words = "interrupted: preisach_grid, preisach were not fitted"
    assert result.data["unfinished"] == words
    assert words in result.err
    assert [item["name"] for item in result.data["models"]] == ["prandtl_ishlinskii"]
    assert f'unfinished = "{words}"' in (loops / "part" / "model.toml").read_text()
    assert f"Unfinished; {words}." in (loops / "part" / "report.html").read_text()
    bristle(*requested[:-1], loops / "none", "--model", "preisach_grid", code=130)
    assert not (loops / "none").exists()


def test_readable_output_of_operators(bristle, loops):  # noqa: F811
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
    ("arguments", "said"), [(("--model", "lugre"), "is not a valid choice"), (("--model", "reversal_table"), "needs reversal curves")]
)
def test_unsuitable_curves_end_with_a_message(bristle, loops, arguments, said):  # noqa: F811
    bristle("identify", loops / "loops.csv", "--axis", loops / "axis.toml", *arguments, code=2, said=said)


def test_two_files_and_a_missing_axis_are_refused(bristle, loops):  # noqa: F811
    log = loops / "loops.csv"
    bristle("identify", log, log, "--axis", loops / "axis.toml", code=2, said="needs a single file of curves")
    write_operator(loops / "model.toml", hysteresis.preisach(s=1e7, f_p=20.0))
    bristle("predict", loops / "model.toml", log, code=2, said="names the columns of input and output")
