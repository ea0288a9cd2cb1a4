"""``bristle check``: certificates of a model file, the contract suite for a model of a user's own, what a log can determine."""

import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from markupsafe import Markup
from tests.golden.yard import COMPOSITE, LUGRE

import bristle as br
from bristle.core.content import NOWHERE
from bristle.identification import Determined
from bristle.report.page import Picture

EXAMPLE = Path(__file__).parents[2] / "examples" / "quadratic_drag.py"
KEYS = {"applies", "value", "unit", "threshold", "passed", "advice"}


@pytest.fixture
def models(tmp_path, monkeypatch):
    """A folder with a model that drifts and one that does not."""
    monkeypatch.chdir(tmp_path)
    Path("lugre.toml").write_text(LUGRE)
    Path("composite.toml").write_text(COMPOSITE)
    return tmp_path


def test_a_move_is_asked_of_a_machine_only(bristle, tmp_path):
    shown = bristle("check", str(EXAMPLE), "--move", code=2)
    assert "--move: applies only to a machine" in shown.err


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_model_that_drifts_fails_with_advice(bristle, models):
    shown = bristle("check", "lugre.toml", code=1, shown="30 mN·m·s/rad")
    assert all(f"{name}: " in shown.err for name in ("passive", "drift", "closure"))
    assert shown.out.count("FAILED") == 3


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_deflection_without_bound_is_an_answer_not_bad_input(bristle, models):
    Path("short.toml").write_text(COMPOSITE.replace("156 mN*m", "120 mN*m"))
    result = bristle("check", "short.toml", "--json", code=1)
    answer = result.data["certificates"]["well_posed"]
    assert answer["passed"] is False
    assert "raise f_p to at least 136.5 mN·m" in answer["advice"]


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_broken_condition_without_a_certificate_is_bad_input(bristle, models):
    Path("reversed.toml").write_text(
        COMPOSITE.replace("100 mN*m", "140 mN*m").replace("156", "190")
    )
    bristle("check", "reversed.toml", code=2, said="F_S >= F_C")


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_ripple_and_loop_are_taken_with_their_units(bristle, models):
    options = ("--force-ripple", "40 mN*m,80 mN*m", "--loop", "3.77 mrad, 1.885 mrad")
    result = bristle("check", "lugre.toml", "--json", *options).data["certificates"]
    # 0.3895 um on a screw of 5 mm lead, and 30.7 % of break-away.
    assert result["drift"]["value"] == pytest.approx(0.38947 * 1.256637e-3, rel=1e-4)
    assert result["closure"]["value"] == pytest.approx(-0.307, abs=1e-3)


@pytest.mark.usefixtures("undrawn")
def test_a_sound_model_of_a_users_own_passes(bristle, place):
    result = bristle("check", "own.py", "--json", code=0)
    assert result.data["passed"] is True
    assert all(item["passed"] for item in result.data["certificates"].values())
    measured = {
        name: item
        for name, item in result.data["certificates"].items()
        if item["value"] is not None
    }
    assert {
        "finite everywhere",
        "one sided limits",
        "dissipates",
        "refines",
        "same bits compiled",
    } <= set(measured)
    assert all(item["unit"] for item in measured.values())
    assert measured["dissipates"]["value"] > measured["dissipates"]["threshold"]
    assert measured["refines"]["value"] <= measured["refines"]["threshold"]
    assert result.data["certificates"]["rate agrees"]["applies"] is False  # it has no rate
    assert all(set(item) >= KEYS for item in result.data["certificates"].values())


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_model_that_pushes_fails_with_advice(bristle, place):
    Path("own.py").write_text(
        Path("own.py").read_text().replace("return p.F_0 *", "return -p.F_0 *")
    )
    result = bristle("check", "own.py", "--json", code=1)
    failed = {name for name, item in result.data["certificates"].items() if not item["passed"]}
    assert "dissipates" in failed
    assert all(name in result.err for name in failed)
    worst = result.data["certificates"]["dissipates"]
    assert worst["value"] < worst["threshold"] < 0.0
    bristle("check", "own.py", code=1, shown="NOT MET")


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_a_model_file_of_a_users_own_model_has_its_certificates(bristle, place):
    Path("mine.toml").write_text('schema = 1\n[friction]\nfile = "own.py"\nF_0 = "3 N"\n')
    assert bristle("check", "mine.toml", "--json").code == 2
    assert bristle("check", "own.py").code == 0  # which allows its code
    result = bristle("check", "mine.toml", "--json", code=0)
    verdicts = {name: item["passed"] for name, item in result.data["certificates"].items()}
    assert verdicts == {
        "well_posed": None,
        "passive": None,
        "drift": True,
        "closure": None,
        "dissipation": True,
    }


@pytest.mark.usefixtures("undrawn")
def test_a_model_file_is_checked_with_its_values(bristle, place):
    assert bristle("check", "model.toml").code == 0


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    "command", [("check",), ("identify", "log.csv", "--axis", "axis.toml", "--model")]
)
@pytest.mark.parametrize(
    ("old", "new", "line", "place_of", "said"),
    [
        (
            '"force"',
            '"forse*time"',
            9,
            "quantity of 'force against the motion'",
            "Did you mean 'force'?",
        ),
        ('"force"', '"N"', 9, "quantity of 'force against the motion'", "not its unit"),
        (
            "directional=True",
            'excitation="slide"',
            9,
            "excitation of 'force against the motion'",
            "'sliding'?",
        ),
        (
            '"""None."""',
            'z: Annotated[float, Variable("depth", "depth")] = 0.0',
            13,
            "quantity of 'depth'",
            "'depth' is unknown",
        ),
    ],
)
def test_an_unknown_quantity_is_bad_input_with_its_line(
    bristle, place, command, old, new, line, place_of, said
):
    text = Path("own.py").read_text().replace(old, new, 1)
    # Annotations that are evaluated late have no line.
    for custom, where in (
        (text, f"own.py, line {line}"),
        (f"from __future__ import annotations\n{text}", "own.py"),
    ):
        Path("own.py").write_text(custom)
        result = bristle(*command, "own.py", said=(said, "allowed"))
        assert (result.code, result.out) == (2, "")
        assert result.err.startswith(f"bristle: {where}: {place_of}: is no")


@pytest.mark.usefixtures("undrawn")
@pytest.mark.slow
def test_a_product_of_quantities_is_described_checked_and_identified(bristle, place):
    for header in ("", "from __future__ import annotations\n"):
        custom = header + EXAMPLE.read_text()
        Path("drag.py").write_text(custom)
        assert bristle("check", "drag.py").code == 0
    result = bristle(
        "identify", "log.csv", "--axis", "axis.toml", "--model", "drag.py", "--json", code=0
    )
    assert result.data["parameters"]["F_q"]["unit"] == "N*s^2/m^2"


# --- ``bristle check RESULTS``: what a log can and cannot determine, from simulated logs of known truth --------------


REFERENCE = Path(__file__).parents[2] / "docs/reference/json.md"
AXIS = """schema = 1
kind = "translational"
columns.time = { column = "time", unit = "s" }
columns.position = { column = "position", unit = "m" }
columns.effort = { column = "force", unit = "N" }
[encoder]
resolution = "1 um"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A log with the results of its identification beside it, and results without simulated logs."""
    results = tmp_path_factory.mktemp("axis")
    time = 1e-3 * np.arange(3000)
    position = 4e-3 * np.sin(6.9 * time) * (1.0 + 0.6 * np.sin(1.95 * time))
    effort = 3.0 * np.gradient(np.gradient(position, time), time) + 8.0 * np.sign(
        np.gradient(position, time)
    )
    effort += 0.03 * np.random.default_rng(1).standard_normal(time.size)
    table = np.column_stack([time, np.round(position, 6), effort])
    np.savetxt(
        results / "log.csv",
        table,
        delimiter=",",
        header="time,position,force",
        comments="",
        fmt="%.9g",
    )
    (results / "axis.toml").write_text(AXIS)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "bristle.report.page.picture",
            lambda name, draw, alternative, caption, **_: Picture(
                f"figure-{name}", Markup(), caption
            ),
        )
        patch.setattr("bristle.apps.lab.living.living_part", lambda *_: None)
        for draws in (20, 0):
            settings = {"poor_error": 41.0}
            result = br.identify(
                results / "log.csv",
                "coulomb_viscous",
                axis=results / "axis.toml",
                draws=draws,
                blocks=0,
                settings=settings,
            )
            result.save(results / f"results_{draws}")
    return results, result


@pytest.fixture
def results(folder, tmp_path, monkeypatch):
    """A copy of it, as the current folder."""
    shutil.copytree(folder[0], tmp_path / "axis")
    monkeypatch.chdir(tmp_path / "axis")
    return tmp_path / "axis"


@pytest.fixture
def determined(monkeypatch):
    """What is asked of simulated logs, which are not simulated."""
    asked = {}

    def noted(recorded, axes, fit, treatment, settings, **options):
        asked.update(
            options, logs=recorded, axes=axes, fit=fit, treatment=treatment, settings=settings
        )
        errors = {
            "M": [0.1, -0.1, 0.2],
            "F_C": [20.0, 21.0, 19.0],
            "F_v": [np.nan] * 3,
            "offset": [1.0, 1.1, 1.0],
            "k": [3.0],
        }
        errors["rare"] = [2.0, 2.1]
        scales, truths, logs = {"offset": "F_C"}, {"F_v": 0.0}, {"rare": 5}
        return tuple(
            Determined(
                name,
                "N",
                "",
                truths.get(name, 8.0),
                scales.get(name, name),
                np.array(each),
                3,
                2,
                logs.get(name, 3),
            )
            for name, each in errors.items()
        )

    monkeypatch.setattr(Determined, "by_simulated_logs", noted)
    return asked


@pytest.mark.slow
def test_the_verdict_comes_first_and_names_what_the_log_determines(bristle, results):
    result = bristle("check", "results_20", "--draws", "3")
    assert (result.code, result.err) == (0, "")
    first = result.out.splitlines()[0]
    assert first.startswith("This log determines M, F_C and offset")
    assert "determine F_v" in first
    assert "Parameters that this log determines: coulomb_viscous, 3 simulated logs" in result.out
    assert "3 of 3" in result.out
    assert "follows the model exactly" in result.out


def test_the_table_has_a_verdict_in_words_for_each_parameter(bristle, results, determined):
    result = bristle("check", "results_20", "--draws", "3")
    words = " ".join(result.out.split())
    assert (
        "This log determines M and offset; determines F_C roughly; does not determine F_v, k and rare."
        in words
    )
    for verdict in (
        "determined within 0.86 %",
        "rough: within 25 %",
        "not determined: the true value is 0",
        "within 1.3 % of F_C",
        "not determined: identified in 1 of 3 logs",
        "not determined: identified in 2 of 5 logs, in those within 3.2 %",  # Student's t of one degree of freedom: 12.7
    ):
        assert verdict in words
    assert "2 of 3" in words


def test_json_has_the_same_as_numbers(bristle, results, determined):
    result = bristle("check", "results_20/summary.json", "--json")
    assert (result.code, result.err) == (0, "")
    assert (result.data["model"], result.data["draws"], determined["count"]) == (
        "coulomb_viscous",
        10,
        10,
    )
    assert result.data["sentence"].startswith("This log determines M")
    assert result.data["parameters"]["F_C"]["median_error_percent"] == 20.0
    assert result.data["parameters"]["F_C"]["verdict"] == "rough"
    assert result.data["parameters"]["F_v"]["median_error_percent"] is None
    assert result.data["parameters"]["offset"]["relative_to"] == "F_C"
    section = (
        REFERENCE.read_text(encoding="utf-8")
        .partition("## What a log determines")[2]
        .partition("\n## ")[0]
    )
    named = {word.rpartition(".")[2] for word in re.findall(r"`([\w.…]+)`", section)}
    assert {*result.data, *result.data["parameters"]["M"]} - {"parameters"} <= named


def test_the_true_values_are_those_of_the_model_file(bristle, results, determined):
    file = results / "results_20/model.toml"
    text = file.read_text()
    (line,) = [line for line in text.splitlines() if line.startswith("F_C = ") and "#" in line]
    file.write_text(text.replace(line, "F_C = 11.0"))
    assert bristle("check", "results_20").code == 0
    assert determined["fit"].friction.values["F_C"] == 11.0
    assert determined["axes"][0].resolution == 1e-6
    assert determined["treatment"]["cutoff"] == 100.0


def test_an_identification_is_checked_in_python_with_its_own_log(folder, determined):
    _, result = folder
    known = result.known_truth(draws=3)
    assert determined["logs"] == [result.log]
    assert determined["settings"]["poor_error"] == 41.0
    assert known.parameters["M"].verdict == "determined"
    assert repr(known).startswith("This log determines M")


def test_a_log_that_was_moved_is_named_or_looked_for_in_the_current_folder(
    bristle, results, determined, monkeypatch
):
    (results / "log.csv").rename(results.parent / "moved.csv")
    bristle(
        "check",
        "results_20",
        code=2,
        said=(
            "the log of these results is missing; found 'log.csv', allowed a file in this folder, in its parent folder",
            "--log PATH",
        ),
    )
    assert bristle("check", "results_20", "--log", "../moved.csv").code == 0
    (results.parent / "moved.csv").rename(results.parent / "log.csv")
    monkeypatch.chdir(results.parent)
    assert bristle("check", "axis/results_20").code == 0


def test_a_log_that_has_changed_is_refused(bristle, results, determined):
    text = Path("log.csv").read_text()
    Path("log.csv").write_text(text.replace("0.001,", "0.00100,", 1))
    bristle(
        "check",
        "results_20",
        code=2,
        said=("log.csv: is not the log of these results, or has changed since", "found 'SHA-256 "),
    )
    assert not determined


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((".",), "is not a folder of results; allowed a folder with summary.json"),
        (("results_0",), "without simulated logs"),
        (("results_20", "--log", "log.csv", "--log", "log.csv"), "the number of logs differs"),
        (("results_20", "--log", "nowhere.csv"), "nowhere.csv"),
        (("results_20", "--loop", "1 mm,2 mm"), "--loop"),
        (
            ("results_20/model.toml", "--log", "log.csv"),
            "--log: applies only to a folder of results",
        ),
        (("results_20/model.toml", "--draws", "5"), "--draws: applies only to a folder of results"),
        (("results_20", "--draws", "2"), "--draws"),
        (("nowhere",), "a folder of results"),
        (("other",), "contains no identification"),
    ],
)
def test_unsuitable_results_are_refused_with_advice(bristle, results, arguments, words):
    shutil.copytree("results_20", "other")
    Path("other/summary.json").write_text('{"variants": {}}')
    result = bristle("check", *arguments, code=2, said=words)
    assert result.out == ""


def test_results_from_memory_ask_for_their_log(folder, undrawn, tmp_path):
    replace(folder[1], log=replace(folder[1].log, source=Path(), origin=NOWHERE)).save(
        tmp_path / "memory"
    )
    with pytest.raises(br.core.InputError, match="contains no file name of the log"):
        br.load(tmp_path / "memory").known_truth()
