"""What tells exports of a model apart from those of another one, and the line on the licence that each of them has."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from tests.exports.native import example_with
from tests.exports.test_laws import variant_of
from tests.exports.test_names import HEAD, TRIAL, model_of

import bristle as br
from bristle.core.experiment import Variant
from bristle.exports.described import copyright_line, hash_of_law, hash_of_model, licence_text
from bristle.exports.law import law_of
from bristle.friction import MODELS, with_slots
from bristle.hysteresis import OPERATORS
from bristle.testing import example_of

ROOT = Path(__file__).parents[2]
VALUES = {"F_C": 22.0, "F_S": 29.0, "v_S": 3e-3, "sigma_0": 2e6, "sigma_1": 1e3, "sigma_2": 40.0}
LUGRE, COULOMB = br.friction.lugre(**VALUES), br.friction.coulomb(F_C=3.0)
LAW, LED = variant_of("cascade", "nothing"), variant_of("cascade", "desired")
TEXT_ENDS = (".c", ".h", ".st", ".txt", ".md", ".xml", ".mjs", ".cu")


def hash_of(subject):
    return hash_of_law(law_of(subject)) if isinstance(subject, Variant) else hash_of_model(subject)


def test_the_licence_is_that_of_the_package():
    assert licence_text() == (ROOT / "LICENSE").read_text(encoding="ascii")


@pytest.mark.parametrize(
    ("subject", "to", "options"),
    [
        *((LUGRE, to, {}) for to in ("c", "st", "cuda", "wasm")),
        (LUGRE, "c", {"tunable": True, "name": "knee"}),
        (LUGRE, "st", {"float32": True, "step": 1e-3}),
        *((COULOMB, "c", {"rest": rest}) for rest in ("held", "middle")),
        *((LAW, to, options) for to in ("c", "st") for options in ({}, {"tunable": True}, {"float32": True})),
    ],
)
def test_all_files_have_the_hash_of_their_model_for_all_options(tmp_path, subject, to, options):
    br.export(subject, to, tmp_path / "out", **options)
    files = [path for path in (tmp_path / "out").iterdir() if path.suffix in TEXT_ENDS]
    heads = ["".join(path.read_text(encoding="utf-8").splitlines(keepends=True)[:9]) for path in files]
    assert {re.search(r"Hash of the model: sha256 ([0-9a-f]{64})", head)[1] for head in heads} == {hash_of(subject)}
    assert all("SPDX-License-Identifier: BSD-3-Clause" in head and copyright_line() in head for head in heads)


def test_hashes_stay_what_they_were_in_every_process():
    digests = {name: hash_of_model(example_with(name))[:12] for name in ("lugre", "stribeck", "gms")}
    assert digests == {"lugre": "0681e09f87ac", "stribeck": "2c9b5ee8b03c", "gms": "91dd668345f8"}


DIFFERENT = {
    "a bit and the kind of axis": [LUGRE, LUGRE.with_values(F_S=29.000000000000004), br.friction.lugre(kind="rotational", **VALUES)],
    "models and operators": [*map(example_of, [*MODELS.values(), with_slots(MODELS["lugre"], ("asymmetry",)), *OPERATORS.values()])],
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
    result = {name: hash_of_model(model_of(HEAD + text, tmp_path)) for name, text in changed.items()}
    plain = hash_of_model(model_of(HEAD + TRIAL, tmp_path))
    assert result.pop("commented") == plain
    assert len({plain, *result.values()}) == 3
    assert hash_of_model(model_of(HEAD.replace("LAYERS = 3", "LAYERS = 2") + TRIAL, tmp_path)) != plain
