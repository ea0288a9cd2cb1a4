"""The report of a simulation."""

import math
from dataclasses import replace
from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.report.pages import Page
from tests.report.test_pages import simulation_page
from tests.stand_ins import Loop

from bristle.core import Status
from bristle.core.units import convert
from bristle.report import simulation as report
from bristle.report.compensation import standing
from bristle.report.loops import variant_table
from bristle.report.simulation import simulation_ruling, simulation_summary
from bristle.simulation.statistics import Statistics

pytestmark = pytest.mark.usefixtures("undrawn")


def test_table_of_variants_has_their_numbers(workbench):
    table = variant_table(workbench.looped)
    unit = table.heads[1].split("[")[1].rstrip("]")
    si = {"translational": "m", "rotational": "rad"}[workbench.axis.kind]
    for row, variant in zip(table.rows, workbench.looped.variants.values(), strict=True):
        assert row[0] == variant.name
        assert convert(f"{row[1]} {unit}", si) == pytest.approx(variant.following_error.peak_to_peak, rel=0.01)


def test_diverged_loop_has_a_remark(stage):
    failed = replace(stage.looped.variants["compensated"], status=Status.NOT_FINITE)
    result = replace(stage.looped, variants={**stage.looped.variants, "compensated": failed})
    row = variant_table(result).rows[-1]
    assert set(row[1:-1]) == {"–"}
    assert row[-1] == Status.NOT_FINITE.sentence
    assert f"compensated: {Status.NOT_FINITE.sentence}" in Page(simulation_page(stage, result=result)).words


def test_page_exists_if_every_loop_diverged(stage):
    failed = {name: replace(item, status=Status.NOT_FINITE) for name, item in stage.looped.variants.items()}
    page = Page(simulation_page(stage, result=replace(stage.looped, variants=failed)))
    assert page.unbalanced == []
    assert not page.named("figure")
    assert "Forward and backward" not in page.words


def test_every_part_of_the_loop_is_named(stage):
    words = Page(simulation_page(stage)).words
    for part in ("inertia", "stribeck", "cascade", "encoder", "recorded", "6000 values"):
        assert part in words


def statistics(peak):
    return Statistics(peak_to_peak=peak, rms=0.25 * peak, mean=0.0, std=0.0, min=0.0, max=peak)


def ran(name, peak=2e-6, *, status=Status.OK, is_open=False, runs=1, spread=0.0, effort=2.0):
    time = 1e-3 * np.arange(400)
    reference = np.abs((time % 0.2) - 0.1)
    measured = reference - peak * (np.abs(time - 0.3) < 2e-3) - 1e-3 * (time < 0.05)
    scatter = {"following_error": {"peak_to_peak": spread}} if spread else {}
    numbers = {"following_error": statistics(peak), "motion": statistics(peak), "effort_rms": effort, "effort_peak": 2.0 * effort}
    about = {"name": name, "kind": "translational", "status": status, "is_open": is_open, "runs": runs, "spread": scatter}
    return Loop(reference=reference, measured=measured, **numbers, **about)


def simulated(*loops, refused=(), effort=None, limit=math.inf):
    run = Some(settle=0.1, sample_time=1e-3, effort_limit=limit)
    fed = Some(plant=None, friction=None, mass=0.0)
    law = Some(name="cascade", values={})
    known = {"run": run, "feedforward": fed, "controller": law, "reference": 1, "effort": effort, "disturbance": None, "friction": None}
    variants = [Some(name=loop.name, **known) for loop in loops]
    experiment = Some(name="bench", kind="translational", variants=variants)
    return Some(experiment=experiment, variants={loop.name: loop for loop in loops}, refused=dict.fromkeys(refused, "unstable"))


def values_of(result):
    return [line.replace("\u00a0", " ") for line in report._values_of(result, standing(result).best)]


def test_results_have_the_law_of_the_best_variant_its_limit_and_its_scatter():
    loops = ran("base", 8e-6), ran("best", 2e-6, runs=3, spread=1e-7, effort=3.0)
    law, scatter = "best: law cascade: ", "3 runs with different noise: standard deviation 0.100 µm"
    assert values_of(simulated(*loops)) == [law, scatter]
    assert values_of(simulated(*loops, limit=6.0)) == [law, "the drive is at its limit", scatter]
    assert values_of(simulated(ran("base", 8e-6), limit=4.1)) == ["base: law cascade: "]
    assert values_of(simulated(ran("base", 8e-6, runs=2))) == ["base: law cascade: "]


def test_first_page_compares_the_best_loop_with_the_base():
    front = report._front(simulated(ran("base", 8e-6), ran("best", 2e-6, runs=3, spread=1e-7, effort=3.0), refused=["wild"]), ())
    assert front.facts.endswith("3 variants · mean of 3 runs")
    assert front.title == "Following error: 8 → 2\u00a0µm peak to peak, ×4.0"
    assert [(card.label, card.value.replace("\u00a0", " ")) for card in front.cards] == [
        ("Error, peak to peak", "2 µm"),
        ("Error, rms", "0.500 µm"),
        ("Worst reversal", "2 µm"),
        ("Effort, rms", "3 N"),
    ]
    assert front.cards[0].half == pytest.approx(100.0 * 1.96 * 1e-7 / 3**0.5 / 2e-6, rel=1e-3)
    assert (front.next.text, front.next.command) == (
        "Record the machine without and with compensation",
        "bristle compare before.csv after.csv --axis axis.toml",
    )
    assert front.heading == "bench: simulated"


def test_first_page_of_a_single_loop_has_no_comparison():
    front = report._front(simulated(ran("base", 8e-6), limit=4.0), ())
    assert front.facts.endswith("1 variant")
    cards = {card.label: (card.value.replace("\u00a0", " "), card.remark.replace("\u00a0", " ")) for card in front.cards}
    assert (cards["Worst reversal"], cards["Effort, rms"]) == (("8 µm", ""), ("2 N", "peak 4 N"))
    assert front.next == ("Find better gains", "bristle design EXPERIMENT.toml")


def test_first_page_of_open_loops_has_their_motion():
    loops = ran("a", 8e-3, is_open=True), ran("b", 1.0, status=Status.NOT_FINITE, is_open=True)
    front = report._front(simulated(*loops, effort=1), ())
    assert front.title.replace("\u00a0", " ") == "The open loop moves by 8 mm"
    assert [(card.label, card.value.replace("\u00a0", " ")) for card in front.cards] == [("Effort, a", "2 N")]
    assert front.ruling.words == "No loop: the effort is given"
    assert front.next is None
    failed = report._front(simulated(ran("a", status=Status.NOT_FINITE)), ())
    assert (failed.title, failed.next, failed.cards) == ("No variant completed", None, [])


@pytest.mark.parametrize(
    ("loops", "options", "warnings", "level", "words", "reasons"),
    [
        ([ran("a")], {}, (), "usable", "It runs, but there is no second loop to compare", 0),
        ([ran("a")], {"refused": ["b"]}, (), "with_care", "It runs, but there is no second loop to compare", 1),
        ([ran("a")], {}, ("b: unstable",), "with_care", "It runs, but there is no second loop to compare", 1),
        ([ran("a")], {"refused": ["b"]}, ("b: unstable",), "with_care", "It runs, but there is no second loop to compare", 1),
        ([ran("base", status=Status.NOT_FINITE), ran("a")], {}, (), "with_care", "The present loop does not run: no comparison", 1),
        ([ran("base", 2e-6), ran("a", 8e-6)], {}, (), "no", "Another loop does not help", 1),
        ([ran("base", 8e-6), ran("a", 2e-6)], {}, (), "usable", "Another loop helps", 1),
        ([ran("base", 8e-6), ran("a", 7.9e-6)], {}, (), "with_care", "Another loop hardly helps", 1),
        ([ran("a", status=Status.NOT_FINITE)], {}, (), "no", "It does not run", 1),
        ([ran("a", is_open=True)], {"effort": 1}, (), "usable", "No loop: the effort is given", 0),
    ],
)
def test_verdict_of_a_run_uses_the_completed_loops(loops, options, warnings, level, words, reasons):
    ruling = simulation_ruling(simulated(*loops, **options), warnings)
    assert (ruling.level, ruling.words, len(ruling.reasons)) == (level, words, reasons)


def test_swing_excludes_the_settling_time():
    result = simulated(ran("base", 8e-6))
    assert report._swing(result, result.variants["base"]) == pytest.approx(8e-6)
    short = result.variants["base"]
    short.reference, short.measured = short.reference[:50], short.measured[:50]
    assert report._swing(result, short) is None


def test_summary_of_a_run_has_its_numbers():
    loops = [ran("a", runs=3), ran("b", runs=2, status=Status.NOT_FINITE)]
    for loop in loops:
        loop.as_dict = dict
    summary = simulation_summary(simulated(*loops, refused=["c"]), files={"a": "log.csv"}, provenance={})
    assert (summary["name"], summary["kind"], summary["runs"], summary["error_unit"], summary["effort_unit"]) == (
        *("bench", "translational", 3),
        *("m", "N"),
    )
    assert {name: item["completed"] for name, item in summary["variants"].items()} == {"a": True, "b": False, "c": False}
    assert summary["variants"]["c"] == {"status": "unstable", "completed": False, "runs": 0}
    assert simulation_summary(simulated(refused=["c"]), files={}, provenance={})["runs"] == 0


@pytest.mark.parametrize("is_open", [True, False])
def test_page_of_a_run_lists_the_simulated_parts(monkeypatch, is_open):
    seen = {}
    monkeypatch.setattr(report, "report_page", lambda kind, facts, front, sections, **options: seen.update(facts, sections=sections) or "")
    for name in ("variant_table", "run_table", "parts_table", "direction_table"):
        monkeypatch.setattr(report, name, lambda *_, name=name: name)
    effort = Some(description="a sine") if is_open else None
    report.simulation_report(
        simulated(ran("base", 8e-6, is_open=is_open), ran("best", 2e-6, is_open=is_open), effort=effort), warnings=["small"]
    )
    variants, summary, directions, assumptions = seen["sections"]
    assert variants.heading == ("Motions and efforts" if is_open else "Errors and efforts")
    assert summary.blocks[0] == "small."
    assert (summary.blocks[-1] is None) == is_open
    assert directions.blocks == [None if is_open else "direction_table"]
    assert assumptions.blocks[-3:] == ["run_table", "parts_table", "parts_table"]
    assert len(assumptions.blocks) == (6 if is_open else 4)
    assert (seen["open_loop"] is None, seen["focus"]) == (not is_open, None if is_open else ())
    assert seen.get("at_reversal") == (None if is_open else ["base", "best"])
