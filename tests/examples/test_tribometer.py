"""The example of a reciprocating contact: its second half, predicted from a fit to the first."""

from pathlib import Path

import pytest
from tests.cli.conftest import bristle  # noqa: F401
from tests.examples.data import data_of, measured

from bristle.files import read_axis, read_log
from bristle.identification import identify
from bristle.logs.assembly import within
from bristle.prediction import predict
from bristle.report.messages import assumptions_of

pytestmark = pytest.mark.slow

AXIS = Path(__file__).parents[2] / "examples" / "tribometer" / "axis.toml"
MIDDLE = 108.5  # [s]


@pytest.fixture(scope="module")
def log_file() -> Path:
    return measured("tribometer", "test_data_2.txt")


@pytest.fixture(scope="module")
def result(log_file):
    axis = read_axis(AXIS)
    log = read_log(log_file, axis)
    models = "dahl,maxwell_slip,maxwell_slip+position"
    return (
        identify(within(log, (12.0, MIDDLE)), models, axis=axis, free="exponent", draws=0),
        within(log, (MIDDLE, 205.0)),
        axis,
    )


@pytest.mark.measured
@pytest.mark.parametrize(
    ("name", "most"), [("dahl", 0.121), ("maxwell_slip", 0.112), ("maxwell_slip+position", 0.085)]
)
def test_the_second_half_is_predicted_from_the_first(result, name, most):
    identification, second, axis = result
    fit = next(item for item in identification.fits if item.name == name)
    assert predict(fit.plant, fit.friction, second, axis).metrics["force_rmse"] <= most


@pytest.mark.measured
def test_break_away_repeats_from_stroke_to_stroke(result):
    identification, _, _ = result
    (item,) = identification.break_aways
    assert item.legs == 48
    assert item.force == pytest.approx(2.333, abs=0.005)
    assert item.force_interval == pytest.approx((2.326, 2.339), abs=0.003)
    assert 1e6 * item.distance == pytest.approx(103.2, abs=0.5)


@pytest.mark.measured
def test_unidentifiable_parameters_of_this_log_are_reported(result):
    identification, _, _ = result
    # Its terms of the place predict the second half better, by less than one stroke differs from the next.
    assert identification.best.name == "maxwell_slip"
    for fit in identification.fits:
        message = " ".join(assumptions_of(fit))
        assert "the log repeats one motion every 4 s" in message


@pytest.mark.measured
def test_the_model_file_predicts_the_log_through_the_command_line(bristle, log_file, tmp_path):  # noqa: F811
    requested = ("--model", "maxwell_slip", "--draws", "0", "--out", tmp_path / "out")
    done = data_of(bristle("identify", log_file, "--axis", AXIS, *requested, "--json"))
    assert done["parameters"]["F_C"]["value"] == pytest.approx(2.37, abs=0.05)
    text = data_of(
        bristle("predict", tmp_path / "out" / "model.toml", log_file, "--axis", AXIS, "--json")
    )
    assert text["metrics"]["force_error_percent"] == pytest.approx(
        done["metrics"]["force_error_percent"]
    )
