"""What comes out of a trial whose errors are made up: intervals, shares, the best family, claims and tables."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from bristle.core.content import NOWHERE
from bristle.paper.robust import findings, page
from bristle.paper.robust.trial import Cell, Plan, Trial
from bristle.paper.robust.truths import NOMINAL, Truth

FIRST, OTHER = Truth("thirty_sliders", None, NOWHERE, ("gms",)), Truth("lugre", None, NOWHERE, ("lugre",))


@pytest.fixture
def trial():
    """Two truths in the loops of a set, with two families."""
    plan = Plan((FIRST, OTHER), 3, conditions=(NOMINAL, "level_1.6"), sets=("set_a",), families=("gms", "lugre"))
    made = Trial(plan, {(truth.name, family): SimpleNamespace(reason="") for truth in plan.truths for family in plan.compensators})
    sizes = {"none": 1.5, "feedforward": 0.6, "observer": 0.5, "observer_feedforward": 0.4}
    for cell in plan.cells:
        size = sizes[cell.variant] * {"gms": 0.5, "lugre": 1.5}.get(cell.family, 1.0)
        if cell.condition != NOMINAL:
            size *= 1.2
        made.errors[cell] = 1e-6 * size * np.array([0.99, 1.0, 1.01])
    return made


def test_a_plan_contains_each_loop_and_feedforward_of_each_family():
    cells = Plan((FIRST,), 2, conditions=(NOMINAL, "level_1.6"), sets=("set_a", "set_c"), families=("gms", "maxwell_slip")).cells
    assert len(cells) == 2 * 2 * 4 + 2
    assert {cell.family for cell in cells if cell.variant in ("none", "observer")} == {""}
    assert {cell.family for cell in cells if cell.variant == "observer_feedforward"} == {"maxwell_slip"}
    assert Plan((FIRST,), 2, families=("gms",)).compensators == ("gms", "maxwell_slip")


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
        (lambda trial: findings.share_left(trial, "set_a", "lugre", "observer"), pytest.approx(1.0 / 3.0)),
        (lambda trial: findings.share_left(trial, "set_a", "lugre", "feedforward", "gms"), pytest.approx(0.2)),
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
    trial.errors[Cell("set_a", "lugre", NOMINAL, "none", "")] = np.empty(0)
    assert findings.error_of(trial, "set_a", "lugre", "none") is None
    assert math.isnan(findings.share_left(trial, "set_a", "lugre", "observer"))


@pytest.mark.parametrize(("both", "named"), [(0.499, ["lugre"]), (0.48, []), (0.5, ["lugre"]), (0.6, ["lugre"])])
def test_both_together_do_better_by_more_than_their_intervals(trial, both, named):
    cells = [Cell("set_a", "lugre", NOMINAL, name, family) for name, family in (("observer", ""), ("observer_feedforward", "maxwell_slip"))]
    trial.errors[cells[0]] = 1e-6 * np.array([0.499, 0.5, 0.501])
    trial.errors[cells[1]] = 1e-6 * (both + np.array([-0.001, 0.0, 0.001]))
    assert findings.no_better(trial, "set_a") == named
    trial.errors = {}
    assert findings.no_better(trial, "set_a") == []


def test_a_single_run_has_no_interval_to_exceed(trial):
    for name, family, size in (("observer", "", 0.5), ("observer_feedforward", "maxwell_slip", 0.499)):
        trial.errors[Cell("set_a", "lugre", NOMINAL, name, family)] = np.array([size * 1e-6])
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
        (findings.micrometres, findings.Interval(1.234e-6, 1.134e-6, 1.334e-6, 1.4e-6, 3), "1.23 (1.13 to 1.33)"),
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
        (name, condition) for name in ("thirty_sliders", "lugre") for condition in (NOMINAL, "level_1.6")
    ]
    assert errors.rows[0][2].startswith("1.50 (")
    assert "mean over 3 runs" in errors.caption
    shown = findings.claim_table(trial)
    assert [(row[1], row[3], row[4]) for row in shown.rows] == [("0.45", "level_1.6", "no"), ("0.50", "lugre", "yes")]
    assert shown.rows[0][2] == "0.48"
    best = findings.best_table(trial)
    assert best.rows[0] == ("thirty_sliders", "Set A", "gms", "yes", "20", "maxwell_slip", "40", "40")
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
    assert feedforward == "Set A: model feedforward removes 60 % of the error, depending on the friction, and leaves 0.60 µm."
    assert both == "Set A: model feedforward and observer together remove 73 % of the error, depending on the friction, and leave 0.40 µm."
    trial.errors[Cell("set_a", "lugre", NOMINAL, "observer_feedforward", "maxwell_slip")] = 1e-6 * np.array([0.49, 0.5, 0.51])
    for name, size in (("thirty_sliders", 0.75), ("lugre", 3.0)):
        trial.errors[Cell("set_a", name, NOMINAL, "feedforward", "printed")] = np.array([size * 1e-6])
    _, printed, both, alone = page.words_of(trial)
    assert (
        printed == "Set A: feedforward of equations (5)–(7) as printed removes −100 to 50 % of the error, depending on the friction, "
        "and leaves 0.75 to 3.00 µm."
    )
    assert (
        both == "Set A: model feedforward and observer together remove 67 to 73 % of the error, depending on the friction, "
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
        (0.46, 0.52, "no", ("Set A, above 0.45 µm: level_1.6 0.46 µm", "Set A, above 0.50 µm: lugre 0.52 µm")),
    ],
)
def test_the_verdict_has_each_claim_that_was_missed_and_on_which_case(trial, sliders, other, level, reasons):
    for name, condition, size in (("thirty_sliders", "level_1.6", sliders), ("lugre", NOMINAL, other)):
        trial.errors[Cell("set_a", name, condition, "observer_feedforward", "maxwell_slip")] = 1e-6 * np.full(3, size)
    ruling = page.ruling_of(trial)
    assert (ruling.level, ruling.reasons) == (level, reasons)


def test_the_picture_has_mean_interval_and_range_under_all_conditions(trial, monkeypatch):
    drawn = []
    monkeypatch.setattr(page, "errors_by_truth", lambda *passed: drawn.append(passed))
    monkeypatch.setattr(page, "picture", lambda name, draw, *words, **published: draw())
    trial.errors[Cell("set_a", "lugre", "level_1.6", "none", "")] = np.array([math.inf])
    del trial.errors[Cell("set_a", "lugre", NOMINAL, "observer", "")]
    page._picture(trial)
    ((errors, limit, axis, word),) = drawn
    assert (limit, axis, word) == (0.5, "Following error [µm]", "0.5 µm")
    assert list(errors["Set A"]) == ["thirty sliders", "lugre"]
    loops = errors["Set A"]["thirty sliders"]
    assert list(loops) == ["no compensation", "model feedforward", "observer", "both"]
    half = 4.302653 * 0.005 / math.sqrt(3.0)  # Student's factor of two degrees of freedom
    assert loops["observer"] == pytest.approx((0.5, 0.5 - half, 0.5 + half, 0.5, 0.6))
    assert errors["Set A"]["lugre"]["no compensation"][3:] == pytest.approx((1.5, 1.5))
    assert errors["Set A"]["lugre"]["observer"] == pytest.approx((math.nan, math.nan, math.nan, 0.6, 0.6), nan_ok=True)


def test_the_report_has_conditions_tables_and_families_that_could_not_be_fitted(trial, monkeypatch):
    shown = {}
    monkeypatch.setattr(page, "page_of", lambda front, sections, **_: shown.update((section.id, section.blocks) for section in sections))
    monkeypatch.setattr(page, "_front", lambda trial: None)
    monkeypatch.setattr(findings, "margins_of_sets", lambda sets: {name: {"none": {"phase_deg": 45.0, "gain": 3.0}} for name in sets})
    for key, fit in trial.fits.items():
        fit.friction, fit.reason = (None, "no rest in it") if key == ("lugre", "gms") else ("a model", "")
    page.robust_report(trial, command="c", provenance={})
    *_, errors, conditions, margins = shown["table"]
    *_, best, families, missing, unfitted = shown["families"]
    assert (missing, unfitted.content) == ("Not identified:", ["gms on lugre: no rest in it"])
    assert [row[0] for row in conditions.rows] == [NOMINAL, "level_1.6"]
    assert all(table.rows for table in (errors, best, families))
    assert [row[0] for row in margins.rows] == ["Set A"]
    summary = page.robust_summary(trial, provenance={"a": "b"})
    assert (summary["sentences"], summary["verdict"]["level"]) == (page.words_of(trial), "with_care")
    assert (summary["chosen_family"], summary["provenance"]) == ("maxwell_slip", {"a": "b"})
