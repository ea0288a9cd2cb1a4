"""The report of a loop design, with gains to copy into an experiment file."""

import math
import re
import tomllib
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from tests.apps.design.conftest import loop
from tests.report.known import UNSTABLE, assessed, errors, point
from tests.report.pages import Page, plain, seen_by, without_plots
from tests.report.test_pages import ALL, COMMON, assert_harmless

from bristle import controllers, plants
from bristle.apps.design import (
    Assessment,
    Circle,
    Delays,
    Design,
    Proposal,
    design,
    report as report,
)
from bristle.apps.design.budget import Budget, Entry
from bristle.core import Axis, Experiment, Feedforward, Run
from bristle.files.components import controller_from
from bristle.report.loops import controller_text


@pytest.mark.slow
def test_page_of_a_design_is_self_contained():
    page = report.design_report(
        design(Experiment("bench", "translational", (loop("plain", None), loop()))), **COMMON
    )
    assert not re.search(
        r"https?:|//[a-z]|\bsrc\s*=|@import|url\((?!#)|<script|<link|<iframe", without_plots(page)
    )
    ids = [item["id"] for item in Page(page).named("figure")]
    assert ids == ["figure-loops", "figure-causes", "figure-margins", "figure-circles"]


@pytest.mark.parametrize(
    "law",
    [
        controllers.cascade(k_p=80.0, k_v=4000.0, averaging=2),
        controllers.sliding_mode(
            J=600.0, lambda_=300.0, K_1=200.0, K_2=5e-3, phi=2e-5, estimator="tracking_observer"
        ),
        controllers.disturbance_observer(
            kind="rotational", J=4e-4, lambda_=300.0, K_1=200.0, g=60.0, cutoff=400.0
        ),
    ],
)
def test_law_is_written_as_in_an_experiment_file(law):
    variant = loop(
        plant=plants.inertia(kind=law.kind, M=20.0),
        controller=law,
        feedforward=Feedforward(mass=20.0),
    )
    table = tomllib.loads(controller_text(variant))["controller"]
    assert table.pop("feedforward") == {
        "mass": "20 " + {"translational": "kg", "rotational": "kg*m^2"}[law.kind]
    }
    assert controller_from(table, kind=law.kind, path="controller") == law


@pytest.mark.parametrize(
    ("arm", "at_motor"), [(0.8e-3, " # 0.0032 N*m*s/rad at the motor"), (None, "")]
)
def test_gain_of_a_screw_is_also_given_at_the_motor(arm, at_motor):
    variant = loop(
        controller=controllers.cascade(k_p="120 1/s", k_v="5000 N*s/m"), axis=Axis(arm=arm)
    )
    assert f'k_v = "5000 N*s/m"{at_motor}' in controller_text(variant).splitlines()


@pytest.mark.slow
def test_unstable_loop_is_reported_with_stable_proposals():
    unstable = loop(run=replace(loop().run, delay=9))
    result = design(Experiment("slow", "translational", (unstable,)))
    words = report.design_sentences(result)
    assert report.design_ruling(result)[:2] == ("no", "Do not run it")
    assert "pole at" in words[0]
    assert "nine samples of delay" in words[0]
    page = Page(report.design_report(result, **COMMON))
    assert page.unbalanced == []
    assert "Causes of the error" not in page.words
    assert "with an observer" in page.words


def proposal(name, peak, *, phase=45.0, effort=4.0, count=0.5, **changes):
    known = {
        "variant": loop(name, None),
        "following_error": None if peak is None else errors(peak),
        "assessment": assessed(name, phase),
        "effort_rms": effort,
    }
    return Proposal(
        **known | {"count_effort": count, "stiffness": 5e7, "bandwidth": 300.0} | changes
    )


def budget(*entries, everything=8e-6, nothing=1e-7, runs=1):
    causes = [
        Entry(name, f"the {name}", errors(alone), errors(without))
        for name, alone, without in entries
    ]
    return Budget("plain", errors(everything), errors(nothing), tuple(causes), runs)


ENTRIES = (("friction", 6e-6, 2e-6), ("lag", 7e-6, 5e-6))


def made(*proposals, gain=0.05, switches=False, lag=1e-3, **changes):
    """A loop with its proposals; by default `tuned` has a quarter of the error."""
    proposals = proposals or (
        proposal("as it is", 8e-6),
        proposal("tuned", 2e-6, phase=50.0),
        proposal("with an observer", 4e-6),
    )
    variant = loop("plain", None, run=Run(4.0, 1e-3, delay=1, current_lag=lag))
    known = {
        "proposals": proposals,
        "experiment": Experiment("bench", "translational", (variant,)),
        "variant": variant,
    }
    known |= {"budget": budget(*ENTRIES), "circles": (), "friction": 10.0}
    known |= {
        "assessments": (assessed(gain=gain, switches=switches),),
        "delays": Delays(5e-4, 1e-3, 0.0, 2.5e-4),
    }
    return Design(**known | changes)


@pytest.mark.usefixtures("undrawn")
def test_user_text_is_escaped():
    item = made(assessments=(assessed(ALL),))
    named = replace(
        item, experiment=replace(item.experiment, name=ALL), variant=replace(item.variant, name=ALL)
    )
    assert_harmless(report.design_report(named, **COMMON))


def test_margins_have_a_row_for_each_point_and_equal_loops_once():
    loops = (
        assessed("a", 45.0, None),
        assessed("b", 45.0, None),
        Assessment("c", "translational", (point(30.0, crossover=None),)),
    )
    table = report.margin_table(made(assessments=loops))
    assert table.rows == [
        ("a, b", "all", "none", "0.9500", "45.0", "2.50", "–", "30.0"),
        ("", "all", "none", "0.9500", "–", "2.50", "–", "30.0"),
        ("c", "all", "none", "0.9500", "30.0", "2.50", "–", "–"),
    ]


def test_delay_is_listed_by_parts_in_milliseconds():
    rows = report.delay_table(made()).rows
    assert [row[1] for row in rows] == ["0.500", "1.000", "0.000", "0.250", "1.750"]
    assert rows[-1][0] == "all"


@pytest.mark.parametrize(
    ("nothing", "told"), [(0.39e-6, ""), (0.4e-6, ""), (0.41e-6, "error of the control law")]
)
def test_error_without_causes_is_explained_above_a_twentieth(nothing, told):
    table = report.budget_table(made(budget=budget(*ENTRIES, nothing=nothing)))
    assert table.heads == (
        "Cause",
        "This cause alone [µm]",
        "All but this cause [µm]",
        "Description",
    )
    assert table.rows[:3] == [
        ("friction", "6.000", "2.000", "the friction"),
        ("lag", "7.000", "5.000", "the lag"),
        ("all of them", "8.000", "–", ""),
    ]
    assert table.rows[3][3].startswith(told)
    assert bool(table.rows[3][3]) is bool(told)


def test_proposed_loops_have_their_numbers():
    item = made(
        proposal("as it is", 8e-6),
        proposal("tuned", None, effort=None, stiffness=math.inf, bandwidth=None),
    )
    table = report.proposal_table(item)
    assert table.heads == [
        *(
            "Loop",
            "Law",
            "Bandwidth [1/s]",
            "Smallest phase margin [°]",
            "Stiffness",
            "Effort of one count [mN]",
        ),
        *("Following error, peak to peak [µm]", "Effort, rms [N]"),
    ]
    assert table.rows == [
        ["plain", "cascade", "300", "45.0", "50.0\u00a0N/µm", "500", "8.000", "4.00"],
        ["tuned", "cascade", "–", "45.0", "∞", "500", "–", "–"],
    ]


def test_circles_are_reported_by_their_deviation():
    angle = np.radians([0.0, 10.0, 45.0, 90.0, 100.0, 180.0, 190.0, 270.0, 280.0])
    deviation = 1e-6 * np.array([0.0, 1.0, 8.0, 0.0, 2.0, 0.0, 3.0, 0.0, 4.0])
    table = report.circle_table(made(circles=(Circle("as it is", 0.01, 0.1, angle, deviation),)))
    assert table.heads == [
        "Loop",
        "Deviation, peak to peak [µm]",
        *(f"Glitch at {angle}° [µm]" for angle in (0, 90, 180, 270)),
    ]
    assert table.rows == [["plain", "8.000", "1.000", "2.000", "3.000", "4.000"]]


@pytest.mark.parametrize(
    ("peaks", "gain", "switches", "level", "words"),
    [
        ((8e-6, 2e-6, 4e-6), 0.05, False, "with_care", "Change the gains"),
        ((8e-6, 6.3e-6, None), 0.05, False, "with_care", "Change the gains"),
        ((8e-6, 6.5e-6, None), 0.05, False, "usable", "Keep it"),
        ((8e-6, 6.5e-6, None), 0.05, True, "with_care", "Keep it, with care"),
        ((8e-6, None, None), 0.05, False, "usable", "Keep it"),
        ((None, 9e-6, None), 0.05, False, "with_care", "Change the gains"),
        ((8e-6, 9e-6, None), UNSTABLE, True, "no", "Do not run it"),
    ],
)
def test_loop_is_kept_unless_another_reduces_the_error_by_a_fifth(
    peaks, gain, switches, level, words
):
    loops = [
        proposal(name, peak)
        for name, peak in zip(("as it is", "tuned", "with an observer"), peaks, strict=True)
    ]
    ruling = report.design_ruling(made(*loops, gain=gain, switches=switches))
    assert (ruling.level, ruling.words) == (level, words)
    assert (
        len(ruling.reasons)
        == {
            "Keep it": 2,
            "Keep it, with care": 1,
            "Change the gains": 1 + switches,
            "Do not run it": 2,
        }[words]
    )


def test_reasons_of_a_design_name_error_and_margin():
    assert plain(report.design_ruling(made()).reasons) == [
        "the loop tuned has a following error of 2 µm instead of 8 µm, and keeps the margins"
    ]
    kept = made(proposal("as it is", 8e-6), proposal("tuned", 7e-6))
    assert report.design_ruling(kept).reasons == (
        "phase margin 45.0°",
        "no proposed loop reduces the following error by a fifth or more",
    )
    assert (
        report._margin_text(proposal("a", 1.0, phase=None).assessment.least_phase)
        == "no crossover, so no phase margin"
    )
    unknown = made(proposal("as it is", None), proposal("tuned", 2e-6))
    assert plain(report.design_ruling(unknown).reasons) == [
        "the loop tuned has a following error of 2 µm, and keeps the margins"
    ]


def test_design_has_its_sentences():
    lines = plain(report.design_sentences(made(switches=True)))
    assert lines.pop(1).startswith("The control law chatters around rest")
    assert lines == [
        "plain: the sampled loop is stable: its largest pole is at 0.9500.",
        "The loop has 1.75 ms of delay. As a rule of thumb, the sum of its two bandwidths, such as λ + K_1, may be up to 286 1/s.",
        "The following error is 8 µm peak to peak. The main cause is friction: without it, the error is 2 µm.",
        "The loop tuned has a following error of 2 µm instead of 8 µm, and keeps the margins.",
    ]


def test_unknown_lag_is_reported_with_the_margin_of_the_loop(monkeypatch):
    def told(late):
        monkeypatch.setattr(
            import_module("bristle.apps.design.analysis"), "assess", lambda variant: late
        )
        return report.design_sentences(made(lag=0.0))[2]

    assert "plain has a phase margin of 33.3° with" in told(assessed("late", 33.3))
    assert all(
        "plain is unstable with" in told(late)
        for late in (assessed("late", 33.3, gain=UNSTABLE), assessed("late", None))
    )


@pytest.mark.parametrize(
    ("count", "friction", "much"), [(5.1, 10.0, True), (5.0, 10.0, False), (5.0, 0.0, False)]
)
def test_effort_of_a_count_matters_above_half_of_friction(count, friction, much):
    item = made(proposal("as it is", 8e-6, count=count), proposal("tuned", 7e-6), friction=friction)
    lines = report.design_sentences(item)
    told = "Much of the effort is noise: one encoder count causes an effort of 5.1 N, 0.51 times the friction (10 N)"
    assert [line.startswith(told) for line in lines[2:3]] == [much]
    assert any("Use a finer encoder" in line for line in lines) is much


@pytest.mark.parametrize(("without", "weighs"), [(7.5e-6, True), (7.7e-6, False)])
def test_main_cause_reduces_the_error_by_its_absence(without, weighs):
    line = plain(
        report.design_sentences(
            made(budget=budget(("friction", 6e-6, without), ("lag", 7e-6, 8e-6)))
        )
    )[2]
    assert ("The main cause is" in line) is weighs
    assert (
        "The largest single cause is lag: alone, it makes an error of 7 µm" in line
    ) is not weighs


def test_first_page_of_a_replaced_loop_has_gain_and_cost():
    present, tuned = (
        proposal("as it is", 8e-6),
        proposal("tuned", 2e-6, phase=50.0, effort=6.0, count=0.25),
    )
    front = report._front(made(present, tuned, budget=budget(*ENTRIES, runs=3)))
    assert front.heading == "bench: the loop"
    assert front.title.replace("\u00a0", " ") == "Gains tuned: 8 → 2 µm peak to peak, ×4.0"
    assert plain([card.value for card in front.cards]) == ["2 µm", "friction", "50.0°", "6 N"]
    assert plain([card.remark for card in front.cards]) == [
        "",
        "without it 2 µm",
        "now 45.0°",
        "one count 250 mN",
    ]
    assert front.next.command == "bristle run EXPERIMENT.toml"
    assert front.facts.endswith("variant plain · law cascade")


def test_first_page_of_a_kept_loop_has_no_comparison():
    front = report._front(made(proposal("as it is", 8e-6), proposal("tuned", 7e-6)))
    assert front.title == "Phase margin 45.0°"
    assert plain([card.remark for card in front.cards][2:]) == [
        "usual least 30°",
        "one count 500 mN",
    ]
    assert front.next.command == "bristle compare before.csv after.csv --axis axis.toml"
    assert (
        report._front(made(proposal("as it is", None), budget=None, gain=UNSTABLE)).title
        == "The present loop is unstable"
    )


@pytest.mark.parametrize(("runs", "words"), [(1, "one run each."), (3, "3 runs each.")])
def test_page_of_a_design_has_the_values_of_the_recommended_loop_and_its_runs(
    monkeypatch, runs, words
):
    seen = seen_by(monkeypatch, report)
    monkeypatch.setattr(report, "law_lines", lambda variant, claims: [variant.name, *claims])
    monkeypatch.setattr(report, "promise_of_law", lambda variant: ["promised"])
    report.design_report(made(budget=budget(*ENTRIES, runs=runs)))
    gains, causes, *_ = seen["sections"]
    assert gains.blocks[2:4] == [
        "The values of the loop tuned:",
        report.Block("items", ["tuned", "promised"]),
    ]
    assert causes.blocks[0].endswith(words)
    report.design_report(made(proposal("as it is", 8e-6), budget=None))
    assert seen["sections"][0].blocks[2] == "The values of the loop plain:"
    assert seen["sections"][1].blocks == []


def test_summary_of_a_design_has_its_numbers():
    summary = report.design_summary(made(budget=budget(*ENTRIES, runs=3)), provenance={})
    parts = {"hold": 5e-4, "computation": 1e-3, "drive": 0.0, "velocity": 2.5e-4}
    assert summary["delay"] == parts | {"total": pytest.approx(1.75e-3)}
    assert (summary["stable"], summary["variant"]) == (True, "plain")
    assert summary["budget"]["causes"]["lag"]["alone"]["peak_to_peak"] == 7e-6
    assert (summary["budget"]["runs"], summary["budget"]["nothing"]["peak_to_peak"]) == (3, 1e-7)
    assert list(summary["proposals"]) == ["as it is", "tuned", "with an observer"]
    assert summary["proposals"]["tuned"]["following_error"]["peak_to_peak"] == 2e-6
    assert summary["loops"]["plain"]["verdict"] == "stable"
    assert summary["loops"]["plain"]["points"][0]["poles"] == [[pytest.approx(0.95), 0.0]]
    assert report.design_summary(made(budget=None), provenance={})["budget"] is None
