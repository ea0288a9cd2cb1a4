"""What comes out of a trial whose errors are made up: intervals, shares, the best family, claims and tables."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.cli.conftest import bristle  # noqa: F401
from tests.report.pages import Page

from bristle import friction
from bristle.apps.paper import EXPERIMENTS, rig
from bristle.apps.paper.robust import findings, loops, page, trial as trials
from bristle.apps.paper.robust.truths import FOLDER, NOMINAL, SIMULATED, Truth, truths_named, under
from bristle.core import Axis, InputError, Status, content, content_of
from bristle.engine import force_along, interpreted
from bristle.files import read_experiment, read_model
from bristle.identification.result import Identification
from bristle.models.friction.uneven import uneven
from bristle.models.plants import inertia

FIRST, OTHER = (
    Truth("thirty_sliders", None, content.NOWHERE, ("gms",)),
    Truth("lugre", None, content.NOWHERE, ("lugre",)),
)


@pytest.fixture
def trial():
    """Two truths in the loops of a set, with two families."""
    plan = trials.Plan(
        (FIRST, OTHER),
        3,
        conditions=(NOMINAL, "level_1.6"),
        sets=("set_a",),
        families=("gms", "lugre"),
    )
    made = trials.Trial(
        plan,
        {
            (truth.name, family): SimpleNamespace(reason="")
            for truth in plan.truths
            for family in plan.compensators
        },
    )
    sizes = {"none": 1.5, "feedforward": 0.6, "observer": 0.5, "observer_feedforward": 0.4}
    for cell in plan.cells:
        size = sizes[cell.variant] * {"gms": 0.5, "lugre": 1.5}.get(cell.family, 1.0)
        if cell.condition != NOMINAL:
            size *= 1.2
        made.errors[cell] = 1e-6 * size * np.array([0.99, 1.0, 1.01])
    return made


def test_a_plan_contains_each_loop_and_feedforward_of_each_family():
    cells = trials.Plan(
        (FIRST,),
        2,
        conditions=(NOMINAL, "level_1.6"),
        sets=("set_a", "set_c"),
        families=("gms", "maxwell_slip"),
    ).cells
    assert len(cells) == 2 * 2 * 4 + 2
    assert {cell.family for cell in cells if cell.variant in ("none", "observer")} == {""}
    assert {cell.family for cell in cells if cell.variant == "observer_feedforward"} == {
        "maxwell_slip"
    }
    assert trials.Plan((FIRST,), 2, families=("gms",)).compensators == ("gms", "maxwell_slip")


def size_of(*case, **of):
    """The peak-to-peak error of a loop [µm]."""
    return lambda trial: 1e6 * findings.error_of(trial, *case, **of).peak_to_peak


@pytest.mark.parametrize(
    ("read", "expected"),
    [
        (size_of("set_a", "lugre", "none"), pytest.approx(1.5)),
        (size_of("set_a", "lugre", "feedforward", family="gms"), pytest.approx(0.3)),
        (size_of("set_a", "lugre", "observer", "level_1.6"), pytest.approx(0.6)),
        (lambda trial: findings.error_of(trial, "set_c", "lugre", "none"), None),
        # What remains is a share of the error without compensation.
        (
            lambda trial: findings.share_left(trial, "set_a", "lugre", "observer"),
            pytest.approx(1.0 / 3.0),
        ),
        (
            lambda trial: findings.share_left(trial, "set_a", "lugre", "feedforward", "gms"),
            pytest.approx(0.2),
        ),
        # The best family has the smallest remaining error; a stranger is of another structure.
        (lambda trial: findings.best_family(trial, "set_a", FIRST), "gms"),
        (lambda trial: findings.best_family(trial, "set_a", FIRST, strangers=True), "maxwell_slip"),
        (lambda trial: findings.best_family(trial, "set_a", OTHER, strangers=True), "gms"),
        (lambda trial: findings.best_family(trial, "set_c", FIRST), ""),
        # A claim holds up to its limit.
        (lambda trial: findings.Claim("x", 0.5, {"a": 0.5, "b": 0.4}).holds, True),
        (lambda trial: findings.Claim("x", 0.5, {"a": 0.5, "b": 0.501}).holds, False),
        (lambda trial: findings.claims(trial, "set_c"), []),
    ],
)
def test_numbers_of_a_trial_are_found_by_their_loop(trial, read, expected):
    assert read(trial) == expected


def test_a_loop_without_a_run_has_no_error(trial):
    trial.errors[trials.Cell("set_a", "lugre", NOMINAL, "none", "")] = np.empty(0)
    assert findings.error_of(trial, "set_a", "lugre", "none") is None
    assert math.isnan(findings.share_left(trial, "set_a", "lugre", "observer"))


@pytest.mark.parametrize(
    ("both", "named"), [(0.499, ["lugre"]), (0.48, []), (0.5, ["lugre"]), (0.6, ["lugre"])]
)
def test_both_together_do_better_by_more_than_their_intervals(trial, both, named):
    cells = [
        trials.Cell("set_a", "lugre", NOMINAL, name, family)
        for name, family in (("observer", ""), ("observer_feedforward", "maxwell_slip"))
    ]
    trial.errors[cells[0]] = 1e-6 * np.array([0.499, 0.5, 0.501])
    trial.errors[cells[1]] = 1e-6 * (both + np.array([-0.001, 0.0, 0.001]))
    assert findings.no_better(trial, "set_a") == named
    trial.errors = {}
    assert findings.no_better(trial, "set_a") == []


def test_a_single_run_has_no_interval_to_exceed(trial):
    for name, family, size in (
        ("observer", "", 0.5),
        ("observer_feedforward", "maxwell_slip", 0.499),
    ):
        trial.errors[trials.Cell("set_a", "lugre", NOMINAL, name, family)] = np.array([size * 1e-6])
    assert findings.no_better(trial, "set_a") == []


def test_claims_are_of_the_rig_at_every_level_and_of_all_other_truths(trial):
    first, others = findings.claims(trial)
    assert (first.limit, others.limit) == (0.45e-6, 0.5e-6)
    assert first.errors == {NOMINAL: pytest.approx(0.4e-6), "level_1.6": pytest.approx(0.48e-6)}
    assert others.errors == {"lugre": pytest.approx(0.4e-6)}
    assert [claim.holds for claim in (first, others)] == [False, True]


def test_numbers_contain_every_loop_and_family(trial):
    data = findings.numbers(trial)
    assert data["robust"]["lugre"]["level_1.6"]["none"]["peak_to_peak"] == pytest.approx(1.8e-6)
    family = data["families"]["lugre"]["lugre"]
    assert family["own_structure"] is True
    assert family["set_a"]["share_left"] == pytest.approx(0.6)
    assert data["families"]["lugre"]["gms"]["own_structure"] is False
    best = data["best_family"]["thirty_sliders"]["set_a"]
    assert best == {
        "family": "gms",
        "share_left": pytest.approx(0.2),
        "stranger": "maxwell_slip",
        "stranger_share_left": pytest.approx(0.4),
    }
    assert data["claims"]["set_a"][0]["holds"] is False
    assert data["observer_alone_does_as_well"] == {"set_a": []}


@pytest.mark.parametrize(
    ("told", "number", "words"),
    [
        (findings.micrometres, None, "–"),
        (findings.micrometres, findings.interval([math.inf, 1e-6]), "diverged"),
        (findings.micrometres, findings.interval([1.234e-6]), "1.23"),
        (
            findings.micrometres,
            findings.Interval(1.234e-6, 1.134e-6, 1.334e-6, 1.4e-6, 3),
            "1.23 (1.13 to 1.33)",
        ),
        (findings._percent, math.nan, "–"),
        (findings._percent, math.inf, "diverged"),
        (findings._percent, 0.123, "12"),
    ],
)
def test_an_error_is_written_with_its_interval_and_a_share_in_percent(told, number, words):
    assert told(number) == words


def test_tables_have_a_row_for_each_case(trial):
    errors = findings.error_table(trial, "set_a")
    assert [row[:2] for row in errors.rows] == [
        (name, condition)
        for name in ("thirty_sliders", "lugre")
        for condition in (NOMINAL, "level_1.6")
    ]
    assert errors.rows[0][2].startswith("1.50 (")
    assert "mean over 3 runs" in errors.caption
    shown = findings.claim_table(trial)
    assert [(row[1], row[3], row[4]) for row in shown.rows] == [
        ("0.45", "level_1.6", "no"),
        ("0.50", "lugre", "yes"),
    ]
    assert shown.rows[0][2] == "0.48"
    best = findings.best_table(trial)
    assert best.rows[0] == (
        "thirty_sliders",
        "Set A",
        "gms",
        "yes",
        "20",
        "maxwell_slip",
        "40",
        "40",
    )
    assert best.rows[1][2:4] == ("gms", "no")
    families = findings.family_table(trial, "set_a")
    assert families.rows[0] == ("gms", "20*", "20")
    assert families.rows[1] == ("lugre", "60", "60*")


def test_margins_are_listed_for_loops_without_a_model():
    table = findings.margin_table({"set_c": {"none": {"phase_deg": 45.678, "gain": 3.4567}}})
    assert table.rows == [("Set C", "no compensation", "45.7", "3.46")]


# --- the report -----------------------------------------------------------------------------------------------------


def test_sentences_state_removed_and_remaining_error_by_truth(trial):
    feedforward, both = page.words_of(trial)
    assert (
        feedforward
        == "Set A: model feedforward removes 60 % of the error, depending on the friction, and leaves 0.60 µm."
    )
    assert (
        both
        == "Set A: model feedforward and observer together remove 73 % of the error, depending on the friction, and leave 0.40 µm."
    )
    trial.errors[trials.Cell("set_a", "lugre", NOMINAL, "observer_feedforward", "maxwell_slip")] = (
        1e-6 * np.array([0.49, 0.5, 0.51])
    )
    for name, size in (("thirty_sliders", 0.75), ("lugre", 3.0)):
        trial.errors[trials.Cell("set_a", name, NOMINAL, "feedforward", "printed")] = np.array(
            [size * 1e-6]
        )
    _, printed, both, alone = page.words_of(trial)
    assert (
        printed
        == "Set A: feedforward of equations (5)–(7) as printed removes −100 to 50 % of the error, depending on the friction, "
        "and leaves 0.75 to 3.00 µm."
    )
    assert (
        both
        == "Set A: model feedforward and observer together remove 67 to 73 % of the error, depending on the friction, "
        "and leave 0.40 to 0.50 µm."
    )
    assert alone == "Set A: on 1 of 2 frictions (lugre) the observer alone is as accurate as both."
    trial.errors.clear()
    assert page.words_of(trial) == []


@pytest.mark.parametrize(
    ("sliders", "other", "level", "reasons"),
    [
        (0.44, 0.5, "usable", ()),
        (0.44, 0.52, "with_care", ("Set A, above 0.50 µm: lugre 0.52 µm",)),
        (0.46, 0.5, "with_care", ("Set A, above 0.45 µm: level_1.6 0.46 µm",)),
        (
            0.46,
            0.52,
            "no",
            ("Set A, above 0.45 µm: level_1.6 0.46 µm", "Set A, above 0.50 µm: lugre 0.52 µm"),
        ),
    ],
)
def test_the_verdict_has_each_claim_that_was_missed_and_on_which_case(
    trial, sliders, other, level, reasons
):
    for name, condition, size in (
        ("thirty_sliders", "level_1.6", sliders),
        ("lugre", NOMINAL, other),
    ):
        trial.errors[
            trials.Cell("set_a", name, condition, "observer_feedforward", "maxwell_slip")
        ] = 1e-6 * np.full(3, size)
    ruling = page.ruling_of(trial)
    assert (ruling.level, ruling.reasons) == (level, reasons)


def test_the_picture_has_mean_interval_and_range_under_all_conditions(trial, monkeypatch):
    drawn = []
    monkeypatch.setattr(page, "errors_by_truth", lambda *passed: drawn.append(passed))
    monkeypatch.setattr(page, "picture", lambda name, draw, *words, **published: draw())
    trial.errors[trials.Cell("set_a", "lugre", "level_1.6", "none", "")] = np.array([math.inf])
    del trial.errors[trials.Cell("set_a", "lugre", NOMINAL, "observer", "")]
    page._picture(trial)
    ((errors, limit, axis, word),) = drawn
    assert (limit, axis, word) == (0.5, "Following error [µm]", "0.5 µm")
    assert list(errors["Set A"]) == ["thirty sliders", "lugre"]
    loops = errors["Set A"]["thirty sliders"]
    assert list(loops) == ["no compensation", "model feedforward", "observer", "both"]
    half = 4.302653 * 0.005 / math.sqrt(3.0)  # Student's factor of two degrees of freedom
    assert loops["observer"] == pytest.approx((0.5, 0.5 - half, 0.5 + half, 0.5, 0.6))
    assert errors["Set A"]["lugre"]["no compensation"][3:] == pytest.approx((1.5, 1.5))
    assert errors["Set A"]["lugre"]["observer"] == pytest.approx(
        (math.nan, math.nan, math.nan, 0.6, 0.6), nan_ok=True
    )


def test_the_report_has_conditions_tables_and_families_that_could_not_be_fitted(trial, monkeypatch):
    shown = {}
    monkeypatch.setattr(
        page,
        "page_of",
        lambda front, sections, **_: shown.update(
            (section.id, section.blocks) for section in sections
        ),
    )
    monkeypatch.setattr(page, "_front", lambda trial: None)
    monkeypatch.setattr(
        findings,
        "margins_of_sets",
        lambda sets: {name: {"none": {"phase_deg": 45.0, "gain": 3.0}} for name in sets},
    )
    for key, fit in trial.fits.items():
        fit.friction, fit.reason = (
            (None, "no rest in it") if key == ("lugre", "gms") else ("a model", "")
        )
    page.robust_report(trial, command="c", provenance={})
    *_, errors, conditions, margins = shown["table"]
    *_, best, families, missing, unfitted = shown["families"]
    assert (missing, unfitted.content) == ("Not identified:", ["gms on lugre: no rest in it"])
    assert [row[0] for row in conditions.rows] == [NOMINAL, "level_1.6"]
    assert all(table.rows for table in (errors, best, families))
    assert [row[0] for row in margins.rows] == ["Set A"]
    summary = page.robust_summary(trial, provenance={"a": "b"})
    assert (summary["sentences"], summary["verdict"]["level"]) == (
        page.words_of(trial),
        "with_care",
    )
    assert (summary["chosen_family"], summary["provenance"]) == ("maxwell_slip", {"a": "b"})


# --- Compensation on other truths: the layer of conditions, and what comes out


ROOT = Path(__file__).parents[3]
DT = 1e-3


@interpreted()
def forces(model, velocities):
    """The forces of a model along velocities, step by step, as plain Python."""
    return force_along(model, velocities, DT, np.cumsum(velocities) * DT)


TO_AND_FRO = np.concatenate([np.full(300, side * 1e-5) for side in (1.0, -1.0, 1.0, -1.0)])
ELEMENTS = friction.find("maxwell_slip")(F_C=20.0, k_i=[2e7, 1e7], nu_i=[0.6, 0.4], offset=3.0)


def test_the_default_layer_has_no_effect():
    assert forces(uneven(ELEMENTS), TO_AND_FRO) == pytest.approx(
        forces(ELEMENTS, TO_AND_FRO), abs=1e-12
    )


def test_a_level_multiplies_all_but_the_offset():
    before, after = forces(ELEMENTS, TO_AND_FRO), forces(uneven(ELEMENTS, level=1.3), TO_AND_FRO)
    assert after - 3.0 == pytest.approx(1.3 * (before - 3.0), abs=1e-12)


def test_a_wave_repeats_after_its_length():
    onward = np.full(2000, 1e-5)
    force = forces(uneven(ELEMENTS, wave=0.2, wavelength=5e-6), onward) - 3.0
    sliding = force[1000:]
    assert (sliding.min(), sliding.max()) == pytest.approx((16.0, 24.0), abs=0.02)
    assert sliding[500:] == pytest.approx(sliding[:-500], abs=1e-9)


def test_the_creep_branch_yields_to_a_lasting_force():
    fixed = np.concatenate([np.full(100, 1e-4), np.zeros(3000)])
    free = uneven(ELEMENTS, k_creep=1e6, tau=0.5)
    extra = forces(free, fixed) - forces(ELEMENTS, fixed)
    assert extra[99] == pytest.approx(1e6 * 1e-5, rel=0.12)
    assert extra[600] / extra[100] == pytest.approx(math.exp(-1.0), rel=0.01)


# --- truths -----------------------------------------------------------------------------------------------------


def test_the_gallery_has_the_break_away_force_and_the_stiffness_of_the_rig():
    truths = {truth.name: truth.friction.values for truth in truths_named(list(SIMULATED))}
    rig = truths["thirty_sliders"]
    for name in ("gms", "printed", "lugre"):
        assert truths[name]["F_S_pos"] == rig["F_S_pos"]
        assert truths[name]["F_C_neg"] == rig["F_C_neg"]
    stiffness = sum(rig["k_i"])
    for name, key in (
        ("printed", "s"),
        ("lugre", "sigma_0"),
        ("bouc_wen", "s"),
        ("reformed_dahl", "s"),
    ):
        assert truths[name][key] == pytest.approx(36.066e6)
    assert sum(truths["gms"]["k_i"]) == pytest.approx(stiffness)
    assert all(
        truth["offset"] == pytest.approx(2.0 * math.pi, rel=1e-3) for truth in truths.values()
    )


def test_an_unknown_truth_is_refused_with_the_known_truths(tmp_path):
    with pytest.raises(
        InputError,
        match=r"is not a known friction; found 'gsm'.*thirty_sliders, gms.*Did you mean 'gms'",
    ):
        truths_named(["gsm"])
    (log := tmp_path / "log.csv").write_text("time,force")
    with pytest.raises(
        InputError, match=r"is not a known friction.*bristle identify writes a model file of a log"
    ):
        truths_named([str(log)])
    again = tmp_path / "gms.toml"
    again.write_bytes((FOLDER / "gms.toml").read_bytes())
    with pytest.raises(InputError, match="two frictions have the same name"):
        truths_named(["gms", str(again)])
    assert [truth.name for truth in truths_named()] == list(SIMULATED)


def test_a_model_file_is_an_unchanged_truth(tmp_path):
    mine = tmp_path / "mine.toml"
    mine.write_bytes((FOLDER / "lugre.toml").read_bytes())
    (truth,) = truths_named([str(mine)])
    assert (truth.name, truth.friction.values["unevenness"]) == ("mine", 0.0)
    assert "lugre" in truth.families
    assert "dahl" not in truth.families


# --- a trial in which nothing is simulated -----------------------------------------------------------------------


@pytest.fixture
def quick(monkeypatch):
    """How often each thing was done."""
    done = {"runs": 0, "fits": 0}

    def run(variant, number):
        done["runs"] += 1
        return 1e-6 + 1e-9 * number

    def fit(family, log, axis):
        done["fits"] += 1
        return (
            trials.Fitted(None, "not in this log") if family == "dahl" else trials.Fitted(ELEMENTS)
        )

    monkeypatch.setattr(trials, "peak_to_peak", run)
    monkeypatch.setattr(trials, "fitted", fit)
    monkeypatch.setattr(trials, "log_of", lambda truth: (None, Axis(kind="translational")))
    return done


def test_each_loop_runs_with_each_compensator_that_was_identified(quick):
    words = []
    plan = trials.Plan(
        tuple(truths_named(["lugre"])),
        3,
        conditions=(NOMINAL, "level_1.6"),
        sets=("set_a",),
        families=("dahl",),
    )
    trial = trials.run_trial(plan, lambda share, text: words.append((share, text)))
    assert quick == {"runs": 3 * 2 * len(loops.VARIANTS), "fits": 2}
    assert trial.fits["lugre", "dahl"].reason == "not in this log"
    assert trial.fits["lugre", "maxwell_slip"].friction == ELEMENTS
    assert findings.error_of(trial, "set_a", "lugre", "feedforward", family="dahl") is None
    assert findings.error_of(trial, "set_a", "lugre", "none").seeds == 3
    assert words[0] == (0.0, "lugre: identifying dahl")
    # Of nine loops that of dahl is not run.
    assert sorted(share for share, _ in words if share) == pytest.approx(
        [count / 9.0 for count in range(1, 9)]
    )


def keys_of_the_docs():
    """The dotted keys of the section of the command; names in capitals stand for any."""
    page = (
        (ROOT / "docs" / "reference" / "json.md")
        .read_text()
        .split("\n## bristle paper --robust\n")[1]
    )
    result = []
    for line in re.findall(r"^\| (`.*?) \|", page.split("\n## ")[0], flags=re.MULTILINE):
        for key in re.findall(r"`([^`]+)`", line):
            result.append(key if not key.startswith(".") else result[-1].rpartition(".")[0] + key)
    return result


def at_key(message, key):
    for part in key.split("."):
        name = part.removesuffix("[]")
        message = next(iter(message.values())) if name.isupper() else message[name]
    return message


@pytest.mark.slow
def test_the_command_writes_report_and_numbers(bristle, quick, tmp_path, monkeypatch):  # noqa: F811
    monkeypatch.chdir(tmp_path)
    requested = ("paper", "--robust", "lugre,gms", "--seeds", "2", "--out", "out", "--json")
    done = bristle(*requested)
    assert done.code == 0, done.err
    for key in keys_of_the_docs():
        at_key(done.data, key)
    assert set(done.data) == {
        key.partition(".")[0].removesuffix("[]") for key in keys_of_the_docs()
    }
    assert done.data["verdict"]["level"] == "no"  # 1 µm everywhere
    assert json.loads(Path("out/summary.json").read_text()) == done.data
    page = Page(Path("out/report.html").read_text(encoding="utf-8"))
    assert [figure["id"] for figure in page.named("figure")] == ["figure-robust"]
    again = bristle(*requested[:-1], "--force", "--format", "svg")
    assert again.code == 0
    assert "Set A" in again.out
    assert Path("out/figures/robust.svg").is_file()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--robust", "--figure", "4"), "--figure: has no effect with --robust"),
        (("--robust", "--write", "there"), "--write: has no effect with --robust"),
        (("--seeds", "3"), "--seeds: has no effect without --robust"),
        (("gms",), "FRICTION: has no effect without --robust"),
        (("--robust", "gms,bouc_ven"), "Did you mean 'bouc_wen'?"),
        (("--robust", "--seeds", "0"), "--seeds"),
        (
            ("--robust", "--axis", "axis.toml", "gms"),
            "Give frictions or model files after --robust",
        ),
    ],
)
def test_conflicting_options_are_refused(bristle, tmp_path, monkeypatch, arguments, words):  # noqa: F811
    monkeypatch.chdir(tmp_path)
    ended = bristle("paper", *arguments)
    assert ended.code == 2
    assert words in ended.err
    assert not list(Path().iterdir())


# --- what comes out ---------------------------------------------------------------------------------------------


def test_the_interval_is_that_of_student():
    message = findings.interval([1.0, 2.0, 3.0, 6.0])
    assert message.peak_to_peak == 3.0
    # 3 ± 3.182 * 2.160 / 2
    assert (message.low, message.high) == pytest.approx((-0.4374, 6.4374), abs=1e-4)
    assert (message.largest, message.seeds) == (6.0, 4)
    assert math.isnan(findings.interval([1.0]).low)
    assert findings.interval([1.0, math.inf]).peak_to_peak == math.inf


def told_in_the_docs():
    return json.loads((ROOT / "docs" / "theory" / "robust.json").read_text())


def test_the_pages_quote_the_run():
    message = told_in_the_docs()
    page = (ROOT / "docs" / "reference" / "robustness.md").read_text()
    for sentence in message["sentences"]:
        assert f"- {sentence}" in page
    readme = " ".join((ROOT / "README.md").read_text().split())
    shares, left = {}, {}
    for variant in ("feedforward", "observer_feedforward"):
        errors = [
            (truth["nominal"]["none"]["peak_to_peak"], truth["nominal"][variant]["peak_to_peak"])
            for truth in message["robust_set_c"].values()
        ]
        shares[variant] = sorted(100.0 * (1.0 - after / before) for before, after in errors)
        left[variant] = sorted(1e6 * after for _, after in errors)
    alone, both = shares["feedforward"], shares["observer_feedforward"]
    assert f"the model alone removes {alone[0]:.0f} to {alone[-1]:.0f} % of the error" in readme
    assert f"model and observer together {both[0]:.0f} to {both[-1]:.0f} %" in readme
    ends = left["observer_feedforward"]
    assert f"The remaining error is {ends[0]:.2f} to {ends[-1]:.2f} µm" in readme


def test_the_page_explains_the_larger_error_of_the_softer_loop():
    message, page = told_in_the_docs(), (ROOT / "docs" / "theory" / "compensation.md").read_text()
    levels = ("nominal", "level_0.7", "level_1.3", "level_1.6")
    soft, stiff = (
        {
            level: {
                name: 1e6 * item["peak_to_peak"]
                for name, item in message[key]["thirty_sliders"][level].items()
            }
            for level in levels
        }
        for key in ("robust_set_c", "robust")
    )
    none, both = soft["level_1.6"]["none"], soft["level_1.6"]["observer_feedforward"]
    assert f"{both:.2f} µm on `thirty_sliders` at 1.6 times the level" in page
    assert (
        f"{soft['nominal']['none']:.2f} µm in set C and {stiff['nominal']['none']:.2f} µm in set A"
        in page
    )
    assert f"both together leave {100.0 * both / none:.0f} % of {none:.2f} µm" in page
    left = [stiff[level]["observer_feedforward"] for level in levels]
    assert f"{min(left):.2f} to {max(left):.2f} µm at every level" in page


def test_the_run_of_the_docs_meets_the_claims():
    message = told_in_the_docs()
    assert set(message["robust"]) == set(SIMULATED)
    for claim in message["claims"]["set_a"]:
        assert claim["holds"] == all(error <= claim["limit"] for error in claim["errors"].values())
        assert claim["holds"], claim
    assert message["provenance"]["gms_sha256"] == content_of(FOLDER / "gms.toml").origin.checksum


# --- the figures of the docs ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_claims_for_observer_and_feedforward_hold_on_every_truth():
    levels = (NOMINAL, "level_0.7", "level_1.3", "level_1.6")
    trial = trials.run_trial(
        trials.Plan(tuple(truths_named()), 4, conditions=levels, sets=("set_a",), families=())
    )
    result = findings.claims(trial)
    assert len(result) == 2
    for claim in result:
        assert claim.holds, claim
    message = told_in_the_docs()["robust"]
    for truth in trial.plan.truths:
        for condition in levels:
            for variant in loops.VARIANTS:
                error = findings.error_of(
                    trial, "set_a", truth.name, variant, condition
                ).peak_to_peak
                of_docs = message[truth.name][condition][variant]
                assert error == pytest.approx(of_docs["peak_to_peak"], rel=0.08, abs=3e-8), (
                    truth.name,
                    condition,
                )


@pytest.mark.slow
def test_fewer_integration_steps_give_the_same_result():
    (truth,) = truths_named(["thirty_sliders"])
    for variant in ("none", "observer"):
        coarse = loops.loop(loops.setting("set_a")[variant], truth.friction, None)
        fine = replace(coarse, run=replace(coarse.run, substeps=25))
        few, many = (
            findings.interval([loops.peak_to_peak(each, number) for number in range(20)])
            for each in (coarse, fine)
        )
        apart = abs(few.peak_to_peak - many.peak_to_peak)
        assert apart <= math.hypot(few.high - few.peak_to_peak, many.high - many.peak_to_peak)


# --- loops of a trial -------------------------------------------------------------------------------------------


def test_a_loop_of_a_trial_has_the_friction_and_the_compensator_and_is_run_once():
    plain, fed = (loops.setting("set_a")[name] for name in ("none", "feedforward"))
    rig, model = truths_named(["lugre"])[0].friction, friction.coulomb(F_C=3.0)
    for variant in (plain, fed):
        made = loops.loop(variant, rig, model)
        assert (made.friction, made.run.substeps, made.run.seeds) == (rig, 4, 1)
        assert made.run.sample_time == variant.run.sample_time
    assert loops.loop(plain, rig, model).feedforward == plain.feedforward
    assert (
        loops.loop(fed, rig, model).feedforward.friction,
        loops.loop(fed, rig, model).feedforward.fitted_to,
    ) == (model, "")


@pytest.mark.parametrize(
    ("number", "status", "error"),
    [(0, Status.OK, 2e-6), (3, Status.OK, 2e-6), (1, Status.NOT_FINITE, math.inf)],
)
def test_each_run_of_a_loop_has_other_scatter_and_noise(monkeypatch, number, status, error):
    asked = []

    def simulated(experiment):
        asked.append(experiment.variants[0])
        return SimpleNamespace(
            variants={
                asked[0].name: SimpleNamespace(
                    status=status, following_error=SimpleNamespace(peak_to_peak=2e-6)
                )
            }
        )

    monkeypatch.setattr(loops, "simulate", simulated)
    variant = loops.loop(loops.setting("set_a")["none"], truths_named(["lugre"])[0].friction, None)
    assert loops.peak_to_peak(variant, number) == error
    for model, now in ((variant.friction, asked[0].friction), (variant.sensor, asked[0].sensor)):
        assert now.values == model.values | {"seed": model.values["seed"] + number}
    del asked[:]
    loops.peak_to_peak(replace(variant, friction=friction.coulomb(F_C=3.0)), number)
    assert asked[0].friction == friction.coulomb(F_C=3.0)  # nothing scatters


@pytest.mark.parametrize(("family", "named"), [("lugre", "lugre"), ("printed", "preisach_lugre")])
def test_a_family_is_fitted_without_intervals_and_the_printed_equations_lose_their_gate(
    monkeypatch, family, named
):
    model = friction.find("preisach_lugre")(**friction.find("preisach_lugre").example)
    asked = []
    identification = Identification((SimpleNamespace(friction=model),), "log")
    monkeypatch.setattr(
        loops, "identify", lambda log, name, **how: asked.append((name, how)) or identification
    )
    result = loops.fitted(family, "log", "axis")
    assert asked == [(named, {"axis": "axis", "blocks": 0, "draws": 0})]
    assert (result.friction.values["transition"] == "paper") is (family == "printed")

    def refused(*log, **how):
        raise InputError("is too short")

    monkeypatch.setattr(loops, "identify", refused)
    assert loops.fitted(family, "log", "axis") == (None, "is too short")


@pytest.mark.parametrize(
    ("condition", "changes"),
    [
        (NOMINAL, {}),
        ("level_0.7", {"level": 0.7}),
        ("level_1.6", {"level": 1.6}),
        ("scatter_10", {"unevenness": 0.1}),
        ("position_wave", {"wave": 0.2, "wavelength": pytest.approx(5.1e-6)}),
        ("creep", {"k_creep": pytest.approx(10.0 / 6.8e-6), "tau": 5.0}),
    ],
)
def test_a_condition_changes_only_the_layer_around_a_truth(condition, changes):
    def changed(truth):
        now, before = under(condition, truth).values, truth.friction.values
        return {
            name: value for name, value in now.items() if not np.array_equal(value, before[name])
        }

    gms, sliders = truths_named(["gms", "thirty_sliders"])
    assert changed(gms) == changes
    assert (gms.friction.values["unevenness"], gms.friction.values["travel"]) == pytest.approx(
        (0.05, 1.02e-6)
    )
    # Which scatter by themselves.
    assert changed(sliders) == ({"scatter": 0.1} if condition == "scatter_10" else changes)


# --- the rig ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["set_a", "set_b"])
def test_files_of_the_sets_contain_the_friction_of_the_rig(name):
    written, made = (
        model.values
        for model in (
            read_model(EXPERIMENTS / f"{name}_rig.toml").friction,
            rig.rig_friction(*rig.SETS[name]),
        )
    )
    assert set(written) == set(made)
    for key, value in made.items():
        assert np.asarray(written[key]) == pytest.approx(np.asarray(value), rel=1e-9), key


def test_elements_are_uneven_in_strength_by_their_seed_alone():
    shares, distances = rig.spectrum(5, 2.0, 3)
    rho = np.array([0.15, 0.3625, 0.575, 0.7875, 1.0])
    assert distances == pytest.approx(2.0 * rho**1.6)
    weights = (
        (distances / 2.0) ** -0.75
        * np.exp(0.35 * np.random.default_rng(3).standard_normal(5))
        * distances
    )
    assert shares == pytest.approx(weights / np.sum(weights))
    assert rig.screw_ratio(0.5) == pytest.approx(12.566370614)


def test_friction_of_the_rig_is_that_of_the_screw_counted_at_the_table():
    ratio = 2.0 * math.pi / 5e-3
    values = rig.rig_friction(5e-3, 4e-4, 5e-3, 0.3).values
    for side, share in (("pos", 1.3), ("neg", 0.7)):
        assert values[f"F_C_{side}"] == pytest.approx(share * 34e-3 * ratio)
        assert values[f"F_S_{side}"] == pytest.approx(share * 40e-3 * ratio)
        assert values[f"sigma_2_{side}"] == pytest.approx(3e-3 * ratio**2)
    shares, distances = rig.spectrum(30, 7e-6, 7)
    # Where an element slips.
    assert values["k_i"] * distances == pytest.approx(shares * 40e-3 * ratio)
    assert (values["offset"], values["v_S"]) == pytest.approx((5e-3 * ratio, 0.5 / ratio))
    assert values["sigma_1"] == pytest.approx(
        0.4 * math.sqrt(values["k_i"].sum() * 4e-4 * ratio**2)
    )


@pytest.mark.parametrize(("delay", "lag", "late"), [(0, 0.0, 0.0), (2, 0.0, 2.0), (1, 5e-4, 1.5)])
def test_an_effort_is_logged_as_late_as_it_acts(monkeypatch, delay, lag, late):
    described = read_experiment(loops.LOG)
    variant = described.variants[0]
    run = replace(variant.run, delay=delay, current_lag=lag, sample_time=1e-3)
    beside = replace(variant, name="beside", plant=inertia(M=1.0))
    described = replace(described, variants=(replace(variant, run=run), beside))
    outcome = SimpleNamespace(
        command=10.0 * np.arange(9.0), time=1e-3 * np.arange(9.0), measured=np.arange(9.0)
    )
    monkeypatch.setattr(
        rig, "simulate", lambda experiment: SimpleNamespace(variants={variant.name: outcome})
    )
    log = rig.logged(described)
    assert log.effort.values[3:] == pytest.approx(10.0 * (np.arange(3.0, 9.0) - late))
    assert (log.sample_time, log.segments, log.position.values.tolist()) == (
        1e-3,
        (slice(0, 9),),
        list(range(9)),
    )
    axis = rig.axis_of(described)
    assert (axis.mass, axis.resolution) == (
        variant.plant.values["M"],
        variant.sensor.values["resolution"],
    )
    assert (axis.kind, axis.held, axis.cutoff, axis.decimation) == (described.kind, True, 15.0, 33)
