"""The report of a simulation."""

import math
from dataclasses import replace
from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.apps.design.conftest import loop
from tests.report.known import UNSTABLE, assessed, errors
from tests.report.pages import Page, seen_by
from tests.report.test_pages import simulation_page
from tests.stand_ins import Loop

from bristle import controllers, friction
from bristle.core import Axis, Diagnostic, Feedforward, Status, number, units
from bristle.prediction import Claim
from bristle.report import compensation, loops as loops_module, simulation as report
from bristle.report.sentences import SENTENCES

pytestmark = pytest.mark.usefixtures("undrawn")


def test_table_of_variants_has_their_numbers(workbench):
    table = loops_module.variant_table(workbench.looped)
    unit = table.heads[1].split("[")[1].rstrip("]")
    si = {"translational": "m", "rotational": "rad"}[workbench.axis.kind]
    for row, variant in zip(table.rows, workbench.looped.variants.values(), strict=True):
        assert row[0] == variant.name
        assert units.convert(f"{row[1]} {unit}", si) == pytest.approx(
            variant.following_error.peak_to_peak, rel=0.01
        )


def test_diverged_loop_has_a_remark(stage):
    failed = replace(stage.looped.variants["compensated"], status=Status.NOT_FINITE)
    result = replace(stage.looped, variants={**stage.looped.variants, "compensated": failed})
    assert (
        f"compensated: {Status.NOT_FINITE.sentence}"
        in Page(simulation_page(stage, result=result)).words
    )


def test_page_exists_if_every_loop_diverged(stage):
    failed = {
        name: replace(item, status=Status.NOT_FINITE)
        for name, item in stage.looped.variants.items()
    }
    page = Page(simulation_page(stage, result=replace(stage.looped, variants=failed)))
    assert (page.unbalanced, page.named("figure"), "Forward and backward" in page.words) == (
        [],
        [],
        False,
    )


def test_every_part_of_the_loop_is_named(stage):
    words = Page(simulation_page(stage)).words
    assert all(
        part in words
        for part in ("inertia", "stribeck", "cascade", "encoder", "recorded", "6000 values")
    )


def ran(name, peak=2e-6, *, status=Status.OK, is_open=False, runs=1, spread=0.0, effort=2.0):
    time = 1e-3 * np.arange(400)
    reference = np.abs((time % 0.2) - 0.1)
    measured = reference - peak * (np.abs(time - 0.3) < 2e-3) - 1e-3 * (time < 0.05)
    scatter = {"following_error": {"peak_to_peak": spread}} if spread else {}
    numbers = {
        "following_error": errors(peak, 0.25 * peak),
        "motion": errors(peak),
        "effort_rms": effort,
        "effort_peak": 2.0 * effort,
    }
    about = {
        "name": name,
        "kind": "translational",
        "status": status,
        "is_open": is_open,
        "runs": runs,
        "spread": scatter,
    }
    return Loop(reference=reference, measured=measured, **numbers, **about)


def simulated(*loops, refused=(), effort=None, limit=math.inf):
    run = Some(settle=0.1, sample_time=1e-3, effort_limit=limit)
    fed = Some(plant=None, friction=None, mass=0.0)
    law = Some(name="cascade", values={})
    known = {
        "run": run,
        "feedforward": fed,
        "controller": law,
        "reference": 1,
        "effort": effort,
        "disturbance": None,
        "friction": None,
    }
    variants = [Some(name=loop.name, **known) for loop in loops]
    experiment = Some(name="bench", kind="translational", variants=variants)
    return Some(
        experiment=experiment,
        variants={loop.name: loop for loop in loops},
        refused=dict.fromkeys(refused, "unstable"),
        unstable=(),
    )


def values_of(result):
    return [
        line.replace("\u00a0", " ")
        for line in report._values_of(result, compensation.standing(result).best, ())
    ]


LOOPS = ran("base", 8e-6), ran("best", 2e-6, runs=3, spread=1e-7, effort=3.0)
SCATTER = "3 runs with different noise: standard deviation 0.100 µm"


@pytest.mark.parametrize(
    ("result", "lines"),
    [
        (simulated(*LOOPS), ["best: law cascade: ", SCATTER]),
        (
            simulated(*LOOPS, limit=6.0),
            ["best: law cascade: ", "the drive is at its limit", SCATTER],
        ),
        (simulated(ran("base", 8e-6), limit=4.1), ["base: law cascade: "]),
        (simulated(ran("base", 8e-6, runs=2)), ["base: law cascade: "]),
    ],
)
def test_results_have_the_law_of_the_best_variant_its_limit_and_its_scatter(result, lines):
    assert values_of(result) == lines


def test_first_page_compares_the_best_loop_with_the_base():
    front = report._front(simulated(*LOOPS, refused=["wild"]), ())
    assert front.facts.endswith("3 variants · mean of 3 runs")
    assert (front.heading, front.title) == (
        "bench: simulated",
        "Following error: 8 → 2\u00a0µm peak to peak, ×4.0",
    )
    assert [(card.label, card.value.replace("\u00a0", " ")) for card in front.cards] == [
        ("Error, peak to peak", "2 µm"),
        ("Error, rms", "0.500 µm"),
        ("Worst reversal", "2 µm"),
        ("Effort, rms", "3 N"),
    ]
    assert front.cards[0].half == pytest.approx(100.0 * 1.96 * 1e-7 / 3**0.5 / 2e-6, rel=1e-3)
    command = "bristle compare before.csv after.csv --axis axis.toml"
    assert front.next == ("Record the machine without and with compensation", command)


def test_first_page_of_a_single_loop_has_no_comparison():
    front = report._front(simulated(ran("base", 8e-6), limit=4.0), ())
    assert front.facts.endswith("1 variant")
    cards = {
        card.label: (card.value.replace("\u00a0", " "), card.remark.replace("\u00a0", " "))
        for card in front.cards
    }
    assert (cards["Worst reversal"], cards["Effort, rms"]) == (("8 µm", ""), ("2 N", "peak 4 N"))
    assert front.next == ("Find better gains", "bristle design EXPERIMENT.toml")


def test_first_page_of_open_loops_has_their_motion():
    loops = ran("a", 8e-3, is_open=True), ran("b", 1.0, status=Status.NOT_FINITE, is_open=True)
    front = report._front(simulated(*loops, effort=1), ())
    assert front.title.replace("\u00a0", " ") == "The open loop moves by 8 mm"
    assert [(card.label, card.value.replace("\u00a0", " ")) for card in front.cards] == [
        ("Effort, a", "2 N")
    ]
    assert (front.ruling.words, front.next) == ("No loop: the effort is given", None)
    failed = report._front(simulated(ran("a", status=Status.NOT_FINITE)), ())
    assert (failed.title, failed.next, failed.cards) == ("No variant completed", None, [])


@pytest.mark.parametrize(
    ("loops", "options", "warnings", "level", "words", "reasons"),
    [
        ([ran("a")], {}, (), "usable", "It runs, but there is no second loop to compare", 0),
        (
            [ran("a")],
            {"refused": ["b"]},
            (),
            "with_care",
            "It runs, but there is no second loop to compare",
            1,
        ),
        (
            [ran("a")],
            {},
            ("b: unstable",),
            "with_care",
            "It runs, but there is no second loop to compare",
            1,
        ),
        (
            [ran("a")],
            {"refused": ["b"]},
            ("b: unstable",),
            "with_care",
            "It runs, but there is no second loop to compare",
            1,
        ),
        (
            [ran("base", status=Status.NOT_FINITE), ran("a")],
            {},
            (),
            "with_care",
            "The present loop does not run: no comparison",
            1,
        ),
        ([ran("base", 2e-6), ran("a", 8e-6)], {}, (), "no", "Another loop does not help", 1),
        ([ran("base", 8e-6), ran("a", 2e-6)], {}, (), "usable", "Another loop helps", 1),
        (
            [ran("base", 8e-6), ran("a", 7.9e-6)],
            {},
            (),
            "with_care",
            "Another loop hardly helps",
            1,
        ),
        ([ran("a", status=Status.NOT_FINITE)], {}, (), "no", "It does not run", 1),
        ([ran("a", is_open=True)], {"effort": 1}, (), "usable", "No loop: the effort is given", 0),
    ],
)
def test_verdict_of_a_run_uses_the_completed_loops(loops, options, warnings, level, words, reasons):
    ruling = report.simulation_ruling(simulated(*loops, **options), warnings)
    assert (ruling.level, ruling.words, len(ruling.reasons)) == (level, words, reasons)


def test_swing_excludes_the_settling_time():
    result = simulated(ran("base", 8e-6))
    assert report._swing(result, result.variants["base"]) == pytest.approx(8e-6)
    short = result.variants["base"]
    short.reference, short.measured = short.reference[:50], short.measured[:50]
    assert report._swing(result, short) is None


def test_summary_of_a_run_has_its_numbers():
    loops = [ran("a", runs=3), ran("b", runs=2, status=Status.NOT_FINITE)]
    for item in loops:
        item.as_dict = dict
    summary = report.simulation_summary(
        simulated(*loops, refused=["c"]),
        files={"a": "log.csv"},
        provenance={},
        claims=[Claim(1e-3, None, 0.3, 1.5)],
    )
    assert (
        summary["name"],
        summary["kind"],
        summary["runs"],
        summary["error_unit"],
        summary["effort_unit"],
        summary["claims"],
    ) == (
        *("bench", "translational", 3),
        *(
            "m",
            "N",
            [{"least_distance": 1e-3, "slowest_move": None, "longest_rest": 0.3, "factor": 1.5}],
        ),
    )
    assert {name: item["completed"] for name, item in summary["variants"].items()} == {
        "a": True,
        "b": False,
        "c": False,
    }
    assert summary["variants"]["c"] == {"status": "unstable", "completed": False, "runs": 0}
    assert report.simulation_summary(simulated(refused=["c"]), files={}, provenance={})["runs"] == 0


@pytest.mark.parametrize("is_open", [True, False])
def test_page_of_a_run_lists_the_simulated_parts(monkeypatch, is_open):
    seen = seen_by(monkeypatch, report)
    for name in ("variant_table", "run_table", "parts_table", "direction_table"):
        monkeypatch.setattr(report, name, lambda *_, name=name: name)
    effort = Some(description="a sine") if is_open else None
    report.simulation_report(
        simulated(
            ran("base", 8e-6, is_open=is_open), ran("best", 2e-6, is_open=is_open), effort=effort
        ),
        warnings=["small"],
    )
    variants, summary, directions, assumptions = seen["sections"]
    assert variants.heading == ("Motions and efforts" if is_open else "Errors and efforts")
    assert (summary.blocks[0], summary.blocks[-1] is None) == ("small.", is_open)
    assert directions.blocks == [None if is_open else "direction_table"]
    assert assumptions.blocks[3 if is_open else 1 :] == ["run_table", "parts_table", "parts_table"]
    at_reversal, focus = (None, None) if is_open else (["base", "best"], ())
    assert (seen["open_loop"] is None, seen["focus"], seen.get("at_reversal")) == (
        not is_open,
        focus,
        at_reversal,
    )


# --- Tables and sentences of loops: errors in a common unit, parts with values, gains in units of the drive


def looped(name, peak, *, status=Status.OK, is_open=False):
    by_direction = {
        "forward": errors(0.5 * peak, 0.25 * peak, 1e-7),
        "backward": errors(0.25 * peak, 0.125 * peak, -1e-7),
    }
    return Some(
        name=name,
        status=status,
        is_open=is_open,
        following_error=errors(peak, 0.25 * peak, -1e-7),
        true_error=errors(2.0 * peak),
        motion=errors(peak),
        effort_rms=2.0,
        effort_peak=5.0,
        by_direction=by_direction,
    )


def result(*variants, kind="translational"):
    return Some(
        variants={variant.name: variant for variant in variants}, experiment=Some(kind=kind)
    )


def test_errors_of_loops_have_the_unit_of_the_smallest():
    table = loops_module.variant_table(result(looped("a", 8e-3), looped("b", 4e-6)))
    assert table.heads == [
        "Variant",
        "Following error, peak to peak [µm]",
        "rms [µm]",
        "mean [µm]",
        "True error, peak to peak [µm]",
        "Force, rms [N]",
        "peak [N]",
    ]
    assert table.rows == [
        ["a", "8000.00", "2000.00", "−0.10", "16000.00", "2.00", "5.00"],
        ["b", "4.00", "1.00", "−0.10", "8.00", "2.00", "5.00"],
    ]


def test_smallest_unit_of_loop_errors_is_the_micrometre():
    for sizes, unit, cells in (
        ((3e-8, 4e-9), "µm", ["0.03000", "0.00400"]),
        ((3e-2, 2e-3), "mm", ["30.00", "2.00"]),
    ):
        table = loops_module.variant_table(result(*map(looped, "ab", sizes)))
        assert (table.heads[1], [row[1] for row in table.rows]) == (
            f"Following error, peak to peak [{unit}]",
            cells,
        )


def test_measured_errors_are_in_the_first_row():
    table = loops_module.variant_table(result(looped("a", 4e-6)), errors(6e-6, 3e-6, 1e-6))
    assert [table.rows[0], table.rows[1][0]] == [
        ["measured", "6.00", "3.00", "1.00", "–", "–", "–"],
        "a",
    ]


def test_diverged_loop_has_dashes_and_a_remark():
    table = loops_module.variant_table(
        result(
            looped("a", 4e-6),
            looped("b", 1e-9, status=Status.NOT_FINITE),
            looped("c", 4e-6, status=Status.TOLERANCE_MISSED),
        )
    )
    assert table.rows[1] == ["b", *["–"] * 6, Status.NOT_FINITE.sentence]
    assert [row[-1] for row in table.rows[::2]] == ["", Status.TOLERANCE_MISSED.sentence]
    assert table.heads[1].endswith("[µm]")


def test_open_loops_are_reported_by_their_motion():
    table = loops_module.variant_table(result(looped("a", 4e-3, is_open=True), kind="rotational"))
    heads = [
        "Variant",
        "Position, peak to peak [mrad]",
        "lowest [mrad]",
        "highest [mrad]",
        "Torque, rms [N·m]",
        "peak [N·m]",
    ]
    assert table == ("The variants", heads, [["a", "4.00", "−4.00", "2.00", "2.00", "5.00"]])
    for other in (result(looped("a", 4e-3, is_open=True), looped("b", 1.0)), result()):
        assert loops_module.variant_table(other).caption == "The variants of the loop"


def test_errors_are_listed_by_direction_of_the_reference():
    table = loops_module.direction_table(
        result(looped("a", 8e-6), looped("b", 1e-9, status=Status.NOT_FINITE))
    )
    assert table.heads == ["Variant", "Direction", "Mean [µm]", "rms [µm]", "Peak to peak [µm]"]
    assert table.rows == [
        ["a", "forward", "0.10", "2.00", "4.00"],
        ["a", "backward", "−0.10", "1.00", "2.00"],
    ]


def test_parts_of_a_loop_have_their_values():
    law = controllers.cascade(k_p=80.0, k_v=4000.0)
    table = loops_module.component_table(
        "parts",
        [("Controller", law), ("Friction", friction.coulomb(F_C=8.0)), ("Fed forward", None)],
    )
    (*controller, values), *rest = table.rows
    assert (table.caption, table.heads, controller) == (
        "parts",
        ("Part", "Model", "Parameters"),
        ["Controller", "cascade"],
    )
    assert values.startswith("k_p = 80 1/s, k_v = 4000 N·s/m")
    assert rest == [("Friction", "coulomb", "F_C = 8 N"), ("Fed forward", "none", "")]


def test_list_of_numbers_is_reported_by_size_and_range():
    model = Some(
        values={"K_i": np.array([1e6, 3e6]), "shape": "round"}, name="m", kind="translational"
    )
    model.component = Some(variables=dict.fromkeys(model.values, Some(unit=lambda kind: "N/m")))
    ((_, _, text),) = loops_module.component_table("parts", [("Friction", model)]).rows
    assert text == f"K_i = 2 values, {number(1e6)} to {number(3e6)} N/m, shape = round"


def test_open_loop_has_no_controller():
    closed = [row[0] for row in loops_module.parts_table(loop()).rows]
    assert closed == [
        "Plant",
        "Friction",
        "Controller",
        "Sensor",
        "Reference",
        "Friction feedforward",
    ]
    table = loops_module.parts_table(
        Some(
            **{name: getattr(loop(), name) for name in ("name", "plant", "friction", "sensor")},
            effort=Some(),
        )
    )
    assert (table.caption, [row[0] for row in table.rows]) == (
        "The parts of " + loop().name,
        ["Plant", "Friction", "Sensor"],
    )


def test_run_settings_have_units():
    run = Some(
        duration=1.25,
        settle=0.5,
        sample_time=1e-3,
        tolerance=0.0,
        substeps=4,
        delay=2,
        effort_limit=math.inf,
    )
    variant = Some(
        name="a", run=run, plant=Some(kind="translational"), feedforward=Some(mass=20.0, gain=0.5)
    )
    table = loops_module.run_table([variant])
    assert dict(zip(table.heads, table.rows[0], strict=True)) == {
        "Variant": "a",
        "Duration": "1.25 s",
        "Left out at the start": "500 ms",
        "Sample time": "1 ms",
        "Steps in a sample": "4",
        "Delay [samples]": "2",
        "Effort limit": "∞ N",
        "Mass feedforward": "20 kg",
        "Factor on friction feedforward": "0.5",
    }
    run.tolerance = 1e-9
    assert (
        dict(zip(table.heads, loops_module.run_table([variant]).rows[0], strict=True))[
            "Steps in a sample"
        ]
        == "adaptive, to within 1 nm of position"
    )


def lines(*claims, **changes):
    return [line.replace("\u00a0", " ") for line in loops_module.law_lines(loop(**changes), claims)]


def test_gains_are_listed_with_feedforward_of_friction_and_mass():
    law = controllers.cascade(k_p=80.0, k_v=4000.0)
    contact = friction.coulomb(F_C=8.0)
    whole = lines(controller=law, feedforward=Feedforward(friction=contact, mass=20.0))
    assert whole == [
        "law cascade: k_p 80 1/s, k_v 4000 N·s/m, averaging 1",
        f"friction feedforward: coulomb, along the {Feedforward().along} motion",
        "inertia feedforward: acceleration × 20 kg",
    ]
    assert lines(controller=law, feedforward=Feedforward(friction=contact, gain=0.5))[1:] == [
        f"friction feedforward: coulomb × 0.5, along the {Feedforward().along} motion"
    ]
    helped = lines(
        Claim(75e-6, None, 0.3), controller=law, feedforward=Feedforward(friction=contact)
    )[1]
    assert helped.endswith("motion; it helps quick moves of 75 µm or more with rests up to 0.3 s")
    bare = [
        lines(controller=law, feedforward=Feedforward(), axis=axis)
        for axis in (None, Axis(arm=0.8e-3))
    ]
    assert bare == [
        whole[:1],
        ["law cascade: k_p 80 1/s, k_v 4000 N·s/m (0.00256 N*m*s/rad at the motor), averaging 1"],
    ]


def test_loops_with_the_same_warning_share_a_line():
    judged = {
        "a": assessed("a", 15.0, switches=True),
        "b": assessed("b", 15.0),
        "c": assessed("c", 15.0, gain=UNSTABLE),
    }
    reported = loops_module.about_loops(judged, {"d": Diagnostic("switching_law", "", "note")})
    assert [(item.code, item.numbers["variants"]) for item in reported] == [
        ("switching_law", ("a",)),
        ("small_margin", ("a", "b")),
        ("loop_diverges", ("c",)),
        ("switching_law", ("d",)),
    ]
    words = loops_module.loop_warnings(reported)
    begins = (
        "a, b: warning: the phase margin is only 15°",
        "c: unstable, not simulated",
        "d: the control law chatters",
    )
    assert all(line.startswith(begin) for line, begin in zip(words[1:], begins, strict=True))
    assert loops_module.loop_doubts(reported) == [
        words[2],
        f"{SENTENCES['switching_law'].means}: a",
        "the loop has small margins: a, b",
    ]


def test_single_name_of_a_variant_is_accepted_and_many_are_cut():
    single = Diagnostic("switching_law", "", "note", {"variants": "a"})
    small = Diagnostic(
        "small_margin",
        "",
        "warning",
        {"variants": tuple("abcde"), "motions": "all", "phase": 15.0, "enough": 30.0},
    )
    assert loops_module.loop_doubts([small]) == [
        "the loop has small margins: a, b, c, d and 1 more"
    ]
    assert loops_module.loop_warnings([single])[0].startswith("a: the control law")
