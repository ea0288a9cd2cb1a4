"""Commands in short: what each prints, writes and returns."""

import json
import math
import re
import shutil
from functools import partial
from pathlib import Path
from unittest.mock import ANY

import numpy as np
import pytest
from tests.cli.conftest import written_in
from tests.prediction.comparison.machine import log, sine
from tests.report.pages import Page

import bristle as br
from bristle.cli import models
from bristle.files import provenance, read_axis
from bristle.logs import read_log
from bristle.report import excitation as report
from bristle.report.sentences import SENTENCES

# --- ``bristle models``: what there is -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        *br.friction.MODELS,
        "lugre+asymmetry",
        "cascade",
        "inertia",
        "encoder",
        "sine",
        "recorded",
        *br.hysteresis.OPERATORS,
    ],
)
def test_a_model_is_shown_by_name(bristle, name):
    shown = bristle("models", name, code=0)
    (item,) = bristle("models", name, "--json").data["models"]
    assert item["name"] == name
    assert all(parameter in shown.out for parameter in item["parameters"])


def test_without_a_name_all_are_shown(bristle):
    shown = bristle("models").out
    assert all(name in shown for name in (*br.friction.MODELS, "cascade", "+asymmetry"))


def test_a_share_has_both_ends_of_its_range(bristle):
    row = next(
        line
        for line in bristle("models", "preisach").out.splitlines()
        if line.split()[:1] == ["tolerance"]
    )
    assert "0 to 1" in row


# --- one and all of them, as they are printed ------------------------------------------------------------------------


@pytest.fixture
def printed(monkeypatch):
    """Paragraphs and tables in their order."""
    parts = []
    for name in ("say", "show_table"):
        monkeypatch.setattr(models, name, parts.append)
    monkeypatch.setattr(models, "say_laid_out", lambda lay_out: parts.append(lay_out(80)))
    return parts


def test_equations_come_first_and_then_parameters_conditions_and_source(printed):
    component = br.friction.find("stribeck")
    models._show_one(component)
    equations, table, *rest = printed
    assert equations == component.laid_out(80)
    assert table.caption == f"{component.name}: {component.description}"
    assert list(table.heads) == [
        "Parameter",
        "Meaning",
        "Unit",
        "Unit, rotational",
        "Allowed",
        "Default",
    ]
    rows = {row[0]: row for row in table.rows}
    assert list(rows) == list(component.variables)
    assert list(rows["F_C"][2:4]) == ["N", "N·m"]
    assert list(rows["v_S"][1:4]) == [component.variables["v_S"].description, "m/s", "rad/s"]
    assert (rows["F_C"][5], rows["delta_S"][5]) == ("", "2")
    assert rest == [
        *(
            f"{'Should have' if relation.advisory else 'Needs'} {relation.condition}."
            for relation in component.relations
        ),
        *([f"Source: {component.reference}"] if component.reference else []),
    ]
    assert any(part.startswith("Needs ") for part in rest)


# --- ``bristle explain``: the meaning of each code -------------------------------------------------------------------


@pytest.mark.parametrize("code", ["one_direction", "structure", "delay_found"])
def test_a_code_has_its_meaning_and_advice(bristle, code):
    ended = bristle("explain", code)
    text = " ".join(ended.out.split()).lower()
    assert ended.code == 0
    assert SENTENCES[code].means.lower() in text
    advice = SENTENCES[code].advice.lower()
    assert ("no action needed" if advice == "nothing" else advice) in text


def test_all_codes_are_listed_and_the_json_has_the_names_of_numbers(bristle):
    listed = bristle("explain").out
    assert all(code in listed for code in SENTENCES)
    data = bristle("explain", "one_direction", "--json").data
    assert data["codes"]["one_direction"]["numbers"] == ["direction", "percent", "names"]


FORMER_CODES = """
begins_at_rest:start_of_contact clock_suspect:unit_suspect creeps:rests effort_worse_than_none:worse_than_none fast_reversals:few_reversals
filtered_rows:filtered intervals_loop:intervals logs_repeat:motion_repeats missing_load:terms_beside missing_temperature:terms_beside
no_bend:few_strokes no_interval:few_cycles no_presliding:missing_presliding no_reversal:few_reversals no_steady_slide:no_fall
noisy_position:coarse_position position_worse_than_none:worse_than_none rates_differ:resampled repeats_one_motion:motion_repeats
rests_left_out:rests run_in:start_of_contact seen_together:small_effect slow_sampling:filtered stamps_jitter:resampled unseen:small_effect
"""


@pytest.mark.parametrize("pair", FORMER_CODES.split())
def test_a_code_of_the_last_release_is_refused_with_its_successor(bristle, pair):
    code, successor = pair.split(":")
    ended = bristle(
        "explain", code, code=2, said=f"is not the code of a warning or note; found {code!r}"
    )
    assert re.search(
        rf"Run bristle explain {successor}$|Did you mean '{successor}'\?", ended.err.strip()
    )


# --- ``bristle excite``: from an axis file to a motion, and to what its log would tell -------------------------------


STAGE = """
schema = 1
name = "stage"
kind = "translational"

[columns]
time = { column = "t", unit = "s" }
position = { column = "q", unit = "um" }
effort = { column = "u", unit = "N" }

[effort]
limit = "700 N"

[plant]
mass = "28 kg"
presliding = "7 um"

[encoder]
resolution = "0.05 um"

[timing]
sample_time = "2 ms"

[limits]
velocity = "100 mm/s"
acceleration = "2 m/s^2"
stroke = ["-50 mm", "50 mm"]
"""


@pytest.fixture
def stage(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("axis.toml").write_text(STAGE)
    return tmp_path


@pytest.fixture
def stage_undrawn(stage, undrawn):
    return stage


@pytest.mark.slow
def test_a_motion_is_written_with_the_intervals_that_its_log_would_give(bristle, stage):
    result = bristle(
        "excite",
        "axis.toml",
        "--out",
        "motion",
        "--duration",
        "16 s",
        "--for",
        "stribeck",
        "--json",
        code=0,
    )
    assert written_in(stage / "motion") == {
        "motion.csv",
        "moves.csv",
        "motion.nc",
        "axis.toml",
        "summary.json",
        "report.html",
    }
    table = np.loadtxt("motion/motion.csv", delimiter=",", skiprows=1)
    assert (
        Path("motion/motion.csv")
        .read_text()
        .splitlines()[0]
        .startswith("t [s],q [um],velocity [um/s],")
    )
    assert np.abs(table[:, 1]).max() <= 50_000.0
    assert table[-1, 0] == pytest.approx(result.data["motion"]["duration"], abs=0.003)
    assert result.data["parameters"]["F_C"]["status"] == "identified"
    assert abs(result.data["parameters"]["F_C"]["error_percent"]) < 10.0
    assert result.data["identify"].split()[:4] == ["bristle", "identify", "LOG", "--axis"]
    assert [item["purpose"] for item in result.data["pieces"]] == ["stribeck"] * 10
    bristle(
        "excite",
        "axis.toml",
        "--out",
        "motion",
        "--duration",
        "16 s",
        "--for",
        "stribeck",
        code=2,
        said="--force",
    )
    bristle(
        "excite",
        "axis.toml",
        "--out",
        "motion",
        "--duration",
        "16 s",
        "--for",
        "stribeck",
        "--force",
        "--format",
        "svg",
        code=0,
        shown=("constant velocity", "Verdict: Run it"),
    )
    assert {item.name for item in Path("motion/figures").glob("*.svg")} == {
        "motion.svg",
        "expected.svg",
    }


@pytest.fixture
def stage_log(stage_undrawn):
    """A log of the axis: a swing with the inertia of its mass and with Coulomb friction of 50 N."""
    time = 2e-3 * np.arange(2000)
    phase = 2.0 * np.pi * time
    effort = -28.0 * 0.02 * (2.0 * np.pi) ** 2 * np.sin(phase) + 50.0 * np.tanh(
        200.0 * np.cos(phase)
    )
    columns = np.column_stack([time, 1e6 * 0.02 * np.sin(phase), effort])
    np.savetxt("log.csv", columns, delimiter=",", header="t,q,u", comments="")
    return stage_undrawn / "log.csv"


@pytest.mark.slow
def test_a_log_gives_the_friction_of_the_rehearsal(bristle, stage_log, monkeypatch):
    monkeypatch.setattr(report, "excite", partial(report.excite, draws=0))
    measured = bristle(
        "excite",
        "axis.toml",
        "--log",
        "log.csv",
        "--duration",
        "10 s",
        "--for",
        "stribeck",
        "--json",
        code=0,
    )
    assert measured.data["assumed"] == []
    assert measured.data["model"] == "dahl"
    assert measured.data["parameters"]["F_C"]["put_in"] == pytest.approx(50.0, rel=0.1)
    assert measured.data["provenance"]["log"] == "log.csv"


# --- ``bristle design``: margins, budget and gains from an experiment file -------------------------------------------


@pytest.mark.usefixtures("undrawn")
def test_results_are_a_report_and_numbers(bristle, place):
    bristle(
        "design",
        "experiment.toml",
        "--variant",
        "none",
        "--bandwidth",
        "10 Hz",
        "--out",
        "design",
        code=0,
        shown=("Poles and margins of the sampled loop", "none: the sampled loop is stable"),
    )
    assert written_in("design") == {"summary.json", "report.html"}
    assert json.loads(Path("design/summary.json").read_text())["variant"] == "none"
    proposed = json.loads(Path("design/summary.json").read_text())["proposals"]["tuned"]
    assert proposed["bandwidth"] == pytest.approx(20.0 * math.pi)
    assert proposed["parameters"]["k_p"] == pytest.approx(5.0 * math.pi)
    page = Path("design/report.html").read_text()
    for name in ("margins", "circles"):
        assert f'<figure id="figure-{name}">' in page


@pytest.mark.usefixtures("undrawn")
@pytest.mark.slow
def test_an_unstable_loop_exits_with_1_its_pole_and_stable_gains(bristle, place):
    text = Path("experiment.toml").read_text()
    Path("experiment.toml").write_text(text.replace("[run]", "[run]\ndelay = 12"))
    ended = bristle("design", "experiment.toml", "--json", "--out", "design", code=1)
    assert ended.data["stable"] is False
    assert "the sampled loop has a pole at" in ended.data["loops"]["base"]["sentence"]
    assert "samples of delay" in ended.data["loops"]["base"]["sentence"]
    assert ended.data["budget"] is None
    assert ended.data["proposals"]["tuned"]["following_error"]["peak_to_peak"] > 0.0
    assert (Path("design") / "report.html").is_file()


# --- ``bristle compare``: before and after ---------------------------------------------------------------------------


QUIET = ("compare", "before.csv", "after.csv", "--axis", "axis.toml")


def write(name, recorded, columns=("time", "position", "reference", "effort")):
    signals = np.column_stack([getattr(recorded, column).values for column in columns])
    heads = {"time": "t", "position": "q", "reference": "r", "effort": "u"}
    np.savetxt(
        name,
        signals,
        delimiter=",",
        header=",".join(heads[column] for column in columns),
        comments="",
        fmt="%.9g",
    )


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Logs from before a change and after it."""
    folder = tmp_path_factory.mktemp("recorded")
    write(folder / "before.csv", log(1, sine(9)))
    write(folder / "after.csv", log(2, sine(9), gain=0.7, friction=7.0))
    return folder


@pytest.fixture
def logs(place, recorded):
    axis = Path("axis.toml").read_text()
    Path("axis.toml").write_text(axis.replace('"100 Hz"', '"25 Hz"').replace('"0.1 um"', '"1 nm"'))
    shutil.copytree(recorded, place, dirs_exist_ok=True)
    return place


def test_the_answer_is_printed_first_and_yes_exits_with_0(bristle, logs):
    result = bristle(
        *QUIET, code=0, shown=("Friction level", "bristle compared 8 cycles before and 8 after")
    )
    assert result.out.startswith("It helped: the following error is lower.")


def test_no_help_is_the_exit_code_of_no(bristle, logs):
    write("again.csv", log(3, sine(9)))
    bristle(
        "compare", "before.csv", "again.csv", "--axis", "axis.toml", code=1, shown="do not show"
    )


def test_results_in_a_folder(bristle, logs, undrawn):
    bristle(*QUIET, "--out", "compared", code=0)
    assert written_in("compared") == {"summary.json", "report.html"}
    page = Path("compared/report.html").read_text()
    assert "bristle compare before.csv after.csv --axis axis.toml" in page
    assert "bench: before and after" in page


def test_further_logs_of_a_side(bristle, logs):
    write("more.csv", log(5, sine(5)))
    result = bristle(*QUIET, "--before", "more.csv", "--json")
    assert [item["name"] for item in result.data["logs"]["before"]] == ["before.csv", "more.csv"]
    assert result.data["shared"]["cycles_before"] == 12
    assert result.data["provenance"]["before_2"] == "more.csv"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("compare", "before.csv"), "AFTER"),
        (
            ("compare", "before.csv", "gone.csv", "--axis", "axis.toml"),
            "gone.csv: there is no such file",
        ),
        (
            ("compare", "before.csv", "before.csv", "--axis", "axis.toml"),
            "is also the log from before the change",
        ),
        ((*QUIET, "--axis", "axis.toml", "--axis", "axis.toml"), "3 axis files for 2 logs"),
        ((*QUIET, "--format", "png"), "--out"),
        (
            ("compare", "before.csv", "gap.csv", "--axis", "axis.toml"),
            "gap.csv: column 'u': has NaN",
        ),
    ],
)
def test_incomparable_logs_are_refused_in_one_line(bristle, logs, arguments, words):
    lines = Path("after.csv").read_text().splitlines()
    lines[100] = lines[100].rpartition(",")[0] + ",nan"
    Path("gap.csv").write_text("\n".join(lines))
    result = bristle(*arguments, code=2, said=words)
    assert len(result.err.splitlines()) == 1


# --- ``bristle predict``: errors of a prediction, and what each mode needs -------------------------------------------


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("mode", "effort", "position"),
    [("inverse", 5.0, None), ("closed-loop", 5.0, 0.1), ("open-loop", None, 50.0)],
)
def test_each_mode_names_its_prediction(bristle, place, mode, effort, position):
    result = bristle(
        "predict", "model.toml", "log.csv", "--axis", "axis.toml", "--mode", mode, "--json", code=0
    )
    metrics = result.data["metrics"]
    assert set(metrics) == {
        "force_error_percent",
        "force_rmse",
        "force_unit",
        "position_error_percent",
        "position_rmse",
        "position_unit",
    }
    for key, limit in (("force_error_percent", effort), ("position_error_percent", position)):
        assert (metrics[key] is None) == (limit is None)
        assert limit is None or 0.0 < metrics[key] < limit
    assert metrics["position_unit"] == "m"


@pytest.mark.usefixtures("undrawn")
def test_a_wrong_model_predicts_worse(bristle, place):
    right = bristle("predict", "model.toml", "log.csv", "--axis", "axis.toml", "--json").data
    Path("model.toml").write_text(Path("model.toml").read_text().replace("F_C = 8.0", "F_C = 4.0"))
    wrong = bristle("predict", "model.toml", "log.csv", "--axis", "axis.toml", "--json").data
    assert wrong["metrics"]["force_error_percent"] > 2.0 * right["metrics"]["force_error_percent"]


@pytest.mark.usefixtures("undrawn")
def test_results_and_words(bristle, place):
    result = bristle(
        "predict",
        "model.toml",
        "log.csv",
        "--axis",
        "axis.toml",
        "--mode",
        "closed-loop",
        "--out",
        "run",
        code=0,
        shown="Effort error",
    )
    assert result.out.startswith("The model is valid")
    assert written_in("run") == {"summary.json", "report.html"}
    assert json.loads(Path("run/summary.json").read_text())["mode"] == "closed-loop"


@pytest.mark.usefixtures("undrawn")
def test_a_diverging_loop_exits_with_1(bristle, place):
    axis = Path("axis.toml")
    axis.write_text(
        axis.read_text().replace('"4 N*s/mm"', '"400 N*s/mm"').replace('limit = "300 N"', "")
    )
    ended = bristle(
        "predict",
        "model.toml",
        "log.csv",
        "--axis",
        "axis.toml",
        "--mode",
        "closed-loop",
        "--json",
        code=1,
    )
    assert ended.data["completed"] is False
    assert ended.data["metrics"]["force_error_percent"] is None


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_prediction_of_the_fitted_log_itself_causes_a_note(bristle, place):
    table = np.loadtxt("log.csv", delimiter=",", skiprows=1)
    np.savetxt(
        "both.csv",
        np.hstack([table, table[:, 1:]]),
        delimiter=",",
        header="t,q,r,u,q_b,r_b,u_b",
        comments="",
    )
    Path("other.toml").write_text(
        re.sub('column = "([qru])"', r'column = "\1_b"', Path("axis.toml").read_text())
    )
    entries = provenance("bristle identify", log=read_log("both.csv", read_axis("axis.toml")))
    lines = [f"{name} = {json.dumps(value)}" for name, value in entries.items()]
    Path("model.toml").write_text(
        "\n".join([Path("model.toml").read_text(), "[provenance]", *lines])
    )
    message = {}
    for name in ("axis.toml", "other.toml"):
        result = bristle("predict", "model.toml", "both.csv", "--axis", name, "--json")
        message[name] = "fitted to this log" in " ".join(result.data["verdict"]["reasons"])
    assert message == {"axis.toml": True, "other.toml": False}


# --- ``bristle paper``: figures of the source paper, their experiments, the report -----------------------------------


@pytest.mark.usefixtures("here")
def test_one_figure_with_its_report(bristle):
    bristle(
        "paper", "--figure", "4", "--out", "results", code=0, shown=("found in part", "factor 2")
    )
    assert written_in("results") == {"report.html", "summary.json"}
    page = Page(Path("results/report.html").read_text(encoding="utf-8"))
    assert [item["id"] for item in page.named("figure")] == ["fig-4"]
    summary = json.loads(Path("results/summary.json").read_text())
    assert summary["provenance"]["fig_04"] == "fig_04.toml"
    assert summary["provenance"]["command"] == "bristle paper --figure 4 --out results"


@pytest.mark.slow
@pytest.mark.usefixtures("here")
def test_results_go_to_their_usual_place_and_named_results_are_kept_without_force(bristle):
    for _ in range(2):  # the second time it replaces what it wrote unasked
        assert list(bristle("paper", "--figure", "4", "--json").data["figures"]) == ["4"]
    assert Path("bristle-paper/report.html").is_file()
    Path("bristle-paper").rename("results")
    bristle("paper", "--figure", "4", "--out", "results", code=2, said="--force")


@pytest.mark.slow
@pytest.mark.usefixtures("here")
def test_experiments_are_written_changed_and_run(bristle):
    assert bristle("paper", "--write", "mine").code == 0
    path = Path("mine/fig_09.toml")
    path.write_text(
        path.read_text().replace(
            'file = "set_a_rig.toml"\n\n', 'file = "set_a_rig.toml"\nscatter = 0.2\n\n'
        )
    )
    as_it_is = bristle("paper", "--figure", "9", "--json").data["figures"]["9"]["numbers"]
    changed = bristle("paper", "--figure", "9", "--from", "mine", "--json").data["figures"]["9"][
        "numbers"
    ]
    before, after = (item["missing_at_return"]["virtual rig"]["B"] for item in (as_it_is, changed))
    assert abs(after) > 2.0 * abs(before)
    assert bristle("paper", "--write", "mine").code == 2
    bristle("paper", "--write", "mine", "--force", code=2, said="were changed: fig_09.toml")
    assert bristle("paper", "--write", "theirs", "--json").data["written"]
    assert bristle("paper", "--write", "theirs", "--force", "--json").data["written"]


# --- ``bristle run``: variants side by side --------------------------------------------------------------------------


@pytest.mark.usefixtures("undrawn")
def test_variants_are_printed_and_written(bristle, place):
    bristle("run", "experiment.toml", "--out", "run", code=0, shown=("base", "none"))
    assert written_in("run") == {"summary.json", "report.html"}
    assert list(json.loads(Path("run/summary.json").read_text())["variants"]) == ["base", "none"]


@pytest.mark.usefixtures("undrawn")
def test_bad_settings_of_matplotlib_end_a_command_before_its_work(bristle, place, monkeypatch):
    def refused(name):
        raise br.core.InputError(
            "cannot be imported with the settings of this machine", path="matplotlib"
        )

    monkeypatch.setattr("bristle.cli.options.import_module", refused)
    monkeypatch.setattr("bristle.simulation.simulate", lambda *_: pytest.fail("simulated first"))
    bristle(
        "run",
        "experiment.toml",
        "--out",
        "run",
        code=2,
        said="cannot be imported with the settings of this machine",
    )
    assert not Path("run").exists()


@pytest.mark.usefixtures("undrawn")
def test_a_diverging_loop_exits_with_1_and_prints_no_nan(bristle, place):
    text = Path("experiment.toml").read_text()
    Path("experiment.toml").write_text(
        text.replace('"4 N*s/mm"', '"400 N*s/mm"').replace('limit = "300 N"', "")
    )
    ended = bristle(
        "run",
        "experiment.toml",
        "--json",
        "--out",
        "run",
        code=1,
        said=("base, none: unstable", "the sampled loop has a pole at"),
    )
    assert ended.data["variants"]["base"]["completed"] is False
    assert ended.data["variants"]["none"] == {"status": ANY, "completed": False, "runs": 0}
    assert "the sampled loop has a pole at" in (Path("run") / "report.html").read_text()


@pytest.mark.usefixtures("undrawn")
def test_stable_variants_are_simulated_nevertheless(bristle, place):
    text = Path("experiment.toml").read_text()
    slow = "[compare.base]\n\n[compare.slow.run]\ndelay = 9\n\n"
    Path("experiment.toml").write_text(text.partition("[compare")[0] + slow)
    ended = bristle("run", "experiment.toml", "--json", code=1, said="slow: unstable")
    assert ended.data["variants"]["base"]["completed"] is True
    assert "nine samples of delay" in ended.data["variants"]["slow"]["status"]
    message = ended.data["diagnostics"][-1]
    assert (message["code"], message["severity"], message["numbers"]["variants"]) == (
        "loop_diverges",
        "error",
        ["slow"],
    )
    assert ended.data["variants"]["slow"]["status"] == message["message"]


@pytest.mark.usefixtures("undrawn")
def test_a_small_margin_causes_a_warning(bristle, place):
    text = Path("experiment.toml").read_text()
    Path("experiment.toml").write_text(text.replace("[run]", "[run]\ndelay = 3"))
    ended = bristle(
        "run",
        "experiment.toml",
        "--json",
        "--out",
        "run",
        code=0,
        said="base, none: warning: the phase margin is",
    )
    assert "the phase margin is" in ended.data["warnings"][0]
    message = ended.data["diagnostics"][0]
    assert (message["code"], message["severity"]) == ("small_margin", "warning")
    assert message["numbers"]["variants"] == ["base", "none"]
    assert ended.data["warnings"][0] == f"base, none: warning: {message['message']}"
    assert 0.0 < message["numbers"]["phase"] < message["numbers"]["enough"]
    assert "the phase margin is" in (Path("run") / "report.html").read_text()


@pytest.mark.usefixtures("undrawn")
def test_a_user_model_runs_from_its_file(bristle, place):
    text = Path("experiment.toml").read_text()
    text = text.replace(
        'model = "coulomb_viscous"\nF_C = "8 N"\nF_v = "40 N*s/m"', 'file = "own.py"\nF_0 = "8 N"'
    )
    Path("experiment.toml").write_text(text)
    bristle(
        "run",
        "experiment.toml",
        "--json",
        code=2,
        said=("needs permission to run: own.py (SHA-256 ", "--allow-code"),
    )
    result = bristle("run", "experiment.toml", "--allow-code", "--json", code=0)
    assert result.data["variants"]["none"]["completed"] is True
    assert result.data["provenance"]["code"] == "own.py"
    assert result.err.startswith("bristle: warning: friction.file: the code in own.py (SHA-256 ")
    assert bristle("run", "experiment.toml").code == 2  # asked for once, allowed once


@pytest.mark.usefixtures("undrawn")
def test_the_log_of_each_variant_is_written(bristle, place):
    result = bristle("run", "experiment.toml", "--log", "--out", "run", "--json")
    assert result.data["files"] == {"base": "log_base.csv", "none": "log_none.csv"}
    log = br.read_log("run/log_base.csv")
    assert (log.effort.unit, log.position.unit) == ("N", "m")
    settled = np.abs(log.effort.values[log.time.values >= 2.0])
    assert np.max(settled) == pytest.approx(result.data["variants"]["base"]["effort"]["peak"])
    # A folder with logs is one of results: it can be replaced.
    assert bristle("run", "experiment.toml", "--out", "run", "--force").code == 0
    assert not Path("run/log_base.csv").exists()


@pytest.mark.usefixtures("undrawn")
def test_a_log_in_the_columns_of_the_axis_is_read_with_it_and_a_motion_is_followed(bristle, place):
    (place / "motion.csv").write_text(
        "t [s],r [m]\n" + "".join(f"{1e-3 * k},{2e-2 * np.sin(6e-3 * k)}\n" for k in range(1000))
    )
    text = Path("experiment.toml").read_text().partition("[compare")[0]
    rest = text.partition("[reference]")
    follow = '[reference]\nmodel = "recorded"\nfile = "motion.csv"\n'
    Path("follow.toml").write_text(f'{rest[0]}[axis]\nfile = "axis.toml"\n{follow}')
    result = bristle("run", "follow.toml", "--log", "--out", "run", "--json", code=0)
    assert result.data["files"] == {"base": "log.csv"}
    log = br.read_log("run/log.csv", br.read_axis("axis.toml"))
    assert log.reference.values == pytest.approx(2e-2 * np.sin(6e-3 * np.arange(1000)), abs=1e-12)
    assert log.position.values == pytest.approx(log.reference.values, abs=2e-3)
    assert log.effort.column == "u"


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("command", ["run", "design"])
def test_an_experiment_on_a_contact_is_refused_with_its_command(bristle, tmp_path, command):
    assert bristle("paper", "--write", tmp_path / "my copy").code == 0
    ended = bristle(
        command, tmp_path / "my copy/fig_03.toml", code=2, said="is an experiment on a contact"
    )
    assert ended.err.count("\n") == 1
    assert f"bristle paper --from '{tmp_path / 'my copy'}' --figure 3\n" in ended.err


@pytest.mark.usefixtures("undrawn")
def test_an_experiment_on_a_contact_is_recognized_by_its_tables(bristle, place):
    Path("mine.toml").write_text(
        'schema = 1\n[contact.a]\nmodel = "dahl"\n[path]\nturns = ["1 um"]\n'
    )
    assert "bristle paper --from . --figure N" in bristle("run", "mine.toml").err
    text = Path("experiment.toml").read_text()
    Path("fig_01.toml").write_text(text)
    assert bristle("run", "fig_01.toml").code == 0
    # A loop with a table that it has not is one that was mistyped.
    Path("experiment.toml").write_text(text + '\n[path]\nturns = ["1 um"]\n')
    assert "path: unknown key" in bristle("run", "experiment.toml").err


@pytest.mark.usefixtures("undrawn")
def test_the_best_variant_is_named_last(bristle, place):
    text = (
        Path("experiment.toml")
        .read_text()
        .replace("[compare.none.", "[compare.base]\n\n[compare.none.")
    )
    Path("experiment.toml").write_text(
        f"{text}\n[compare.half.controller.feedforward]\ngain = 0.5\n"
    )
    result = bristle("run", "experiment.toml")
    words = " ".join(result.out.split())
    assert "No variant is better than base: " in words
    fed = 'friction = { model = "coulomb_viscous", F_C = "8 N", F_v = "40 N*s/m" }'
    text = text.replace(fed, "", 1).replace('friction = "none"', fed)
    for velocity, less in (("", "hardly less."), ("\nk_ff = 1", "% less.")):
        # With the lag of the position loop gone, most of the error is friction.
        Path("experiment.toml").write_text(
            text.replace('k_p = "80 1/s"', f'k_p = "80 1/s"{velocity}')
        )
        words = " ".join(bristle("run", "experiment.toml").out.split()).replace("\u00a0", " ")
        assert "The best variant is none: " in words
        assert less in words


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_compensator_identified_on_another_rig_is_reported(bristle, tmp_path):
    assert bristle("paper", "--write", tmp_path / "mine").code == 0
    rig, short = tmp_path / "mine" / "set_a_rig.toml", tmp_path / "mine" / "short.toml"
    rig.write_text(
        rig.read_text(encoding="utf-8").replace("scatter = 0.05", "scatter = 0.08"),
        encoding="utf-8",
    )
    text = (tmp_path / "mine" / "set_c.toml").read_text(encoding="utf-8")
    brief = text.replace("seeds = 6", "seeds = 1").replace('duration = "28 s"', 'duration = "3 s"')
    short.write_text(brief, encoding="utf-8")
    message = " ".join(bristle("run", short).err.split())
    assert (
        "identified: the friction model of its compensator was identified on a different friction"
        in message
    )
    assert "observer: the friction model of its compensator" not in message
