"""The report of a motion to run: pieces, expected results, demands and verdict."""

import math
from dataclasses import replace
from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_log
from tests.report.pages import seen_by

import bristle.prediction.excitation
from bristle.core import Axis, InputError
from bristle.identification import identify
from bristle.models.friction import lugre
from bristle.prediction.excitation.excite import Excitation
from bristle.report import excitation as report
from bristle.report.next_motion import is_open, next_motion


def piece(purpose, name, amplitude, speed, duration=2.0):
    return Some(
        purpose=purpose,
        name=name,
        amplitude=amplitude,
        speed=speed,
        duration=duration,
        reference=Some(name="ramp"),
    )


def estimate(name, value, status="identified", half=5.0):
    return Some(
        name=name,
        value=value,
        unit="N",
        description="level",
        status=status,
        interval_percent=half,
        reason=None,
    )


ESTIMATES = (
    estimate("a", 5.0),
    estimate("b", 5.5, half=7.0),
    estimate("c", 1.0, half=150.0),
    estimate("d", 1.0, "unidentifiable", None),
    estimate("e", 9.0, "held"),
    estimate("f", 3.0, half=None),
)
# Of other strokes than any log here.
OTHER = log_of(sines(1.0, amplitudes=(1e-4, 0.0, 0.0)), np.zeros(1000), step=1e-7)
TRUTH = {"a": 5.0, "b": 5.0, "c": 1.0, "d": 2.0, "f": 0.0}


def motion():
    pieces = [
        piece("presliding", "loops", -1e-6, 1e-4),
        piece("presliding", "loops", 2e-6, 2e-4),
        piece("stribeck", "slides", 0.1, 0.05, 3.0),
    ]
    signals = {
        "position": np.array([-0.01, 0.05]),
        "velocity": np.array([-0.2, 0.1]),
        "acceleration": np.array([1.0, -3.0]),
    }
    return Some(
        kind="translational",
        pieces=pieces,
        begins=(0.0, 2.0, 4.0),
        duration=7.0,
        time=np.arange(8),
        sample_time=1e-3,
        start=0.0,
        **signals,
    )


def excited(
    estimates=ESTIMATES,
    *,
    truth=TRUTH,
    rehearsed=True,
    limit=None,
    error_limit=None,
    presliding=None,
    assumed=("M",),
    exceeded=(),
    **changes,
):
    best = Some(name="lugre", estimates=estimates, diagnostics=())
    known = {
        "truth": truth,
        "peak_effort": 8.0,
        "lag": 1e-6,
        "following_error": 2e-5,
        "loop": True,
        "friction": np.zeros(2),
    }
    rehearsal = (
        Some(log=None, identification=Some(best=best, sweep=None), **known | changes)
        if rehearsed
        else None
    )
    limits = Some(travel=0.1, velocity=None, acceleration=5.0, presliding=presliding)
    prior = Some(assumed=assumed, friction=Some(name="dahl"))
    axis = Some(name="stage", effort_limit=limit, following_error_limit=error_limit)
    return Excitation(motion(), axis, limits, prior, ("a note",), rehearsal, exceeded)


def test_equal_pieces_share_a_row():
    table = report.piece_table(excited())
    assert table.rows == [
        ("presliding", "loops", "2", "0.0 to 4.0", "1 µm to 2 µm", "100 µm/s to 200 µm/s"),
        ("stribeck", "slides", "1", "4.0 to 7.0", "100 mm", "50 mm/s"),
    ]


def test_expected_results_have_found_and_true_values():
    table = report.outlook_table(excited())
    assert table.caption == "Expected results, by a fit of lugre"
    rows = {row[0]: dict(zip(table.heads, row, strict=True)) for row in table.rows}
    assert list(rows) == ["a", "b", "c", "d", "f"]
    assert rows["a"] == {
        "Parameter": "a",
        "Meaning": "level",
        "True value": "5.000",
        "Identified": "5.000",
        "Unit": "N",
        "Error [%]": "0",
        "95 % interval [%]": "± 5.0",
        "Remark": "",
    }
    assert (rows["b"]["Error [%]"], rows["b"]["Remark"]) == (
        "10",
        "true value outside the interval",
    )
    assert (rows["d"]["Remark"], rows["d"]["95 % interval [%]"], rows["d"]["Error [%]"]) == (
        "not identified",
        "–",
        "",
    )
    assert [rows[name]["Identified"] for name in "cd"] == ["not identified"] * 2
    assert (rows["f"]["True value"], rows["f"]["Error [%]"], rows["f"]["95 % interval [%]"]) == (
        "0",
        "",
        "–",
    )
    unknown = report.outlook_table(excited((estimate("a", 5.0, half=math.inf),), truth={}))
    assert not {"True value", "95 % interval [%]"} & set(unknown.heads)


@pytest.mark.parametrize(
    ("value", "put_in", "unit"),
    [
        (0.0, 3e-3, "mN"),
        (0.0, 3.0, "N"),
        (0.0, 0.0, "N"),
        (0.0, None, "N"),
        (4e-3, 3.0, "mN"),
        (4.0, 3e-3, "N"),
    ],
)
def test_unit_follows_the_true_value_if_the_found_value_is_zero(value, put_in, unit):
    table = report.outlook_table(
        excited((estimate("a", value, half=None),), truth={} if put_in is None else {"a": put_in})
    )
    assert dict(zip(table.heads, table.rows[0], strict=True))["Unit"] == unit


@pytest.mark.parametrize(
    ("judged", "given", "result"),
    [
        # Errors up to two percent outside the interval are ignored.
        (report._misses, (estimate("a", 5.34), 5.0), False),
        (report._misses, (estimate("a", 5.36), 5.0), True),
        (report._misses, (estimate("a", 4.64), 5.0), True),
        (report._misses, (estimate("a", 9.0, half=None), 5.0), False),
        (report._misses, (estimate("a", 9.0, "at_edge"), 5.0), False),
        # An error is in percent of the true value.
        (report._error, (estimate("a", 6.0), 5.0), pytest.approx(20.0)),
        (report._error, (estimate("a", 6.0), None), None),
        (report._error, (estimate("a", 6.0), 0.0), None),
        (report._error, (estimate("a", 6.0), math.inf), None),
        # Limits belong to the motion.
        (
            report._limits,
            (excited(),),
            [
                ("travel", pytest.approx(0.06), 0.1, "m"),
                ("velocity", pytest.approx(0.2), None, "m/s"),
                ("acceleration", pytest.approx(3.0), 5.0, "m/s^2"),
            ],
        ),
    ],
)
def test_errors_and_limits_of_a_motion(judged, given, result):
    assert judged(*given) == result


def test_reasons_against_a_motion_name_the_parameters():
    ruling = report.excitation_ruling(excited(presliding=5e-7))
    assert [reason.replace("\u00a0", " ") for reason in ruling.reasons] == [
        "not identified: d",
        "hardly identified: c",
        "biased: b",
        "raise the gains for this motion: the controller follows the pre-sliding loops only within 1 µm",
    ]
    # An interval around a true value of zero may be as wide as it is.
    assert (
        report.excitation_ruling(
            excited((estimate("a", 5.0), estimate("f", 3.0, half=484.0)))
        ).reasons
        == ()
    )
    edge = report.excitation_ruling(
        excited((estimate("a", 5.0, "at_edge"), estimate("b", 5.0, half=100.0)))
    )
    assert edge.reasons == ("not identified: a", "hardly identified: b")


@pytest.mark.parametrize(
    ("changes", "level", "words"),
    [
        ({}, "usable", "Run it"),
        ({"limit": 8.0}, "usable", "Run it"),
        ({"limit": 7.9}, "no", "Do not run it"),
        ({"presliding": 1e-6}, "usable", "Run it"),
        ({"presliding": 0.9e-6}, "with_care", "Run it, with care"),
        ({"rehearsed": False}, "with_care", "Run it, with care"),
        ({"exceeded": ("following error",)}, "no", "Do not run it"),
        ({"exceeded": ("effort",)}, "no", "Do not run it"),
        ({"exceeded": ("following error",), "rehearsed": False}, "no", "Do not run it"),
    ],
)
def test_motion_is_run_unless_drive_or_controller_is_at_its_limit(changes, level, words):
    assert report.excitation_ruling(excited(ESTIMATES[:1], **changes))[:2] == (level, words)


@pytest.mark.parametrize(
    ("log", "is_repeat", "level", "words", "logs"),
    [
        (
            (2.0, 3.0),
            False,
            "no",
            "no motion within the limits is better than the log at hand: a ± 5.0 % against ± 2.0 %, b ± 7.0 % against",
            "at.csv",
        ),
        (
            (2.0, 99.0),
            False,
            "with_care",
            "biased: b identify both logs together, because the log at hand is better for some parameters: a",
            "LOG at.csv",
        ),
        ((50.0, 99.0), False, "with_care", "biased: b", "LOG"),
        # No more than the scatter of half-widths.
        ((7.0, 8.0), False, "no", "no motion within the limits is better", "at.csv"),
        (
            (50.0, 99.0),
            True,
            "no",
            "no motion within the limits is better than the log at hand: a ± 50 % against ± 50 %",
            "at.csv",
        ),
    ],
)
def test_a_motion_is_compared_with_the_log_at_hand(monkeypatch, log, is_repeat, level, words, logs):
    monkeypatch.setitem(Excitation.is_worse.fget.__globals__, "holds", lambda *logs: is_repeat)
    known = Some(
        log=None,
        best=Some(
            estimates=[estimate(name, 5.0, half=half) for name, half in zip("ab", log, strict=True)]
        ),
    )
    found = replace(excited(ESTIMATES[:2]), earlier=known)
    ruling = report.excitation_ruling(found)
    assert (ruling.level, " ".join(ruling.reasons)[: len(words)]) == (level, words)
    command = report.DesignedMotion(found, None, None, "x", Some(source="at.csv")).next_command(
        "axis.toml"
    )
    assert command.startswith(f"bristle identify {logs} --axis")
    assert (
        report._front(found, command)
        .next[0]
        .startswith("Run motion.csv" if "LOG" in logs else "Identify the log at hand")
    )


def test_each_exceeded_limit_is_a_reason_against_a_motion():
    both = report.excitation_ruling(
        excited(ESTIMATES[:1], exceeded=("effort", "following error"), limit=7.9)
    )
    assert both.reasons == (
        "the effort exceeds the limit of the drive",
        "the following error exceeds the limit of the axis",
    )


def test_first_page_of_a_motion_lists_identifiable_parameters():
    front = report._front(excited(limit=20.0), "bristle identify LOG")
    assert (front.heading, front.title) == (
        "stage: a motion to run",
        "Determines 2 of 5 parameters",
    )
    assert front.facts.endswith("7 s")
    assert [(card.value.replace("\u00a0", " "), card.half) for card in front.cards] == [
        ("5.00 N", 5.0),
        ("5.50 N", 7.0),
        ("60 mm", None),
        ("200 mm/s", None),
    ]
    assert front.next.command == "bristle identify LOG"


def test_motion_without_rehearsal_has_no_expected_results():
    front = report._front(excited(rehearsed=False, assumed=()), "bristle identify LOG")
    assert (front.title, front.basis, front.ruling.reasons) == (
        "A motion of 7 s",
        "(not rehearsed)",
        ("the motion was not rehearsed",),
    )
    assert [card.label for card in front.cards] == ["Travel", "Velocity"]


def test_summary_of_a_motion_has_its_numbers():
    summary = report.excitation_summary(
        excited(), files={"motion": "motion.csv"}, identify="x", provenance={}
    )
    assert [
        summary["motion"][key] for key in ("travel", "velocity_max", "acceleration_max")
    ] == pytest.approx([0.06, 0.2, 3.0])
    assert (summary["motion"]["samples"], summary["motion"]["units"]["force"]) == (8, "N")
    assert [(item["begin"], item["reference"]) for item in summary["pieces"]] == [
        (0.0, "ramp"),
        (2.0, "ramp"),
        (4.0, "ramp"),
    ]
    found = summary["parameters"]["b"]
    assert (found["error_percent"], found["put_in"]) == pytest.approx((10.0, 5.0))
    assert (summary["model"], summary["peak_effort"], summary["following_error"]) == (
        "lugre",
        8.0,
        2e-5,
    )
    assert (
        report.excitation_summary(excited(loop=False), files={}, identify="x", provenance={})[
            "following_error"
        ]
        is None
    )
    bare = report.excitation_summary(
        excited(rehearsed=False), files={}, identify="x", provenance={}
    )
    assert (bare["parameters"], bare["diagnostics"], "model" in bare) == ({}, [], False)


@pytest.mark.parametrize(
    ("rehearsed", "name", "loops", "models"),
    [
        (True, "lugre", True, "lugre,maxwell_slip"),
        (True, "maxwell_slip", True, "maxwell_slip"),
        (False, "", True, "dahl,maxwell_slip"),
        (True, "lugre", False, "lugre"),
    ],
)
def test_pre_sliding_loops_are_also_fitted_by_elements(rehearsed, name, loops, models):
    excitation = excited(rehearsed=rehearsed)
    if rehearsed:
        excitation.rehearsal.identification.best.name = name
    if not loops:
        excitation.motion.pieces = excitation.motion.pieces[2:]
    command = report.DesignedMotion(excitation, None, None, "x").next_command("my axis.toml")
    assert command == f"bristle identify LOG --axis 'my axis.toml' --model {models} --out results"


def test_page_of_a_motion_has_the_demands_on_the_axis(monkeypatch):
    seen = seen_by(monkeypatch, report)
    report.excitation_report(excited(limit=20.0), identify="x")
    motion_, outlook, assumptions = seen["sections"]
    files, purposes, _, takes = motion_.blocks
    assert all(f"`{name}`" in files for name in ("motion.csv", "moves.csv", "motion.nc"))
    assert [name for name, _ in purposes.content] == ["presliding", "stribeck"]
    assert takes.content == [
        ("Travel", "60 mm of 100 mm allowed"),
        ("Velocity", "200 mm/s"),
        ("Acceleration", "3 m/s² of 5 m/s² allowed"),
        ("Effort by the assumed model", "8 N of 20 N allowed"),
        ("Following error in the loop", "20 µm"),
    ]
    basis = "One rehearsal, {}. Its encoder is that of the axis, and its friction scatters by 5 %."
    assert outlook.blocks[0] == basis.format("in the loop of its controller")
    assert outlook.blocks[1].rows
    assert (assumptions.blocks[0].content, seen["expected"].size) == (("a note",), 2)
    report.excitation_report(excited(error_limit=1e-4), identify="x")
    assert seen["sections"][0].blocks[3].content[-1] == (
        "Following error in the loop",
        "20 µm of 100 µm allowed",
    )
    report.excitation_report(excited(loop=False), identify="x")
    assert seen["sections"][1].blocks[0] == basis.format("along the motion, without a stable loop")
    assert seen["sections"][0].blocks[3].content[-1] == ("Effort by the assumed model", "8 N")
    report.excitation_report(excited(rehearsed=False), identify="x")
    assert (
        seen["expected"],
        seen["sections"][1].blocks,
        len(seen["sections"][0].blocks[3].content),
    ) == (None, [""], 3)


# --- The motion to record next: which of the motions that `excite` designs narrows open intervals, and by how much


@pytest.fixture(scope="module")
def fit():
    return identify(sliding_log(), "stribeck", axis=STATED, blocks=0, draws=0).best


def opened(fit, **statuses):
    """The same fit, in which these parameters matter and have this status; all others are identified."""
    changed = [
        replace(
            estimate,
            status=statuses.get(estimate.name, "identified"),
            effect=1.0 if estimate.name in statuses else 0.0,
        )
        for estimate in fit.estimates
    ]
    return replace(fit, estimates=tuple(changed))


def rehearsals(monkeypatch, fit, widths, off=1.0, exceeded=(), log=OTHER):
    """Stand in for `excite`: by purposes, the half-width in percent that a rehearsal gives each parameter."""
    asked = []

    def excite(axis, *, model, purposes, duration, travel, draws):
        asked.append((purposes, axis, travel))
        if purposes not in widths:
            raise InputError("cannot be planned", path="purposes")
        found = [
            replace(
                estimate,
                status="identified",
                interval=tuple(
                    off
                    * estimate.value
                    * (1.0 + side * widths[purposes].get(estimate.name, 200.0) / 100.0)
                    for side in (-1.0, 1.0)
                ),
            )
            for estimate in fit.estimates
        ]
        return Some(
            rehearsal=Some(identification=Some(best=Some(estimates=found)), log=log),
            exceeded=exceeded,
        )

    monkeypatch.setattr(bristle.prediction.excitation, "excite", excite)
    return asked


def test_a_parameter_that_does_not_matter_or_is_known_is_not_open(fit):
    value = fit.parameters["F_S"].value
    known = replace(
        fit.parameters["F_S"], status="identified", effect=1.0, interval=(0.9 * value, 1.1 * value)
    )
    changes = (
        {},
        {"status": "unidentifiable"},
        {"status": "unidentifiable", "effect": 0.0},
        {"interval": (0.5 * value, 1.5 * value)},
    )
    assert [is_open(replace(known, **change)) for change in changes] == [False, True, False, True]


def test_a_fit_without_open_intervals_asks_for_no_motion(fit, monkeypatch):
    asked = rehearsals(monkeypatch, fit, {})
    assert next_motion(opened(fit), Axis(), sliding_log()) is None
    assert asked == []


def test_the_motion_names_the_half_widths_that_its_rehearsal_gives(fit, monkeypatch):
    rehearsals(monkeypatch, fit, {"stribeck": {"F_S": 4.0, "v_S": 90.0}})
    motion = next_motion(
        opened(fit, F_S="unidentifiable", v_S="unidentifiable"), Axis(), sliding_log()
    )
    assert (motion.purposes, motion.text) == ("stribeck", "F_S open → ± 4.0 %")
    assert motion.half_widths["F_S"][1] == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("widths", "how"),
    [
        # The interval of the rehearsal misses its own truth.
        ({"stribeck": {"F_S": 4.0}}, {"off": 1.1}),
        ({"stribeck": {"F_S": 4.0}}, {"exceeded": ("effort",)}),  # beyond the limits of the axis
        ({}, {}),  # the axis does not allow it
        ({"stribeck": {"F_S": 4.0}}, {"log": sliding_log()}),  # the log already holds it
    ],
)
def test_a_motion_that_promises_nothing_is_not_proposed(fit, monkeypatch, widths, how):
    rehearsals(monkeypatch, fit, widths, **how)
    assert next_motion(opened(fit, F_S="unidentifiable"), Axis(), sliding_log()) is None


def test_the_motion_that_narrows_more_intervals_is_proposed(fit, monkeypatch):
    fit = replace(fit, friction=lugre(F_C=20.0, F_S=30.0, v_S=4e-3, sigma_0=1e6))
    fit = replace(
        fit,
        estimates=tuple(
            replace(fit.parameters["F_S"], name=name) for name in ("F_S", "sigma_0", "sigma_1")
        ),
    )
    unknown = opened(fit, F_S="unidentifiable", sigma_0="unidentifiable", sigma_1="unidentifiable")
    gentle, slow = "presliding,break-away,damping", "stribeck"
    for better, worse in ((gentle, slow), (slow, gentle)):
        asked = rehearsals(
            monkeypatch, fit, {better: {"F_S": 4.0, "sigma_0": 9.0}, worse: {"sigma_1": 2.0}}
        )
        assert next_motion(unknown, Axis(), sliding_log()).purposes == better
        assert {purposes for purposes, *_ in asked} == {gentle, slow}


def test_an_axis_without_limits_gets_those_of_its_log(fit, monkeypatch):
    asked = rehearsals(monkeypatch, fit, {"stribeck": {"F_S": 4.0}})
    motion = next_motion(
        opened(fit, F_S="unidentifiable"), Axis(acceleration_limit=3.0), sliding_log()
    )
    ((_, axis, travel),) = asked
    assert axis.velocity_limit == pytest.approx(np.max(np.abs(fit.traces.velocity)), rel=0.05)
    assert axis.acceleration_limit == 3.0
    assert motion.limits == (f'velocity = "{axis.velocity_limit:g} m/s"',)
    assert motion.options[-1] == travel


@pytest.mark.slow
def test_slow_motion_is_proposed_where_the_fall_of_friction_is_open():
    motion = sines(10.0, amplitudes=(0.02, 0.0, 0.0))
    level = 20.0 + 10.0 * np.exp(-((motion.velocity / 0.004) ** 2))
    effort = (
        12.0 * motion.acceleration
        + np.where(motion.velocity < 0.0, -level, level)
        + 40.0 * motion.velocity
    )
    log = log_of(
        motion, effort + np.random.default_rng(0).normal(0.0, 1.0, motion.time.size), step=1e-7
    )
    axis = Axis(resolution=1e-7, method="inverse_dynamics")
    best = identify(log, "lugre", axis=axis, draws=20).best
    found = next_motion(best, axis, log)
    assert found.purposes == "stribeck"
    assert found.half_widths["F_S"][1] < 10.0
