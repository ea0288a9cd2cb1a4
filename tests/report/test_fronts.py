"""The first page of each report: a verdict that follows the numbers, its reasons, and a figure."""

import datetime
import re
from dataclasses import replace
from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.comparison.machine import log, sine
from tests.excitation.axes import STAGE
from tests.report.pages import Page
from tests.report.test_compensation import with_error
from tests.report.test_pages import COMMON, identification_page, prediction_page, simulation_page

from bristle import compare, references
from bristle.core import Axis, Status
from bristle.core.axis import Column
from bristle.core.diagnostic import Diagnostic
from bristle.excitation import excite
from bristle.report.comparison import comparison_report, comparison_ruling, comparison_summary
from bristle.report.excitation import excitation_report, excitation_ruling
from bristle.report.log import log_report, log_ruling
from bristle.report.loops import loop_doubts, variant_table
from bristle.report.model_tables import drive_rows
from bristle.report.operators import operator_ruling
from bristle.report.prediction import prediction_ruling, prediction_summary
from bristle.report.simulation import simulation_ruling, simulation_summary
from bristle.report.table import length_text
from bristle.simulation.statistics import swing_at_worst_reversal, worst_reversal


@pytest.fixture(scope="module")
def helped():
    return compare([log(1, sine(12))], [log(2, sine(12), gain=0.7)])


def looped(stage, *sizes):
    """The loop of the stage with given following errors, peak to peak [m]."""
    result = stage.looped
    for name, size in zip(result.variants, sizes, strict=True):
        result = with_error(result, name, lambda item, size=size: 0.5 * size * np.sin(40.0 * item.time))
    return result


@pytest.mark.parametrize(
    ("sizes", "level", "words"),
    [
        ((20e-6, 9e-6, 4e-6), "usable", "Compensation helps"),
        ((20e-6, 19.5e-6, 19.4e-6), "with_care", "Compensation hardly helps"),
        ((4e-6, 9e-6, 20e-6), "no", "Compensation does not help"),
        ((20e-6, 4e-6, 9e-6), "usable", "Another loop helps"),
    ],
)
def test_verdict_of_a_run_follows_the_errors(stage, sizes, level, words):
    assert simulation_ruling(looped(stage, *sizes))[:2] == (level, words)


def test_run_reports_worst_reversal_and_effort(stage):
    result = looped(stage, 20e-6, 9e-6, 4e-6)
    words = Page(simulation_page(stage, result=result)).words
    assert "following error 4 µm (compensated) instead of 20 µm (as_recorded)" in words
    assert re.search("Worst reversal ?4 µm ?instead of 20 µm", words)
    assert "Friction feedforward: 9 → 4 µm peak to peak" in words
    assert simulation_summary(result, files={}, provenance={})["verdict"] == simulation_ruling(result).as_data()


def test_warning_asks_for_care_and_divergence_for_no_use(stage):
    result = looped(stage, 20e-6, 9e-6, 4e-6)
    warned = simulation_ruling(result, ["the margins are small"])
    assert warned.level == "with_care"
    assert "the margins are small" in warned.reasons
    failed = {name: replace(item, status=Status.NOT_FINITE) for name, item in result.variants.items()}
    assert simulation_ruling(replace(result, variants=failed))[:2] == ("no", "It does not run")


def test_gain_of_a_law_is_no_compensation(stage):
    result = looped(stage, 20e-6, 4.05e-6, 4e-6)
    assert simulation_ruling(result)[:2] == ("usable", "Another loop helps")


def test_warnings_of_loops_are_short_on_the_first_page():
    small = Diagnostic(
        "small_margin", severity="warning", numbers={"variants": ("a", "b", "c", "d", "e"), "motions": "all", "phase": 15.0, "enough": 30.0}
    )
    assert loop_doubts([small]) == ["the loop has small margins: a, b, c, d and 1 more"]


def test_variants_with_another_motion_are_not_compared_with_the_base(stage):
    result = looped(stage, 20e-6, 19.5e-6, 4e-6)
    *first, last = result.experiment.variants
    other = replace(last, reference=references.sine(amplitude=1e-3, frequency=1.0))
    moved = replace(result, experiment=replace(result.experiment, variants=(*first, other)))
    assert simulation_ruling(result).words == "Compensation helps"
    assert simulation_ruling(moved).level == "with_care"


def test_smallest_unit_of_following_errors_is_the_micrometre(stage):
    table = variant_table(looped(stage, 8e-7, 5e-7, 3e-7))
    assert table.heads[1].endswith("[µm]")
    assert [float(row[1]) for row in table.rows] == pytest.approx([0.8, 0.5, 0.3], abs=2e-3)


def test_drive_table_has_each_unit_once():
    columns = {"position": Column("x", "mm", "m", 1.0), "effort": Column("u", "V", "V", 35.0)}
    axis = Axis(columns=columns)
    heads = drive_rows([(-0.1, -9.0), (0.1, 9.0)], "translational", axis).heads
    assert "Velocity [mm/s]" in heads
    assert "[mm/s]" not in heads
    assert "[V]" in heads


def test_worst_reversal_has_the_largest_swing():
    time = np.linspace(0.0, 10.0, 2001)
    reference = np.abs((time % 4.0) - 2.0)  # turns at 2, 4, 6, 8 s
    error = np.where((time > 5.95) & (time < 6.05), 3e-6, 0.0)
    at = worst_reversal(reference, error)
    assert time[at][0] < 6.0 < time[at][-1]
    assert swing_at_worst_reversal(reference, error) == pytest.approx(3e-6)
    assert worst_reversal(time, error) is None


def predicted(stage, error, **changed):
    metrics = {**stage.predicted.metrics, "force_error_percent": error}
    return replace(stage.predicted, **({"metrics": metrics, "diagnostics": (), "half_width": None} | changed))


@pytest.mark.parametrize(("error", "level"), [(5.0, "usable"), (30.0, "with_care"), (70.0, "no")])
def test_verdict_of_a_prediction_follows_its_error(stage, error, level):
    ruling = prediction_ruling(predicted(stage, error, position_half_width=None))
    assert ruling.level == level
    assert f"{error:.1f}" in ruling.reasons[0]


def test_fitted_log_narrow_band_and_warnings_ask_for_care(stage):
    plain = predicted(stage, 5.0, position_half_width=None)
    assert prediction_ruling(plain, own_log=True).level == "with_care"
    narrow = replace(plain, half_width=np.zeros(plain.time.size))
    assert "inside the 95 % band" in prediction_ruling(narrow).reasons[1]
    warned = replace(plain, diagnostics=(Diagnostic("beyond_speed", severity="warning"),))
    assert prediction_ruling(warned).level == "with_care"
    data = prediction_summary(plain, friction=stage.identified.best.friction, notes=(), provenance={}, own_log=True)
    assert data["verdict"]["level"] == "with_care"


def test_position_error_in_a_loop_is_in_micrometres(stage):
    looped = replace(
        stage.predicted,
        mode="closed-loop",
        metrics={"force_error_percent": 3.0, "force_rmse": 1.5, "position_error_percent": 0.0076, "position_rmse": 1.2e-6},
        position_predicted=stage.predicted.position + 2e-6,
    )
    words = Page(prediction_page(replace(stage, predicted=looped))).words
    assert re.search("Position error, rms ?1.2 µm", words)
    assert "largest position error: 2 µm" in words
    assert "0.0076" not in words


def test_verdict_of_two_logs_follows_the_interval(helped):
    assert comparison_ruling(helped)[:2] == ("usable", "It helped")
    same = compare([log(1, sine(12))], [log(3, sine(12))])
    assert comparison_ruling(same)[:2] == ("with_care", "No clear change")
    worse = compare([log(1, sine(12))], [log(2, sine(12), gain=1.4)])
    assert comparison_ruling(worse)[:2] == ("no", "It did not help")
    blind = compare([log(1, sine(12), reference=None)], [log(2, sine(12), reference=None)])
    assert comparison_ruling(blind).words == "Effect unknown"


def test_first_page_of_two_logs_has_the_interval(helped):
    words = Page(comparison_report(helped, name="stage", **COMMON)).words.partition("Before and after Quantity")[0]
    change = helped.changes["following_error.rms"]
    assert " ".join(length_text(change.after, "translational").split()) in words
    assert re.search("95 %: −[0-9.]+ to −[0-9.]+ %", words)
    assert "keep the change" in words.lower()
    message = comparison_summary(helped, name="stage", provenance={})["verdict"]
    assert message == comparison_ruling(helped).as_data()


@pytest.mark.parametrize(
    ("error", "held_out", "level"),
    [(1.0, 1.2, "usable"), (1.0, 3.0, "with_care"), (1.0, None, "with_care"), (9.0, 9.0, "with_care"), (30.0, 31.0, "no")],
)
def test_verdict_of_an_operator_follows_the_held_out_error(error, held_out, level):
    assert operator_ruling(error, held_out, fitted=True).level == level


def motion(estimates, *, peak=100.0, lag=0.0, truth=None):
    """A rehearsed motion with these estimates."""
    best = Some(name="lugre", estimates=[Some(name=name, status=status, interval_percent=half) for name, status, half in estimates])
    rehearsal = Some(identification=Some(best=best), truth=truth or {}, peak_effort=peak, lag=lag, loop=True)
    kept = Some(effort_limit=500.0, name="stage")
    return Some(rehearsal=rehearsal, exceeded=(), axis=kept, limits=Some(presliding=7e-6), motion=Some(kind="translational"))


@pytest.mark.parametrize(
    ("changed", "level", "reason"),
    [
        ({}, "usable", ""),
        ({"estimates": [("v_S", "identified", 347.0)]}, "with_care", "hardly identified: v_S"),
        ({"estimates": [("F_S", "unidentifiable", None)]}, "with_care", "not identified: F_S"),
        ({"lag": 2e-5}, "with_care", "only within 20\u00a0µm"),
        ({"peak": 600.0}, "no", "limit of the drive"),
        ({"estimates": [("offset", "identified", 484.0)], "truth": {"offset": 0.0}}, "usable", ""),
    ],
)
def test_verdict_of_a_motion_follows_its_rehearsal(changed, level, reason):
    ruling = excitation_ruling(motion(**({"estimates": [("F_C", "identified", 3.0)]} | changed)))
    assert ruling.level == level
    assert reason in " ".join(ruling.reasons)


def test_verdict_of_a_log_follows_its_diagnostics(stage):
    assert log_ruling(stage.log, []).level == "usable"
    assert log_ruling(stage.log, [{"code": "one_speed", "severity": "warning"}]).level == "with_care"
    assert log_ruling(stage.log, [{"code": "sign_reversed", "severity": "error"}]).level == "no"
    assert log_ruling(replace(stage.log, effort=None), []).level == "no"


def pages(stage, helped):
    return {
        "identification": identification_page(stage),
        "simulation": simulation_page(stage),
        "prediction": prediction_page(stage),
        "comparison": comparison_report(helped, name="stage", **COMMON),
        "log": log_report(stage.log, [], name="stage", **COMMON),
        "excitation": excitation_report(excite(STAGE, rehearsed=False), identify="bristle identify LOG", **COMMON),
    }


@pytest.mark.slow
def test_every_first_page_has_date_verdict_and_a_figure(stage, helped):
    for name, text in pages(stage, helped).items():
        first = text.partition('<div class="tabs">')[0]
        page = Page(first)
        assert len([attributes for attributes in page.named("strong") if "pill" in attributes.get("class", "")]) == 1, name
        assert page.named("figure"), name
        assert not Page(text).named("dl"), name
        assert datetime.date.today().isoformat() in page.words, name
        assert "`" not in page.words, name
