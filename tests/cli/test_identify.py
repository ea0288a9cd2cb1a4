"""``bristle identify``: what it prints, what it writes."""

import json
import os
import pkgutil
import re
import shlex
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import pytest
from tests.cli.conftest import IDENTIFY, WITH_DRAWS, written_in

from bristle.files import read_model
from bristle.identification.settings import Settings
from bristle.report import identified as of_report

pytestmark = pytest.mark.usefixtures("undrawn", "remembered")

TRUTH = {"M": 20.0, "F_C": 8.0, "F_v": 40.0, "offset": 0.0}


@pytest.mark.slow
def test_the_parameters_of_a_simulated_axis_are_identified(bristle, place):
    result = bristle(*IDENTIFY, "--json", code=0)
    assert result.err == ""
    for name, true in TRUTH.items():
        assert result.data["parameters"][name]["value"] == pytest.approx(true, rel=0.03, abs=0.2), (
            name
        )
    assert result.data["parameters"]["F_C"]["unit"] == "N"
    assert result.data["parameters"]["M"]["relative_std_percent"] < 1.0
    assert result.data["metrics"]["force_error_percent"] < 5.0
    assert not [item for item in place.iterdir() if item.is_dir()]


@pytest.mark.slow
def test_the_folder_of_results_is_complete_and_agrees_with_the_output(bristle, place):
    result = bristle(*IDENTIFY, "--out", "run", "--json", code=0)
    assert written_in("run") == {
        "model.toml",
        "summary.json",
        "report.html",
        "drive_table.csv",
        "axis.toml",
        "friction_curve.csv",
        "traces.parquet",
        "experiment.toml",
        "loop.csv",
    }
    assert Path("run/axis.toml").read_bytes() == Path("axis.toml").read_bytes()
    assert json.loads(Path("run/summary.json").read_text()) == result.data
    plant, friction, info = read_model("run/model.toml")
    printed = {name: item["value"] for name, item in result.data["parameters"].items()}
    assert {**plant.values, **friction.values} == printed
    assert info["uncertainty"]["M"]["std"] == result.data["parameters"]["M"]["std"]
    assert info["provenance"]["command"] == result.data["provenance"]["command"]
    assert len(info["provenance"]["log_sha256"]) == 64
    assert [(item["name"], item["rank"]) for item in result.data["models"]] == [
        ("coulomb_viscous", 1),
        ("viscous", 2),
    ]
    table = Path("run/drive_table.csv").read_text().splitlines()
    assert table[0] == "velocity [m/s],effort [N]"
    assert 4 <= len(table) - 1 <= 20
    assert [
        path.name for path in Path("run").iterdir() if str(place).encode() in path.read_bytes()
    ] == []
    page = Path("run/report.html").read_text()
    assert (
        "bristle identify log.csv --axis axis.toml --model viscous,coulomb_viscous --draws 0 --out run"
        in page
    )
    assert not re.search(r"""(src|href)=["']?https?:""", page)


@pytest.mark.slow
def test_intervals_scatter_certificates_and_bands_are_reported(bristle, place):
    data = bristle(*IDENTIFY[:-1], 40, "--out", "run", "--json").data
    assert {"draws.parquet", "traces.parquet"} <= written_in("run")
    for name in ("F_C", "F_v"):
        item = data["parameters"][name]
        if item["status"] == "identified":
            low, high = item["interval"]
            assert low < TRUTH[name] < high
            assert low <= item["value"] <= high
            assert item["interval_percent"] == pytest.approx(
                50.0 * (high - low) / abs(item["value"])
            )
    resampling = data["resampling"]
    assert resampling["draws"] == 40
    assert (
        resampling["scatter"]["low"]
        <= resampling["scatter"]["value"]
        <= resampling["scatter"]["high"]
    )
    assert resampling["inflation"] >= 1.0
    assert {"well_posed", "passive"} <= set(data["certificates"])
    assert data["certificates"]["passive"]["passed"] is True
    best, other = (item["metrics"] for item in data["models"])
    assert (best["aic"], best["bic"]) == (0.0, 0.0)
    assert min(other["aic"], other["bic"]) > 10.0
    page = Path("run/report.html").read_text()
    assert "Certificates of" in page
    assert (
        "Scatter of friction from reversal to reversal" in page
        or resampling["scatter"]["value"] == 0.0
    )


@pytest.mark.slow
def test_a_prediction_uses_the_treatment_of_the_identification(bristle, place):
    result = bristle(*IDENTIFY, "--cutoff", "0.04 kHz", "--out", "run", "--json")
    assert result.data["treatment"]["cutoff"] == 40.0
    predicted = bristle("predict", "run/model.toml", "log.csv", "--axis", "axis.toml", "--json")
    error = result.data["metrics"]["force_error_percent"]
    assert predicted.data["metrics"]["force_error_percent"] == pytest.approx(error, rel=1e-9)
    model = Path("run/model.toml")
    model.write_text(model.read_text().replace("cutoff = 40.0", "cutoff = 400.0"))
    otherwise = bristle("predict", "run/model.toml", "log.csv", "--axis", "axis.toml", "--json")
    assert abs(otherwise.data["metrics"]["force_error_percent"] / error - 1.0) > 0.01


@pytest.mark.slow
def test_without_draws_intervals_include_correlated_residuals(bristle, place):
    data = bristle(*IDENTIFY, "--out", "run", "--json").data
    assert data["resampling"] is None
    raw = tomllib.loads(Path("run/model.toml").read_text())["uncertainty"]
    for name, item in data["parameters"].items():
        assert raw[name]["robust_std"] == item["robust_std"] > 0.0
        half = 1.96 * max(item["std"], item["robust_std"]) / abs(item["value"])
        assert item["interval_percent"] == pytest.approx(100.0 * half)
    assert data["metrics"]["friction_error_percent"] > data["metrics"]["force_error_percent"]


@pytest.mark.slow
def test_the_loop_is_judged_only_if_the_axis_has_a_controller(bristle, place, monkeypatch):
    monkeypatch.setattr(
        "bristle.identification.work.Work.task", task := Mock(return_value=lambda *told: None)
    )
    data = bristle(*IDENTIFY, "--json").data
    peaks = {
        name: item["following_error"]["peak_to_peak"] for name, item in data["compensation"].items()
    }
    assert peaks["compensated"] < 0.5 * peaks["feedforward"] < peaks["as_recorded"]
    assert data["prediction"]["metrics"]["force_error_percent"] < 5.0
    Path("axis.toml").write_text(Path("axis.toml").read_text().partition("[controller]")[0])
    alone = bristle(*IDENTIFY, "--json").data
    assert (alone["compensation"], alone["prediction"], alone["parameters"]) == (
        None,
        None,
        data["parameters"],
    )
    # Duration of the loop.
    assert [call.args[1] > 0.0 for call in task.call_args_list if call.args[:1] == ("",)] == [
        True,
        False,
    ]


@pytest.mark.slow
def test_a_terminal_shows_an_identification_in_25_lines_with_the_verdict_last(bristle, place):
    lines = bristle(*IDENTIFY).out.splitlines()
    assert len(lines) <= 25
    labels = [line[:12].strip() for line in lines if line[:12].strip()]
    assert labels[0] == "Model"
    assert labels[-2:] == ["Verdict", "Next"]
    assert {"Parameters", "Type in", "Gain"} <= set(labels)


def test_verbose_adds_the_tables_and_quiet_leaves_the_verdict(bristle, place):
    verbose = bristle(*IDENTIFY, "-v").out
    assert "Parameters of coulomb_viscous" in verbose
    assert "smallest held-out error first" in verbose
    assert {"Type in", "Gain", "Verdict"} <= {line[:12].strip() for line in verbose.splitlines()}
    quiet = bristle(*IDENTIFY, "--quiet")
    assert quiet.out.startswith("Verdict     Usable")
    assert len(quiet.out.splitlines()) == 1
    assert quiet.err == ""


@pytest.mark.parametrize(
    ("option", "done"),
    [("--json", []), ("--quiet", ["results"]), ("--draws=0", ["results", "rehearsal"])],
)
def test_only_a_person_who_has_read_the_results_waits_for_a_rehearsal(
    bristle, place, monkeypatch, option, done
):
    asked = []
    monkeypatch.setattr(
        "bristle.cli.identify.show_identification",
        lambda *arguments, **options: asked.append("results"),
    )
    monkeypatch.setattr(
        "bristle.cli.identify._motion_to_record", lambda *arguments: asked.append("rehearsal") or []
    )
    assert bristle(*IDENTIFY, "--out", "run", option).code == 0
    assert asked == done


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="limits of POSIX")
def test_a_limit_on_file_size_is_reported_and_keeps_old_results(place):
    arguments = [
        sys.executable,
        "-c",
        "import sys; from bristle.cli.main import main; sys.exit(main())",
    ]
    arguments += [
        "identify",
        "log.csv",
        "--axis",
        "axis.toml",
        "--model",
        "viscous",
        "--draws",
        "0",
    ]
    arguments += ["--out", "run", "--force"]
    assert subprocess.run(arguments, check=False, capture_output=True).returncode == 0
    before = {item.name: item.read_bytes() for item in Path("run").iterdir()}
    limited = ["bash", "-c", f"ulimit -f 30; exec {shlex.join(arguments)}"]
    ended = subprocess.run(limited, check=False, capture_output=True, text=True)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert len(ended.stderr.splitlines()) == 1
    assert "file too large" in ended.stderr
    assert {item.name: item.read_bytes() for item in Path("run").iterdir()} == before
    assert [item.name for item in (*place.glob("run*"), *place.glob("bristle-*"))] == ["run"]


def test_output_of_a_user_model_is_not_part_of_the_json(bristle, place, monkeypatch):
    monkeypatch.setattr("bristle.contract.admit", lambda model: None)
    custom = place / "own.py"
    custom.write_text(f"print('hello')\n{custom.read_text()}")
    ended = bristle("models", "own.py", "--json")
    assert ended.data["models"][0]["name"] == "own"
    assert ended.err == "hello\n"


def test_a_log_that_is_too_short_is_named_and_left_out(bristle, place):
    (place / "short.csv").write_text(
        "".join((place / "log.csv").read_text().splitlines(keepends=True)[:60])
    )
    (place / "axis.toml").write_text((place / "axis.toml").read_text().partition("[controller]")[0])
    ended = bristle(
        "identify",
        "log.csv",
        "short.csv",
        "--axis",
        "axis.toml",
        "--model",
        "viscous",
        "--draws",
        0,
        "--json",
        code=0,
    )
    assert "leaves out a log: short.csv" in ended.err


@pytest.mark.slow
def test_the_command_line_takes_several_logs(bristle, place):
    text = (place / "log.csv").read_text().splitlines()
    half = len(text) // 2
    (place / "second.csv").write_text("\n".join([text[0], *text[half:]]) + "\n")
    result = bristle(
        "identify",
        "log.csv",
        "second.csv",
        "--axis",
        "axis.toml",
        "--draws",
        0,
        "--out",
        "both",
        "--json",
        code=0,
    )
    assert result.data["further_logs"] == ["second.csv"]
    assert {"log", "log_2", "log_2_sha256", "axis"} <= set(result.data["provenance"])
    assert result.data["parameters"]["M"]["value"] == pytest.approx(20.0, rel=0.03)
    page = (place / "both" / "report.html").read_text()
    assert ", over time blocks" in page
    assert "Further logs" in page
    bristle(
        "identify",
        "log.csv",
        "--axis",
        "axis.toml",
        "--axis",
        "axis.toml",
        code=2,
        said="axis: 2 axis files for 1 log",
    )


def test_an_axis_file_sets_thresholds(bristle, place):
    axis = place / "axis.toml"
    log = place / "log.csv"
    log.write_text("\n".join(log.read_text().splitlines()[:3001]))
    axis.write_text(
        axis.read_text().partition("[controller]")[0]
        + "\n[identification.settings]\npoor_error = 0.0\ninseparable = 0.5\n"
    )
    requested = ("identify", "log.csv", "--axis", "axis.toml", "--model", "viscous", "--draws", "0")
    data = bristle(*requested, "--json").data
    assert (data["settings"]["poor_error"], data["settings"]["inseparable"]) == (0.0, 0.5)
    assert set(data["settings"]) == {threshold.name for threshold in Settings.described()}
    assert "unexplained" in [threshold["code"] for threshold in data["diagnostics"]]
    axis.write_text(axis.read_text() + "nothing = 1.0\n")
    bristle(*requested, code=2, said="identification.settings.nothing")


def test_an_identified_delay_is_printed_before_the_parameters(bristle, place):
    cells = [row.split(",") for row in Path("log.csv").read_text().splitlines()[:3001]]
    late = [cells[0], *([*cells[i][:3], cells[max(i - 4, 1)][3]] for i in range(1, len(cells)))]
    Path("late.csv").write_text("\n".join(",".join(item) for item in late))
    Path("bare.toml").write_text(Path("axis.toml").read_text().partition("[controller]")[0])
    message = bristle(
        "identify", "late.csv", "--axis", "bare.toml", "--model", "viscous", "--draws", 0
    ).out
    first, _, rest = message.partition("Parameters")
    assert re.search(
        r"bristle removed a delay of 3\.49 ms between effort and position", " ".join(first.split())
    )
    assert rest


def test_the_help_states_the_range_of_draws(bristle):
    assert "20 to 100000, or 0" in " ".join(bristle("identify", "--help").out.split()).replace(
        "│ ", ""
    )


def next_command(result):
    """The command that the last line names, as a person would type it."""
    text = " ".join(result.out.split())
    return shlex.split(text[text.index("bristle run") :])[1:]


@pytest.mark.slow
def test_the_printed_next_command_runs(bristle, place):
    result = bristle("identify", "log.csv", "--axis", "axis.toml", "--draws", "0", "--out", "run")
    command = next_command(result)
    assert command[:2] == ["run", str(Path("run/experiment.toml"))]
    ran = bristle(*command, "--json", code=0)
    errors = {name: item["following_error"]["rms"] for name, item in ran.data["variants"].items()}
    assert list(errors) == ["as_recorded", "feedforward", "compensated"]
    assert errors["compensated"] < 0.5 * errors["feedforward"] < 0.5 * errors["as_recorded"]
    text = json.loads(Path("run/summary.json").read_text())["compensation"]
    # The loop that identify simulated is the one that run simulates, and design.
    for name, item in ran.data["variants"].items():
        promised = text[name]["following_error"]["peak_to_peak"]
        assert item["following_error"]["peak_to_peak"] == pytest.approx(promised, rel=0.01)
    law = ["--law", "run/experiment.toml", "--variant", "compensated"]
    assert bristle("export", *law, "--to", "c", "--out", "law").code == 0


@pytest.mark.slow
def test_an_axis_without_a_controller_gets_two_gaps_for_gains(bristle, place):
    lines = Path("axis.toml").read_text().split("[controller]")[0].splitlines()
    Path("open.toml").write_text(
        "\n".join(line for line in lines if not line.startswith("reference"))
    )
    result = bristle(
        "identify",
        "log.csv",
        "--axis",
        "open.toml",
        "--draws",
        "0",
        "--out",
        "run",
        shown="Write controller.k_p and controller.k_v into the axis file",
    )
    command = next_command(result)
    bristle(*command, code=2, said="controller.k_p: is not filled in")
    file = Path("run/experiment.toml")
    filled = re.sub(r'"\?"( +# [^\n]*such as )("[^"]+")', r"\2\1\2", file.read_text())
    filled, hints = re.subn(r"(?m)^# (T_n|k_ff)", r"\1", filled)
    assert hints == 2
    file.write_text(filled)
    ran = bristle(*command, "--json", code=0)
    errors = {name: item["following_error"]["rms"] for name, item in ran.data["variants"].items()}
    assert errors["compensated"] < errors["as_recorded"]
    bristle(
        "identify",
        "log.csv",
        "--axis",
        "open.toml",
        "--draws",
        "0",
        "--out",
        "run",
        "--force",
        code=2,
    )


WITHOUT_LOOP = "interrupted: all models fitted; the loop was not simulated"
NOTHING = "no model is fitted yet, so bristle writes no results"


@pytest.mark.parametrize(
    ("owner", "name", "code", "said"),
    [
        ("bristle.files", "logs_and_axes", 130, NOTHING),
        ("bristle.report.identified", "identify", 130, NOTHING),
        pytest.param(
            "bristle.report.identified.Identified",
            "_in_the_loop",
            130,
            WITHOUT_LOOP,
            marks=pytest.mark.slow,
        ),
        ("bristle.report.next_motion", "next_motion", 0, ""),
        ("bristle.report.identified.Outcome", "following_experiment", 0, ""),
    ],
)
def test_an_interruption_keeps_what_is_done_in_any_phase(
    bristle, place, monkeypatch, owner, name, code, said
):
    written, interruptions = place / "results" / "summary.json", iter([KeyboardInterrupt])
    original = getattr(pkgutil.resolve_name(owner), name)

    def interrupted(*arguments, **options):
        for interruption in interruptions:
            raise interruption
        return original(*arguments, **options)

    monkeypatch.setattr(f"{owner}.{name}", interrupted)
    bristle(*WITH_DRAWS, "--out", "results", code=code, said=said)
    assert next(interruptions, None) is None
    assert (
        (json.loads(written.read_text())["unfinished"] or "") == said
        if written.exists()
        else said == NOTHING
    )


def test_a_second_interruption_ends_at_once(bristle, place, monkeypatch):
    identified, interrupting = of_report.identify, Mock(side_effect=KeyboardInterrupt)
    monkeypatch.setattr(
        of_report,
        "identify",
        lambda *logs, **options: replace(
            identified(*logs, **options), unfinished="interrupted: once"
        ),
    )
    monkeypatch.setattr("bristle.report.identified.Identified.outcome_with", interrupting)
    bristle(*IDENTIFY, "--draws", "0", "--out", "results", code=130)
    assert (interrupting.call_count, (place / "results").exists()) == (1, False)


@pytest.mark.slow
def test_a_signal_during_the_fits_leaves_the_finished_models(place):
    main = "import sys; from bristle.cli.main import main; sys.exit(main())"
    command = [
        sys.executable,
        "-c",
        main,
        "identify",
        "log.csv",
        "--axis",
        "axis.toml",
        "--model",
        "all",
        "--out",
        "results",
    ]
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    ) as process:
        next(line for line in process.stderr if line.startswith("Verdict"))
        process.terminate()
        said = process.stderr.read()
    assert process.returncode == 143
    assert re.search(r"interrupted: [1-9]\d* of 1\d models fitted", said)
    assert json.loads((place / "results" / "summary.json").read_text())["unfinished"] in said
