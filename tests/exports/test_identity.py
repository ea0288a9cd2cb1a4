"""What tells exports of a model apart from those of another one, and the line on the licence that each of them has."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from tests.exports.native import example_with
from tests.exports.test_laws import variant_of
from tests.exports.test_names import HEAD, TRIAL, model_of

import bristle as br
from bristle.exports.described import copyright_line, hash_of_law, hash_of_model, licence_text
from bristle.exports.law import law_of
from bristle.friction import MODELS, with_slots
from bristle.hysteresis import OPERATORS
from bristle.testing import example_of

ROOT = Path(__file__).parents[2]
LUGRE = {"F_C": 22.0, "F_S": 29.0, "v_S": 3e-3, "sigma_0": 2e6, "sigma_1": 1e3, "sigma_2": 40.0}
TEXT_ENDS = (".c", ".h", ".st", ".txt", ".md", ".xml", ".mjs", ".cu")


def hashes(folder):
    """Return the hashes that the files of an export tell, and how many of them are text."""
    files = [path for path in folder.iterdir() if path.suffix in TEXT_ENDS]
    heads = ["".join(path.read_text(encoding="utf-8").splitlines(keepends=True)[:9]) for path in files]
    for head in heads:
        assert "SPDX-License-Identifier: BSD-3-Clause" in head
        assert copyright_line() in head
    return {re.search(r"Hash of the model: sha256 ([0-9a-f]{64})", head)[1] for head in heads}, len(files)


def test_the_licence_is_that_of_the_package():
    assert licence_text() == (ROOT / "LICENSE").read_text(encoding="ascii")


def test_all_files_have_the_hash_of_their_model_for_all_options(tmp_path):
    model = br.friction.lugre(**LUGRE)
    cases = {
        "c": {},
        "st": {},
        "cuda": {},
        "wasm": {},
        "tuned": {"to": "c", "tunable": True, "name": "knee"},
        "single": {"to": "st", "float32": True, "step": 1e-3},
    }
    for name, options in cases.items():
        options = {"to": name} | options
        br.export(model, options.pop("to"), tmp_path / name, **options)
        result, count = hashes(tmp_path / name)
        assert result == {hash_of_model(model)}
        assert count >= (1 if name == "wasm" else 2)


def test_hashes_stay_what_they_were_in_every_process():
    digests = {name: hash_of_model(example_with(name))[:12] for name in ("lugre", "stribeck", "gms")}
    assert digests == {"lugre": "0681e09f87ac", "stribeck": "2c9b5ee8b03c", "gms": "91dd668345f8"}


def test_the_rule_at_rest_does_not_change_the_hash(tmp_path):
    model = br.friction.coulomb(F_C=3.0)
    for rest in ("held", "middle"):
        br.export(model, "c", tmp_path / rest, rest=rest)
    assert hashes(tmp_path / "held")[0] == hashes(tmp_path / "middle")[0] == {hash_of_model(model)}


def test_one_bit_of_a_number_or_the_kind_of_axis_changes_the_hash():
    model = br.friction.lugre(**LUGRE)
    rest = [model.with_values(F_S=29.000000000000004), br.friction.lugre(kind="rotational", **LUGRE)]
    assert len({hash_of_model(each) for each in (model, *rest)}) == 3
    assert hash_of_model(model.with_values(F_S=29.0)) == hash_of_model(model)


def test_every_model_and_operator_has_a_different_hash():
    models = [example_of(component) for component in (*MODELS.values(), with_slots(MODELS["lugre"], ("asymmetry",)))]
    models += [example_of(operator) for operator in OPERATORS.values()]
    result = [hash_of_model(model) for model in models]
    assert all(result)
    assert len(set(result)) == len(result)


def test_the_hash_depends_on_the_computation_not_on_the_text_of_kernels(tmp_path):
    changed = {
        "commented": TRIAL.replace("    total = 0\n", "    # the sum\n\n    total = 0  # of all\n"),
        "constant": TRIAL.replace("0.01 * total", "0.02 * total"),
        "order": TRIAL.replace("side * (p.F_C + 0.01 * total)", "(p.F_C + 0.01 * total) * side"),
    }
    assert all(text != TRIAL for text in changed.values())
    result = {name: hash_of_model(model_of(HEAD + text, tmp_path)) for name, text in changed.items()}
    plain = hash_of_model(model_of(HEAD + TRIAL, tmp_path))
    assert result.pop("commented") == plain
    assert len({plain, *result.values()}) == 3
    assert hash_of_model(model_of(HEAD.replace("LAYERS = 3", "LAYERS = 2") + TRIAL, tmp_path)) != plain


@pytest.mark.parametrize("to", ["c", "st"])
def test_a_law_has_a_hash_that_is_independent_of_options(tmp_path, to):
    variant = variant_of("cascade", "nothing")
    for name, options in {"plain": {}, "tuned": {"tunable": True}, "single": {"float32": True}}.items():
        br.export(variant, to, tmp_path / name, **options)
        assert hashes(tmp_path / name)[0] == {hash_of_law(law_of(variant))}


def test_gain_compensator_and_delay_change_the_hash_of_a_law():
    variant = variant_of("cascade", "desired")
    rest = [
        variant_of("cascade", "nothing"),
        variant_of("cascade", "measured"),
        variant_of("sliding_mode", "desired"),
        replace(variant, controller=variant.controller.with_values(k_p=40.00000000000001)),
        replace(variant, feedforward=replace(variant.feedforward, gain=0.65)),
        replace(variant, run=replace(variant.run, delay=2)),
    ]
    assert len({hash_of_law(law_of(each)) for each in (variant, *rest)}) == 1 + len(rest)
