"""The example of a magnet: its reversal curves as an operator, every fifth of them held out by turns."""

from pathlib import Path

import pytest
from tests.cli.conftest import bristle  # noqa: F401
from tests.examples.data import data_of, measured

from bristle.files import read_curves
from bristle.files.operator import read_operator, write_operator
from bristle.identification.hysteresis import predict_operator
from bristle.identification.hysteresis.linear import fit_grid
from bristle.logs.curves import Curves

pytestmark = pytest.mark.slow

AXIS = Path(__file__).parents[2] / "examples" / "forc" / "axis.toml"


@pytest.fixture(scope="module")
def curves_file() -> Path:
    return measured("forc", "forc_curves.npz")


@pytest.fixture(scope="module")
def recorded(curves_file) -> Curves:
    return read_curves(curves_file, AXIS)


@pytest.mark.measured
def test_the_curves_are_those_of_the_sample(recorded):
    assert len(recorded.curves) == 246
    assert recorded.full_scale == pytest.approx(1.195e-5, rel=1e-3)
    assert recorded.low == pytest.approx(-0.3001, abs=1e-4)


@pytest.mark.measured
def test_the_table_along_the_curves_and_the_positive_measure(bristle, curves_file, tmp_path):  # noqa: F811
    requested = ("--model", "reversal_table,preisach_grid", "--out", tmp_path / "out")
    result = data_of(bristle("identify", curves_file, "--axis", AXIS, *requested, "--json"))
    table, grid = result["models"]
    assert (table["name"], grid["name"]) == ("reversal_table", "preisach_grid")
    assert table["metrics"]["held_out_error_percent"] <= 0.021
    assert grid["metrics"]["held_out_error_percent"] <= 0.2
    assert any("the sign of a magnet" in note for note in grid["notes"])
    # What is left is what neighbouring curves differ by.
    assert result["congruency"]["alike"] == pytest.approx(
        0.0002 * result["log"]["full_scale"], rel=0.3
    )
    text = data_of(
        bristle("predict", tmp_path / "out" / "model.toml", curves_file, "--axis", AXIS, "--json")
    )
    # What was smoothed away is the noise of a sample.
    assert text["metrics"]["error_percent"] == pytest.approx(table["metrics"]["error_percent"])
    assert text["metrics"]["error_percent"] < 0.015


@pytest.mark.measured
def test_the_measure_of_cells_has_the_documented_values(recorded, tmp_path):
    fit = fit_grid(recorded)
    write_operator(tmp_path / "model.toml", fit.operator)
    operator, offset, _ = read_operator(tmp_path / "model.toml")
    assert (operator.kind, offset) == ("magnetic", 0.0)
    assert predict_operator(operator, recorded).error_percent == pytest.approx(0.118, abs=0.01)


@pytest.mark.measured
def test_the_sign_of_friction_does_not_fit_a_magnet(recorded):
    sample = Curves(recorded.curves[::5], recorded.start, recorded.kind)
    friction, magnet = (
        fit_grid(sample, cells=20, signs=(sign,)) for sign in ("friction", "magnet")
    )
    assert friction.rms > 20.0 * magnet.rms
