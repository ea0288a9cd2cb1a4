"""The example of a measured axis, from file to result through the command line: as published, and with known pulses."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from tests.cli.conftest import bristle, emps
from tests.examples.data import data_of

from bristle import sensors
from bristle.engine import run_closed_loop
from bristle.files import read_axis
from bristle.models.friction import find, with_presliding
from bristle.models.plants import inertia

pytestmark = pytest.mark.slow

AXIS = Path(__file__).parents[2] / "examples" / "emps" / "axis.toml"
NEWTON_PER_VOLT = 35.15065188
PULSE_VOLT = 5.0695


@pytest.fixture
def identified(bristle, tmp_path):
    """Identify a log into a folder, and return what is printed as JSON."""

    def run(log, model):
        result = data_of(
            bristle(
                "identify",
                log,
                "--axis",
                AXIS,
                "--model",
                model,
                "--out",
                tmp_path / "out",
                "--json",
            )
        )
        assert json.loads((tmp_path / "out" / "summary.json").read_text()) == result
        return result

    return run


@pytest.mark.measured
@pytest.mark.parametrize(
    ("model", "errors", "in_loop"),
    [("coulomb_viscous", (4.0, 4.2), 4.5), ("coulomb_viscous+asymmetry", (3.1, 3.25), 3.6)],
)
def test_friction_as_published_predicts_the_loop(
    bristle, emps, identified, tmp_path, model, errors, in_loop
):
    # What is published of the parameters is compared in tests/identification/test_emps.py.
    result = identified(emps, model)
    assert errors[0] < result["metrics"]["force_error_percent"] < errors[1]
    looped = bristle(
        "predict",
        tmp_path / "out" / "model.toml",
        emps,
        "--axis",
        AXIS,
        "--mode",
        "closed-loop",
        "--json",
    )
    assert looped.data["metrics"]["force_error_percent"] <= in_loop
    assert looped.data["metrics"]["position_error_percent"] <= 0.0012


@pytest.mark.measured
def test_a_reversed_effort_is_reported_even_with_a_known_mass(bristle, emps, tmp_path):
    text = AXIS.read_text().replace(
        'column = "vir", unit = "V"', 'column = "vir", unit = "V", sign = -1'
    )
    (tmp_path / "axis.toml").write_text(text.replace("[plant]\n", '[plant]\nmass = "95 kg"\n'))
    message = bristle("identify", emps, "--axis", tmp_path / "axis.toml", "--draws", "0", "--json")
    assert [
        result["code"] for result in message.data["diagnostics"] if result["severity"] == "error"
    ] == ["sign_reversed"]
    levels = [
        item["status"]
        for name, item in message.data["parameters"].items()
        if name.startswith("F_C")
    ]
    assert levels
    assert "identified" not in levels


@pytest.fixture(scope="module")
def pulse_record(tmp_path_factory) -> Path:
    """A record of the axis, simulated, with pulses behind the controller; columns and units are those measured."""
    axis, dt = read_axis(AXIS), 1e-3
    t = dt * np.arange(8000)
    reference = 0.06 * (1.0 - np.cos(2.0 * np.pi * t / 4.0)) + 0.01 * (
        1.0 - np.cos(2.0 * np.pi * t / 1.3)
    )
    on = (t % 1.0 > 0.4) & (t % 1.0 < 0.45)
    truth = find("coulomb_viscous+asymmetry")(
        F_C_pos=20.1, F_C_neg=20.6, F_v_pos=167.0, F_v_neg=240.0
    )
    turning = with_presliding(truth, axis.presliding)
    desired = np.zeros((4, t.size))
    desired[0] = reference
    trace = run_closed_loop(
        inertia(M=95.0),
        turning,
        axis.controller,
        sensors.encoder(resolution=axis.resolution),
        desired,
        dt,
        steps=8,
        injected=NEWTON_PER_VOLT * PULSE_VOLT * on,
        limit=axis.effort_limit or math.inf,
    )
    record = {
        "t": t,
        "qm": trace.measured,
        "qg": reference,
        "vir": trace.command / NEWTON_PER_VOLT,
        "pulses_N": 5.0 * on,
    }
    path = tmp_path_factory.mktemp("pulses") / "DATA_EMPS_PULSES.mat"
    scipy.io.savemat(path, {name: values.reshape(-1, 1) for name, values in record.items()})
    return path


def test_a_record_with_pulses_is_predicted_with_the_same_axis_file(
    bristle, identified, pulse_record, tmp_path
):
    vir = scipy.io.loadmat(pulse_record)["vir"].ravel()
    assert np.max(np.abs(np.diff(vir))) > 4.9  # the effort column holds the pulses, 5.07 V each
    model = tmp_path / "out" / "model.toml"
    assert identified(pulse_record, "coulomb_viscous+asymmetry")["parameters"]["M"][
        "value"
    ] == pytest.approx(95, rel=0.01)
    knowing = bristle(
        "predict", model, pulse_record, "--axis", AXIS, "--mode", "closed-loop", "--json"
    ).data
    assert knowing["metrics"]["force_error_percent"] < 2.0
    ignorant_axis = tmp_path / "ignorant.toml"
    ignorant_axis.write_text(
        AXIS.read_text().replace('column = "pulses_N"', 'column = "no_such_column"')
    )
    ignorant = bristle(
        "predict", model, pulse_record, "--axis", ignorant_axis, "--mode", "closed-loop", "--json"
    ).data
    assert (
        ignorant["metrics"]["force_error_percent"] > 7.0 * knowing["metrics"]["force_error_percent"]
    )


REFINED = AXIS.with_name("axis_refined.toml")


@pytest.mark.measured
@pytest.mark.parametrize(
    ("model", "options", "percent"),
    [
        ("stribeck_free+periodic+asymmetry", "--free delta_S", 2.3),
        ("stribeck_free+position+periodic+asymmetry", "--free delta_S", 2.0),
        ("stribeck_free+asymmetry", "--method output_error --draws 0", 2.6),
    ],
)
def test_the_second_half_is_predicted_from_a_fit_to_the_first(
    bristle, emps, tmp_path, model, options, percent
):
    halves = []
    for name, span in (("first", '["0 s", "12.42 s"]'), ("second", '["12.42 s", "24.9 s"]')):
        halves.append(tmp_path / f"{name}.toml")
        halves[-1].write_text(
            REFINED.read_text().replace("[columns]", f"[log]\nspan = {span}\n\n[columns]", 1)
        )
    out = tmp_path / "out"
    result = data_of(
        bristle(
            "identify",
            emps,
            "--axis",
            halves[0],
            "--model",
            model,
            *options.split(),
            "--out",
            out,
            "--json",
        )
    )
    known = result["parameters"]
    assert known["F_0_pos"]["value"] < 0.8 * known["F_C_pos"]["value"]
    assert any("friction rises from" in item for item in result["warnings"])
    # The ripple of the screw, or the lag of the drive.
    found = (
        math.hypot(known["c_1_pos"]["value"], known["s_1_pos"]["value"])
        if "c_1_pos" in known
        else known["lag"]["value"]
    )
    assert found > 0.8 if "c_1_pos" in known else found == pytest.approx(0.28e-3, rel=0.1)
    predicted = bristle(
        "predict", out / "model.toml", emps, "--axis", halves[1], "--mode", "closed-loop", "--json"
    )
    assert predicted.data["metrics"]["force_error_percent"] <= percent


def test_a_loop_with_pulses_is_fitted_as_a_whole(bristle, pulse_record, tmp_path):
    out = tmp_path / "out"
    requested = (
        "--axis",
        REFINED,
        "--model",
        "coulomb_viscous+asymmetry",
        "--method",
        "output_error",
        "--draws",
        "40",
    )
    result = data_of(bristle("identify", pulse_record, *requested, "--out", out, "--json"))
    assert result["metrics"]["loop_error_percent"] < 1.0
    known = result["parameters"]
    truth = {"M": 95.0, "F_C_pos": 20.1, "F_C_neg": 20.6, "F_v_pos": 167.0, "F_v_neg": 240.0}
    for name, value in truth.items():
        assert known[name]["value"] == pytest.approx(value, rel=0.01), name
    assert known["lag"]["value"] < 2e-5
    looped = bristle(
        "predict",
        out / "model.toml",
        pulse_record,
        "--axis",
        REFINED,
        "--mode",
        "closed-loop",
        "--json",
    )
    assert looped.data["metrics"]["force_error_percent"] < 2.0
