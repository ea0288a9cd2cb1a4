"""What the report of a simulation tells."""

from dataclasses import replace

import pytest
from tests.report.pages import Page
from tests.report.test_pages import simulation_page

from bristle.core import Status
from bristle.core.units import convert
from bristle.report.loops import variant_table


def test_the_table_of_variants_holds_their_numbers(workbench):
    table = variant_table(workbench.looped)
    unit = table.heads[1].split("[")[1].rstrip("]")
    si = {"translational": "m", "rotational": "rad"}[workbench.axis.kind]
    for row, variant in zip(table.rows, workbench.looped.variants.values(), strict=True):
        assert row[0] == variant.name
        assert convert(f"{row[1]} {unit}", si) == pytest.approx(variant.following_error.peak_to_peak, rel=0.01)


def test_a_loop_that_diverged_says_so_in_words(stage):
    failed = replace(stage.looped.variants["compensated"], status=Status.NOT_FINITE)
    result = replace(stage.looped, variants={**stage.looped.variants, "compensated": failed})
    row = variant_table(result).rows[-1]
    assert set(row[1:-1]) == {"–"}
    assert row[-1] == Status.NOT_FINITE.sentence
    assert f"compensated: {Status.NOT_FINITE.sentence}" in Page(simulation_page(stage, result=result)).words


def test_a_page_remains_where_every_loop_diverged(stage):
    failed = {name: replace(item, status=Status.NOT_FINITE) for name, item in stage.looped.variants.items()}
    page = Page(simulation_page(stage, result=replace(stage.looped, variants=failed)))
    assert page.unbalanced == []
    assert not page.named("figure")
    assert "Forward and backward" not in page.words


def test_every_part_of_the_loop_is_named(stage):
    words = Page(simulation_page(stage)).words
    for part in ("inertia", "stribeck", "cascade", "encoder", "recorded", "6000 values"):
        assert part in words
