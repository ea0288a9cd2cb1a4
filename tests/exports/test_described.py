"""What exported files say of a model, what tells them apart from those of another one, and what is refused."""

import hashlib
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.exports.native import example_with
from tests.exports.test_laws import variant_of
from tests.exports.test_names import HEAD, TRIAL, model_of
from tests.identification.known_logs import log_of, sines

import bristle as br
from bristle.contract import example_of
from bristle.exports import face
from bristle.exports.described import (
    Request,
    Source,
    command_facts,
    copyright_line,
    hash_of_model,
    meaning_of,
    meaning_within,
    model_facts,
    model_version,
    parameter_table,
    plain,
    text_of,
    version,
    with_rights,
)
from bristle.exports.law import hash_of_law, law_of
from bristle.exports.subject import capacity_of, forces_of, subject_of
from bristle.exports.targets import TARGETS, Product
from bristle.prediction.drive_units import CommandUnits, DriveUnit

VALUES = {"F_C": 22.0, "F_S": 29.0, "v_S": 3e-3, "sigma_0": 2e6, "sigma_1": 1e3, "sigma_2": 40.0}
LUGRE = br.friction.lugre(**VALUES)
PLAY = br.hysteresis.play(r=1.0)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("5 µm · s² − 1 – 2", "5 um * s^2 - 1 - 2"),
        ("a */ b /* c", "a * / b / * c"),
        ("größe\n  in two lines", "gr??e in two lines"),
    ],
)
def test_plain_text_is_ascii_in_one_line_and_cannot_end_a_comment(text, expected):
    assert plain(text) == expected


FORCE, SHARE = br.core.Variable("force", "a force", min=0.0), br.core.Variable("1", "a share")


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
def test_a_table_has_value_unit_range_and_interval_of_each_parameter(
    model, source, name, place, cells
):
    rows = rows_of(model, source)
    assert [row[0] for row in rows] == ["value", *model.component.variables]
    row = next(row for row in rows if row[0] == name)
    assert row[place : place + len(cells)] == cells


def test_a_table_shows_the_first_eight_numbers_of_an_array():
    few, many = (
        parameter_table(
            br.friction.maxwell_slip(
                F_C=4.0, nu_i=np.full(count, 1 / count), k_i=np.full(count, 1e5)
            ),
            Source(),
        )
        for count in (8, 10)
    )
    assert "in all" not in few
    assert "100000, 100000, 100000, 100000, 100000, 100000, 100000, 100000, ... (10 in all)" in many


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
            {
                "unit_x": "m",
                "unit_force": "N",
                "dt": "0.0005",
                "rate": "2000",
                "operator": False,
                "title": "Friction of an axis: lugre",
            },
        ),
        (
            PLAY,
            1e-3,
            True,
            {"rate": "1000", "operator": True, "title": "Hysteresis operator: play"},
        ),
    ],
)
def test_facts_of_a_model_and_of_an_operator_have_their_units(model, dt, single, facts):
    told = model_facts(subject_of(model), "axis_x", Source(), dt, single=single, tunable=not single)
    assert (told["single"], told["tunable"]) == (single, not single)
    assert facts.items() <= told.items()


def test_units_of_a_drive_have_valid_names_in_c():
    units = CommandUnits(
        DriveUnit("mm", 1e-3),
        DriveUnit("% of rated", 0.5),
        (DriveUnit("mN*m", 1e-3), DriveUnit("A/V", 2.0)),
    )
    facts = command_facts(units, "rotational")
    assert (facts["position"], facts["unit_force"], facts["unit_x"]) == (
        {"unit": "mm", "si": "0.001"},
        "N*m",
        "rad",
    )
    expected = [("PERCENT_OF_RATED", "0.5"), ("MNM", "0.001"), ("A_PER_V", "2.0")]
    assert [(effort["macro"], effort["si"]) for effort in facts["efforts"]] == expected
    assert command_facts(None, "rotational") is None


def test_the_licence_head_comes_first_except_after_an_xml_declaration():
    files = with_rights(
        {"a.c": "code\n", "a.xml": "<?xml?>\n<a/>\n", "a.st": "x"}, Source(model_hash="ab" * 32)
    )
    lines = files["a.c"].splitlines()
    assert lines[0] == "/* SPDX-License-Identifier: BSD-3-Clause */"
    assert lines[3] == f"/* Hash of the model: sha256 {'ab' * 32} */"
    assert lines[4] == "code"
    assert files["a.xml"].splitlines()[:2] == [
        "<?xml?>",
        "<!-- SPDX-License-Identifier: BSD-3-Clause -->",
    ]
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
    np.testing.assert_array_equal(
        subject_of(LUGRE).forces(x, 1e-3)[1:], br.response(LUGRE, x, 1e-3)[1:]
    )
    assert forces_of(LUGRE, x, 1e-3)[0] == 0.0
    wide = np.array([0.0, 2.0, 1.5, -0.5, -3.0, 4.0])
    assert subject_of(PLAY).outputs(wide) == pytest.approx([0.0, 1.0, 1.0, 0.5, -2.0, 3.0])


@pytest.mark.parametrize("target", ["st", "c", "cuda", "wasm"])
def test_a_long_remark_is_folded_in_the_head_of_every_file(target):
    written = TARGETS[target].write
    remark = " ".join(f"word{number}" for number in range(60))
    files = written(
        Request(
            br.friction.coulomb_viscous(F_C=2.0, F_v=3.0),
            "axis_x",
            1e-3,
            source=Source(remarks=(remark,)),
        )
    ).files
    texts = [
        text
        for name, text in files.items()
        if isinstance(text, str) and "word59" in text and not name.endswith(".md")
    ]
    assert texts
    for text in texts:
        lines = [line for line in text.splitlines() if "word" in line]
        assert len(lines) > 3
        assert max(map(len, lines)) <= 125
        assert re.findall(r"word\d+", " ".join(lines)) == remark.split()


# --- from Python and from text ---------------------------------------------------------------------------------------


COULOMB = br.friction.coulomb(F_C=1.0)


@pytest.fixture
def requested(monkeypatch):
    """Targets with the request, and whether harm is accepted."""
    seen = []

    def files(target, request, *, accept_harm):
        seen.append((target, request, accept_harm))
        return Product({"a.txt": "a"}, ("a note",))

    monkeypatch.setattr(face, "files_for", files)
    return seen


DEFAULTS = {
    "model": COULOMB,
    "name": "axis_x",
    "dt": 5e-4,
    "tunable": False,
    "single": False,
    "axis": None,
    "plant": None,
    "log": None,
}
DEFAULTS |= {"loop": None, "speed": 0.0, "points": 20, "mass": 1.0, "rest": "", "info": {}}


def test_default_options_are_fixed_parameters_half_a_millisecond_and_no_harm(requested, tmp_path):
    result = br.export(COULOMB, "c", tmp_path / "out")
    ((target, request, accept_harm),) = requested
    assert (target.name, accept_harm) == ("c", False)
    assert DEFAULTS.items() <= vars(request).items()
    assert (result.files, result.notes, result.effect) == (("a.txt",), ("a note",), None)
    assert (tmp_path / "out" / "a.txt").read_text() == "a"
    with pytest.raises(br.core.InputError):
        br.export(COULOMB, "c", tmp_path / "out")


def test_options_become_a_request(requested, tmp_path):
    br.export(
        COULOMB,
        "c",
        tmp_path / "out",
        accept_harm=True,
        tunable=True,
        float32=True,
        rest="middle",
        speed="2 mm/s",
    )
    # Which bristle cannot know to be unused.
    br.export(COULOMB, replace(TARGETS["c"], name="of_a_person"), tmp_path / "own", mass="2 kg")
    (_, request, accept_harm), (_, own, _) = requested
    assert (
        request.tunable,
        request.single,
        request.rest,
        request.speed,
        accept_harm,
        own.mass,
    ) == (True, True, "middle", 2e-3, True, 2.0)


@pytest.mark.parametrize(("points", "taken"), [(1, False), (2, True), (1000, True), (1001, False)])
def test_the_option_points_allows_two_to_a_thousand_entries(requested, tmp_path, points, taken):
    if taken:
        br.export(COULOMB, "table", tmp_path / "out", points=points)
        assert requested[0][1].points == points
    else:
        with pytest.raises(br.core.InputError, match="points"):
            br.export(COULOMB, "table", tmp_path / "out", points=points)


def test_text_and_missing_options_become_a_request(requested):
    options: dict[str, Any] = {"name": None, "step": None, "rest": None, "accept_harm": False}
    face.files_from_text(TARGETS["c"], COULOMB, Source(), **options)
    face.files_from_text(
        TARGETS["c"],
        COULOMB,
        Source(),
        **options | {"step": "2 ms", "name": "mine", "rest": "held", "accept_harm": True},
    )
    assert [(request.name, request.dt, request.rest, harm) for _, request, harm in requested] == [
        ("axis_x", 5e-4, "", False),
        ("mine", 2e-3, "held", True),
    ]
    wrong: dict[str, Any]
    for wrong in ({"step": "0 s"}, {"rest": "moving"}, {"name": "int"}):
        with pytest.raises(br.core.InputError):
            face.files_from_text(TARGETS["c"], COULOMB, Source(), **options | wrong)


MOTION = sines(duration=0.5)
LOG = {"log": log_of(MOTION, 12.0 * MOTION.acceleration)}
LAW = variant_of("cascade", "nothing")
NOT_A_TABLE = "is not a table"


@pytest.mark.parametrize(
    ("model", "to", "options", "words"),
    [
        (COULOMB, "cobol", {}, "no such target"),
        (COULOMB, "c", {"name": "int"}, "cannot name a function"),
        (COULOMB, "c", {"name": "Axis 1"}, "cannot name a function"),
        (COULOMB, "st", {"name": "limit"}, "cannot name a function block"),
        (COULOMB, "c", {"step": 0.0}, "step"),
        (COULOMB, "c", LOG, NOT_A_TABLE),
        (COULOMB, "mjcf", LOG, NOT_A_TABLE),
        (COULOMB, "sinumerik", LOG, NOT_A_TABLE),
        (
            LUGRE.with_values(sigma_0=1e39),
            "c",
            {"float32": True},
            r"sigma_0: is too large for single precision.*float32",
        ),
        (LUGRE, "c", {"derivatives": True, "float32": True}, "single precision"),
        (LUGRE, "st", {"derivatives": True}, "does not support derivatives"),
        (PLAY, "c", {"derivatives": True}, "of friction only"),
        (PLAY, "wasm", {}, "does not support hysteresis operators"),
        (PLAY, "casadi", {}, "operators"),
        (LAW, "wasm", {}, "does not support control laws"),
        (LAW, "fmu3", {"float32": True}, "single precision"),
    ],
)
def test_what_a_target_cannot_write_is_refused_without_a_file(tmp_path, model, to, options, words):
    with pytest.raises(br.core.InputError, match=words):
        br.export(model, to, tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()


# --- hashes and the licence ------------------------------------------------------------------------------------------


ROOT = Path(__file__).parents[2]
LED = variant_of("cascade", "desired")
TEXT_ENDS = (".c", ".h", ".st", ".txt", ".md", ".xml", ".mjs", ".cu")


def hash_of(subject):
    return (
        hash_of_law(law_of(subject))
        if isinstance(subject, br.core.Variant)
        else hash_of_model(subject)
    )


def test_the_licence_is_that_of_the_package():
    assert text_of("shared/LICENSE.txt") == (ROOT / "LICENSE").read_text(encoding="ascii")


@pytest.mark.parametrize(
    ("subject", "to", "options"),
    [
        *((LUGRE, to, {}) for to in ("c", "st", "cuda", "wasm")),
        (LUGRE, "c", {"tunable": True, "name": "knee"}),
        (LUGRE, "st", {"float32": True, "step": 1e-3}),
        *((COULOMB, "c", {"rest": rest}) for rest in ("held", "middle")),
        *(
            (LAW, to, options)
            for to in ("c", "st")
            for options in ({}, {"tunable": True}, {"float32": True})
        ),
    ],
)
def test_all_files_have_the_hash_of_their_model_for_all_options(tmp_path, subject, to, options):
    br.export(subject, to, tmp_path / "out", **options)
    files = [path for path in (tmp_path / "out").iterdir() if path.suffix in TEXT_ENDS]
    heads = [
        "".join(path.read_text(encoding="utf-8").splitlines(keepends=True)[:9]) for path in files
    ]
    assert {re.search(r"Hash of the model: sha256 ([0-9a-f]{64})", head)[1] for head in heads} == {
        hash_of(subject)
    }
    assert all(
        "SPDX-License-Identifier: BSD-3-Clause" in head and copyright_line() in head
        for head in heads
    )


def test_hashes_stay_what_they_were_in_every_process():
    digests = {
        name: hash_of_model(example_with(name))[:12] for name in ("lugre", "stribeck", "gms")
    }
    assert digests == {"lugre": "0681e09f87ac", "stribeck": "2c9b5ee8b03c", "gms": "91dd668345f8"}


DIFFERENT = {
    "a bit and the kind of axis": [
        LUGRE,
        LUGRE.with_values(F_S=29.000000000000004),
        br.friction.lugre(kind="rotational", **VALUES),
    ],
    "models and operators": [
        *map(
            example_of,
            [
                *br.friction.MODELS.values(),
                br.friction.with_slots(br.friction.MODELS["lugre"], ("asymmetry",)),
                *br.hysteresis.OPERATORS.values(),
            ],
        )
    ],
    "gain, compensator and delay": [
        LED,
        LAW,
        variant_of("cascade", "measured"),
        variant_of("sliding_mode", "desired"),
        replace(LED, controller=LED.controller.with_values(k_p=40.00000000000001)),
        replace(LED, feedforward=replace(LED.feedforward, gain=0.65)),
        replace(LED, run=replace(LED.run, delay=2)),
    ],
}


@pytest.mark.parametrize("name", DIFFERENT)
def test_each_difference_changes_the_hash(name):
    assert len({hash_of(subject) for subject in DIFFERENT[name]}) == len(DIFFERENT[name])


def test_the_hash_depends_on_the_computation_not_on_the_text_of_kernels(tmp_path):
    changed = {
        "commented": TRIAL.replace("    total = 0\n", "    # the sum\n\n    total = 0  # of all\n"),
        "constant": TRIAL.replace("0.01 * total", "0.02 * total"),
        "order": TRIAL.replace("side * (p.F_C + 0.01 * total)", "(p.F_C + 0.01 * total) * side"),
    }
    assert all(text != TRIAL for text in changed.values())
    result = {
        name: hash_of_model(model_of(HEAD + text, tmp_path)) for name, text in changed.items()
    }
    plain = hash_of_model(model_of(HEAD + TRIAL, tmp_path))
    assert result.pop("commented") == plain
    assert len({plain, *result.values()}) == 3
    assert (
        hash_of_model(model_of(HEAD.replace("LAYERS = 3", "LAYERS = 2") + TRIAL, tmp_path)) != plain
    )
