"""What the comments of exported files say: values, ranges, intervals, units, and whose they are."""

import hashlib
import re
from importlib import import_module

import numpy as np
import pytest

import bristle as br
from bristle.core.variable import Variable
from bristle.exports.described import (
    Source,
    command_facts,
    hash_of_model,
    meaning_of,
    meaning_within,
    model_facts,
    model_version,
    parameter_table,
    plain,
    version,
    with_rights,
)
from bristle.exports.subject import capacity_of, forces_of, subject_of
from bristle.exports.targets import Request
from bristle.prediction.drive_units import CommandUnits, DriveUnit

LUGRE = br.friction.lugre(F_C=22.0, F_S=29.0, v_S=3e-3, sigma_0=2e6, sigma_1=1e3, sigma_2=40.0)
PLAY = br.hysteresis.play(r=1.0)


@pytest.mark.parametrize(
    ("text", "expected"),
    [("5 µm · s² − 1 – 2", "5 um * s^2 - 1 - 2"), ("a */ b /* c", "a * / b / * c"), ("größe\n  in two lines", "gr??e in two lines")],
)
def test_plain_text_is_ascii_in_one_line_and_cannot_end_a_comment(text, expected):
    assert plain(text) == expected


FORCE, SHARE = Variable("force", "a force", min=0.0), Variable("1", "a share")


@pytest.mark.parametrize(
    ("meaning", "variable", "kind", "expected"),
    [
        (meaning_of, FORCE, "translational", "a force [N]"),
        (meaning_of, FORCE, "rotational", "a force [N*m]"),
        (meaning_of, SHARE, "translational", "a share"),
        (meaning_within, FORCE, "translational", "a force [N], >= 0 N"),
        (meaning_within, SHARE, "translational", "a share, any number"),
    ],
)
def test_a_meaning_has_its_unit_and_optionally_its_range(meaning, variable, kind, expected):
    assert meaning(variable, kind) == expected


def rows_of(model, source=None):
    lines = parameter_table(model, source or Source()).splitlines()
    assert all(line.startswith("   ") for line in lines)
    return [[cell.strip() for cell in line.split("  ") if cell.strip()] for line in lines]


OFFSET = br.friction.with_slots(br.friction.coulomb, [])(F_C=2.0, offset=-1.5)
SURE = Source(uncertainty={"F_C": {"interval": (21.5, 22.5)}, "F_S": {"status": "unidentifiable"}})
ENCODER = br.sensors.encoder(resolution=1e-6)


@pytest.mark.parametrize(
    ("model", "source", "name", "place", "cells"),
    [
        (LUGRE, Source(), "value", 0, ["value", "unit", "allowed"]),
        (LUGRE, Source(), "F_C", 0, ["F_C", "22", "N", ">= 1e-12"]),
        (OFFSET, Source(), "offset", 0, ["offset", "-1.5", "N"]),
        (LUGRE, SURE, "value", 0, ["value", "unit", "allowed", "95 % interval"]),
        (LUGRE, SURE, "F_C", 4, ["21.5 to 22.5"]),
        (LUGRE, SURE, "F_S", 4, ["unidentifiable"]),
    ],
)
def test_a_table_has_value_unit_range_and_interval_of_each_parameter(model, source, name, place, cells):
    rows = rows_of(model, source)
    assert [row[0] for row in rows] == ["value", *model.component.variables]
    row = next(row for row in rows if row[0] == name)
    assert row[place : place + len(cells)] == cells


def test_a_table_shows_the_first_eight_numbers_of_an_array():
    few = br.friction.maxwell_slip(F_C=4.0, nu_i=np.full(8, 0.125), k_i=np.full(8, 1e5))
    many = br.friction.maxwell_slip(F_C=4.0, nu_i=np.full(10, 0.1), k_i=np.full(10, 1e5))
    assert "in all" not in parameter_table(few, Source())
    assert "100000, 100000, 100000, 100000, 100000, 100000, 100000, 100000, ... (10 in all)" in parameter_table(many, Source())


def test_a_bounded_range_shows_both_ends_and_a_choice_is_fixed():
    rows = {row[0]: row for row in rows_of(ENCODER)}
    for name, variable in ENCODER.component.variables.items():
        if np.isfinite(variable.min) and np.isfinite(variable.max):
            assert f"{variable.min:g} to {variable.max:g}" in rows[name]


@pytest.mark.parametrize(
    ("model", "dt", "single", "facts"),
    [
        (
            LUGRE,
            5e-4,
            False,
            {"unit_x": "m", "unit_force": "N", "dt": "0.0005", "rate": "2000", "operator": False, "title": "Friction of an axis: lugre"},
        ),
        (PLAY, 1e-3, True, {"rate": "1000", "operator": True, "title": "Hysteresis operator: play"}),
    ],
)
def test_facts_of_a_model_and_of_an_operator_have_their_units(model, dt, single, facts):
    told = model_facts(subject_of(model), "axis_x", Source(), dt, single=single, tunable=not single)
    assert (told["single"], told["tunable"]) == (single, not single)
    assert facts.items() <= told.items()


def test_units_of_a_drive_have_valid_names_in_c():
    units = CommandUnits(DriveUnit("mm", 1e-3), DriveUnit("% of rated", 0.5), (DriveUnit("mN*m", 1e-3), DriveUnit("A/V", 2.0)))
    facts = command_facts(units, "rotational")
    assert (facts["position"], facts["unit_force"], facts["unit_x"]) == ({"unit": "mm", "si": "0.001"}, "N*m", "rad")
    expected = [("PERCENT_OF_RATED", "0.5"), ("MNM", "0.001"), ("A_PER_V", "2.0")]
    assert [(effort["macro"], effort["si"]) for effort in facts["efforts"]] == expected
    assert command_facts(None, "rotational") is None


def test_the_licence_head_comes_first_except_after_an_xml_declaration():
    files = with_rights({"a.c": "code\n", "a.xml": "<?xml?>\n<a/>\n", "a.st": "x"}, Source(model_hash="ab" * 32))
    lines = files["a.c"].splitlines()
    assert lines[0] == "/* SPDX-License-Identifier: BSD-3-Clause */"
    assert lines[3] == f"/* Hash of the model: sha256 {'ab' * 32} */"
    assert lines[4] == "code"
    assert files["a.xml"].splitlines()[:2] == ["<?xml?>", "<!-- SPDX-License-Identifier: BSD-3-Clause -->"]
    assert files["a.xml"].endswith("<a/>\n")
    assert files["a.st"].startswith("(* SPDX")
    assert "Hash" not in with_rights({"a.c": ""}, Source())["a.c"]


def test_a_version_ends_with_the_first_digits_of_the_hash():
    assert model_version(Source()) == version()
    assert model_version(Source(model_hash="0123456789abcdef")) == f"{version()}+0123456789ab"
    assert len(hash_of_model(LUGRE)) == hashlib.sha256().digest_size * 2
    assert hash_of_model(LUGRE) != hash_of_model(LUGRE.with_values(sigma_2=41.0))


def test_a_source_lists_its_remarks_first():
    source = Source({"command": "bristle export", "log": "a.csv"}, remarks=("see below",))
    assert source.lines == ["see below", "command: bristle export", "log: a.csv"]


def test_a_depth_has_as_many_values_as_the_memory_has_pairs():
    assert [capacity_of("depth", size) for size in (20, 21, 0)] == [10, 10, 2**31]
    assert capacity_of("count", 20) == 2**31


def test_a_subject_gives_the_forces_and_outputs_of_its_model():
    x = 1e-5 * np.sin(np.linspace(0.0, 9.0, 200))
    np.testing.assert_array_equal(subject_of(LUGRE).forces(x, 1e-3)[1:], br.response(LUGRE, x, 1e-3)[1:])
    assert forces_of(LUGRE, x, 1e-3)[0] == 0.0
    wide = np.array([0.0, 2.0, 1.5, -0.5, -3.0, 4.0])
    assert subject_of(PLAY).outputs(wide) == pytest.approx([0.0, 1.0, 1.0, 0.5, -2.0, 3.0])


@pytest.mark.parametrize("target", ["st", "c", "cuda", "wasm"])
def test_a_long_remark_is_folded_in_the_head_of_every_file(target):
    written = import_module(f"bristle.exports.{target}").write
    remark = " ".join(f"word{number}" for number in range(60))
    files = written(Request(br.friction.coulomb_viscous(F_C=2.0, F_v=3.0), "axis_x", 1e-3, source=Source(remarks=(remark,)))).files
    texts = [text for name, text in files.items() if isinstance(text, str) and "word59" in text and not name.endswith(".md")]
    assert texts
    for text in texts:
        lines = [line for line in text.splitlines() if "word" in line]
        assert len(lines) > 3
        assert max(map(len, lines)) <= 125
        assert re.findall(r"word\d+", " ".join(lines)) == remark.split()
