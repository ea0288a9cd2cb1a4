"""``bristle identify``: what it prints, what it writes."""

import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from tests.cli.conftest import written_in

from bristle.core.errors import InputWarning
from bristle.files import read_model
from bristle.identification.settings import thresholds

TRUTH = {"M": 20.0, "F_C": 8.0, "F_v": 40.0, "offset": 0.0}


def test_the_parameters_of_a_simulated_axis_come_back(bristle, place):
    found = bristle("identify", "log.csv", "--axis", "axis.toml", "--model", "coulomb_viscous", "--json")
    assert found.code == 0
    assert found.err == ""
    for name, true in TRUTH.items():
        assert found.data["parameters"][name]["value"] == pytest.approx(true, rel=0.03, abs=0.2), name
    assert found.data["parameters"]["F_C"]["unit"] == "N"
    assert found.data["parameters"]["M"]["relative_std_percent"] < 1.0
    assert found.data["metrics"]["force_error_percent"] < 5.0
    assert not [one for one in place.iterdir() if one.is_dir()]


def test_the_folder_of_results_is_complete_and_agrees_with_what_was_printed(bristle, place):
    models = "viscous,coulomb_viscous"
    found = bristle("identify", "log.csv", "--axis", "axis.toml", "--model", models, "--out", "run", "--json")
    assert found.code == 0
    assert written_in("run") == {
        "model.toml",
        "summary.json",
        "report.html",
        "drive_table.csv",
        "axis.toml",
        "friction_curve.csv",
        "draws.parquet",
        "traces.parquet",
        "experiment.toml",
        "loop.csv",
    }
    assert Path("run/axis.toml").read_bytes() == Path("axis.toml").read_bytes()
    assert json.loads(Path("run/summary.json").read_text()) == found.data
    plant, friction, info = read_model("run/model.toml")
    printed = {name: one["value"] for name, one in found.data["parameters"].items()}
    assert {**plant.values, **friction.values} == printed
    assert info["uncertainty"]["M"]["std"] == found.data["parameters"]["M"]["std"]
    assert info["provenance"]["command"] == found.data["provenance"]["command"]
    assert len(info["provenance"]["log_sha256"]) == 64
    assert [one["name"] for one in found.data["models"]] == ["coulomb_viscous", "viscous"]
    assert [one["rank"] for one in found.data["models"]] == [1, 2]
    table = Path("run/drive_table.csv").read_text().splitlines()
    assert table[0] == "velocity [m/s],effort [N]"
    assert 4 <= len(table) - 1 <= 20


def test_intervals_scatter_and_certificates_are_told_and_bands_come_with_a_prediction(bristle, place):
    asked = ("identify", "log.csv", "--axis", "axis.toml", "--model", "viscous,coulomb_viscous", "--draws", 40)
    found = bristle(*asked, "--out", "run", "--json").data
    for name in ("F_C", "F_v"):
        one = found["parameters"][name]
        if one["status"] == "identified":
            low, high = one["interval"]
            # The filter rounds what friction does at reversals: the value may lie beside the interval, which is told.
            assert low < TRUTH[name] < high
            notes = [each["numbers"] for each in found["diagnostics"] if each["code"] == "shifted"]
            assert (name in str(notes)) == (not low < one["value"] < high)
            assert one["interval_percent"] == pytest.approx(50.0 * (high - low) / abs(one["value"]))
    resampling = found["resampling"]
    assert resampling["draws"] == 40
    assert resampling["scatter"]["low"] <= resampling["scatter"]["value"] <= resampling["scatter"]["high"]
    assert resampling["inflation"] >= 1.0
    assert {"well_posed", "passive"} <= set(found["certificates"])
    assert found["certificates"]["passive"]["passed"] is True
    best, other = (one["metrics"] for one in found["models"])
    assert (best["aic"], best["bic"]) == (0.0, 0.0)
    assert min(other["aic"], other["bic"]) > 10.0
    page = Path("run/report.html").read_text()
    assert "Is the model fit to be used?" in page
    assert "Scatter of friction from reversal to reversal" in page or resampling["scatter"]["value"] == 0.0
    predicted = bristle("predict", "run/model.toml", "log.csv", "--axis", "axis.toml", "--json").data
    assert 90.0 < predicted["inside_band_percent"] <= 100.0
    model = Path("run/model.toml")
    model.write_text(model.read_text().partition("[bands]")[0])
    without = bristle("predict", "run/model.toml", "log.csv", "--axis", "axis.toml", "--json").data
    assert without["inside_band_percent"] is None
    assert without["metrics"] == predicted["metrics"]


def test_the_treatment_asked_for_is_that_of_the_prediction(bristle, place):
    asked = ("--cutoff", "40 Hz")
    found = bristle("identify", "log.csv", "--axis", "axis.toml", *asked, "--out", "run", "--json")
    predicted = bristle("predict", "run/model.toml", "log.csv", "--axis", "axis.toml", "--json")
    error = found.data["metrics"]["force_error_percent"]
    assert predicted.data["metrics"]["force_error_percent"] == pytest.approx(error, rel=1e-9)
    model = Path("run/model.toml")
    model.write_text(model.read_text().replace("cutoff = 40.0", "cutoff = 400.0"))
    otherwise = bristle("predict", "run/model.toml", "log.csv", "--axis", "axis.toml", "--json")
    assert abs(otherwise.data["metrics"]["force_error_percent"] / error - 1.0) > 0.01


def test_without_draws_how_sure_is_told_for_correlated_residuals_too(bristle, place):
    found = bristle("identify", "log.csv", "--axis", "axis.toml", "--draws", 0, "--out", "run", "--json").data
    assert found["resampling"] is None
    raw = tomllib.loads(Path("run/model.toml").read_text())["uncertainty"]
    for name, one in found["parameters"].items():
        assert raw[name]["robust_std"] == one["robust_std"] > 0.0
        half = 1.96 * max(one["std"], one["robust_std"]) / abs(one["value"])
        assert one["interval_percent"] == pytest.approx(100.0 * half)
    assert found["metrics"]["friction_error_percent"] > found["metrics"]["force_error_percent"]


def test_the_loop_is_judged_when_the_axis_has_a_controller_and_not_otherwise(bristle, place):
    found = bristle("identify", "log.csv", "--axis", "axis.toml", "--json").data
    variants = found["compensation"]
    peaks = {name: one["following_error"]["peak_to_peak"] for name, one in variants.items()}
    assert peaks["compensated"] < 0.5 * peaks["feedforward"] < peaks["as_recorded"]
    assert found["prediction"]["metrics"]["force_error_percent"] < 5.0
    axis = Path("axis.toml")
    axis.write_text(axis.read_text().partition("[controller]")[0])
    alone = bristle("identify", "log.csv", "--axis", "axis.toml", "--json").data
    assert alone["compensation"] is None
    assert alone["prediction"] is None
    assert alone["parameters"] == found["parameters"]


def test_the_report_asks_for_nothing_outside_and_names_the_command(bristle, place):
    assert bristle("identify", "log.csv", "--axis", "axis.toml", "--draws", 0, "--out", "run").code == 0
    page = Path("run/report.html").read_text()
    assert "bristle identify log.csv --axis axis.toml --draws 0 --out run" in page
    assert not re.search(r"""(src|href)=["']?https?:""", page)


def test_results_are_kept_without_force(bristle, place):
    arguments = ("identify", "log.csv", "--axis", "axis.toml", "--draws", 0, "--out", "run")
    assert bristle(*arguments, "--model", "coulomb_viscous").code == 0
    before = Path("run/model.toml").read_bytes()
    again = bristle(*arguments, "--model", "viscous")
    assert again.code == 2
    assert "--force" in again.err
    assert Path("run/model.toml").read_bytes() == before
    assert bristle(*arguments, "--model", "viscous", "--force").code == 0
    assert read_model("run/model.toml").friction.name == "viscous"


def test_the_filter_option_changes_the_treatment(bristle, place):
    found = bristle("identify", "log.csv", "--axis", "axis.toml", "--cutoff", "0.04 kHz", "--json")
    assert found.data["treatment"]["cutoff"] == 40.0


def test_a_model_of_a_users_own_is_identified_and_kept_with_its_file(bristle, place):
    asked = ("--model", "own.py+asymmetry", "--draws", 0)
    found = bristle("identify", "log.csv", "--axis", "axis.toml", *asked, "--out", "run", "--json")
    assert found.code == 0
    assert set(found.data["parameters"]) == {"M", "F_0_pos", "F_0_neg", "offset"}
    Path("own.py").unlink()
    with pytest.warns(InputWarning, match=r"own\.py"):
        friction = read_model("run/model.toml").friction  # the person has run that very code
    assert friction.name == "own+asymmetry"
    assert friction.values["F_0_pos"] == found.data["parameters"]["F_0_pos"]["value"]


def test_tables_for_people(bristle, place):
    found = bristle("identify", "log.csv", "--axis", "axis.toml", "--model", "viscous,coulomb_viscous")
    assert found.code == 0
    assert "Parameters of coulomb_viscous" in found.out
    assert "±" in found.out
    assert "Models compared" in found.out


@pytest.mark.measured
@pytest.mark.parametrize(("model", "error"), [("coulomb_viscous", (4.0, 4.2)), ("coulomb_viscous+asymmetry", (3.1, 3.25))])
def test_emps(bristle, emps, model, error):
    axis = Path(__file__).parents[2] / "examples" / "emps" / "axis.toml"
    found = bristle("identify", emps, "--axis", axis, "--model", model, "--json")
    assert found.code == 0
    assert error[0] <= found.data["metrics"]["force_error_percent"] <= error[1]


@pytest.mark.skipif(os.name != "posix", reason="limits of POSIX")
def test_a_limit_on_the_size_of_files_is_told_and_keeps_what_was(place):
    arguments = [sys.executable, "-c", "import sys; from bristle.cli.main import main; sys.exit(main())"]
    arguments += ["identify", "log.csv", "--axis", "axis.toml", "--model", "viscous", "--draws", "0"]
    arguments += ["--out", "run", "--force"]
    assert subprocess.run(arguments, check=False, capture_output=True).returncode == 0
    before = {one.name: one.read_bytes() for one in Path("run").iterdir()}
    limited = ["bash", "-c", f"ulimit -f 30; exec {shlex.join(arguments)}"]
    ended = subprocess.run(limited, check=False, capture_output=True, text=True)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert len(ended.stderr.splitlines()) == 1
    assert "file too large" in ended.stderr
    assert {one.name: one.read_bytes() for one in Path("run").iterdir()} == before
    assert [one.name for one in (*place.glob("run*"), *place.glob("bristle-*"))] == ["run"]


def test_what_a_model_of_ones_own_prints_is_no_part_of_the_object(bristle, place):
    own = place / "own.py"
    own.write_text(f"print('hello')\n{own.read_text()}")
    ended = bristle("identify", "log.csv", "--axis", "axis.toml", "--model", "own.py", "--draws", 0, "--json")
    assert ended.data["model"] == "own"
    assert ended.err == "hello\n"


def test_a_model_of_ones_own_that_drives_is_warned_of(bristle, place):
    own = place / "own.py"
    own.write_text(own.read_text().replace("return p.F_0", "return -p.F_0"))
    ended = bristle("identify", "log.csv", "--axis", "axis.toml", "--model", "own.py", "--draws", 0)
    assert ended.code == 0
    (line,) = [line for line in ended.err.splitlines() if "contract" in line]
    assert line.startswith("bristle: warning: own.py: does not meet the contract of a friction model: ")
    assert "opposes sliding, dissipates" in line


def test_the_command_line_takes_several_logs(bristle, place):
    text = (place / "log.csv").read_text().splitlines()
    half = len(text) // 2
    (place / "second.csv").write_text("\n".join([text[0], *text[half:]]) + "\n")
    found = bristle("identify", "log.csv", "second.csv", "--axis", "axis.toml", "--draws", 0, "--out", "both", "--json")
    assert found.code == 0, found.err
    assert found.data["further_logs"] == ["second.csv"]
    assert {"log", "log_2", "log_2_sha256", "axis"} <= set(found.data["provenance"])
    assert found.data["parameters"]["M"]["value"] == pytest.approx(20.0, rel=0.03)
    page = (place / "both" / "report.html").read_text()
    assert "on logs that it was not fitted to" in page
    assert "Further logs" in page
    wrong = bristle("identify", "log.csv", "--axis", "axis.toml", "--axis", "axis.toml")
    assert wrong.code == 2
    assert "axis: 2 for 1 logs" in wrong.err


def test_an_axis_file_sets_thresholds(bristle, place):
    axis = place / "axis.toml"
    axis.write_text(axis.read_text() + "\n[identification.settings]\npoor_error = 0.0\ninseparable = 0.5\n")
    asked = ("identify", "log.csv", "--axis", "axis.toml", "--draws", "0")
    found = bristle(*asked, "--json").data
    assert (found["settings"]["poor_error"], found["settings"]["inseparable"]) == (0.0, 0.5)
    assert set(found["settings"]) == {one.name for one in thresholds()}
    assert "unexplained" in [one["code"] for one in found["diagnostics"]]
    axis.write_text(axis.read_text() + "nothing = 1.0\n")
    refused = bristle(*asked)
    assert refused.code == 2
    assert "identification.settings.nothing" in refused.err


def test_a_delay_that_was_found_is_told_before_the_parameters(bristle, place):
    rows = Path("log.csv").read_text().splitlines()
    cells = [row.split(",") for row in rows]
    late = [[*cells[i][:3], cells[max(i - 4, 1)][3]] for i in range(1, len(cells))]
    Path("late.csv").write_text("\n".join([rows[0], *(",".join(one) for one in late)]))
    told = bristle("identify", "late.csv", "--axis", "axis.toml", "--model", "coulomb_viscous", "--draws", 0).out
    first, _, rest = told.partition("Parameters of")
    assert "effort lags the position by" in " ".join(first.split())
    assert rest


def test_the_help_says_how_many_draws_there_may_be(bristle):
    assert "0, or 20 to" in " ".join(bristle("identify", "--help").out.split()).replace("│ ", "")


def next_command(found):
    """The command that the last line on the error stream names, as a person would type it."""
    line = next(line for line in found.err.splitlines() if "next: " in line)
    return shlex.split(line[line.index("bristle run") :])[1:]


def test_the_next_step_runs_as_it_is_named(bristle, place):
    found = bristle("identify", "log.csv", "--axis", "axis.toml", "--draws", "0", "--out", "run")
    command = next_command(found)
    assert command[:2] == ["run", str(Path("run/experiment.toml"))]
    ran = bristle(*command, "--json")
    assert ran.code == 0, ran.err
    errors = {name: one["following_error"]["rms"] for name, one in ran.data["variants"].items()}
    assert list(errors) == ["as_recorded", "feedforward", "compensated"]
    assert errors["compensated"] < 0.5 * errors["feedforward"] < 0.5 * errors["as_recorded"]
    said = json.loads(Path("run/summary.json").read_text())["compensation"]
    # The loop that identify simulated is the one that run simulates, and design.
    for name, one in ran.data["variants"].items():
        promised = said[name]["following_error"]["peak_to_peak"]
        assert one["following_error"]["peak_to_peak"] == pytest.approx(promised, rel=0.01)
    designed = bristle("design", "run/experiment.toml", "--json")
    assert designed.code == 0
    total = ran.data["variants"]["compensated"]["following_error"]["peak_to_peak"]
    assert designed.data["budget"]["everything"]["peak_to_peak"] == pytest.approx(total, rel=0.01)
    unexplained = re.sub(r"(?s)\[disturbance\][^\[]*", "", Path("run/experiment.toml").read_text())
    Path("run/experiment.toml").write_text(unexplained)
    without = bristle("run", "run/experiment.toml", "--json")
    assert without.code == 0, without.err
    assert without.data["variants"]["compensated"]["following_error"]["peak_to_peak"] < 0.95 * total
    law = ["--law", "run/experiment.toml", "--variant", "compensated"]
    assert bristle("export", *law, "--to", "c", "--out", "law").code == 0


def test_of_an_axis_without_a_loop_two_gains_are_filled_in(bristle, place):
    lines = Path("axis.toml").read_text().split("[controller]")[0].splitlines()
    Path("open.toml").write_text("\n".join(line for line in lines if not line.startswith("reference")))
    found = bristle("identify", "log.csv", "--axis", "open.toml", "--draws", "0", "--out", "run")
    assert "write controller.k_p and controller.k_v into the axis file" in found.err
    assert "--force then no longer writes over run)" in found.err
    command = next_command(found)
    refused = bristle(*command)
    assert refused.code == 2
    assert "controller.k_p: is still to be filled in" in refused.err
    file = Path("run/experiment.toml")
    filled = re.sub(r'"\?"( +# [^\n]*such as )("[^"]+")', r"\2\1\2", file.read_text())
    filled, hints = re.subn(r"(?m)^# (T_n|k_ff)", r"\1", filled)
    assert hints == 2
    file.write_text(filled)
    ran = bristle(*command, "--json")
    assert ran.code == 0, ran.err
    errors = {name: one["following_error"]["rms"] for name, one in ran.data["variants"].items()}
    assert errors["compensated"] < errors["as_recorded"]
    again = bristle("identify", "log.csv", "--axis", "open.toml", "--draws", "0", "--out", "run", "--force")
    assert again.code == 2
