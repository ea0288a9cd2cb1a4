"""The same bits on other targets, in emulators of them; every model is tried by `tests.exports.other_targets`."""

import shutil
from pathlib import Path

import pytest
from tests.exports.instructions import counted
from tests.exports.native import example_with
from tests.exports.other_targets import TARGETS, answer, examples

from bristle.exports import subject


@pytest.mark.parametrize(
    ("core", "model", "mean", "worst", "code"),
    [
        ("Cortex-M7", "lugre", 250, 300, 2500),
        ("Cortex-M7", "preisach_lugre", 900, 9000, 18000),
        ("Cortex-M4F", "preisach_lugre", 1200, 6000, 16000),
    ],
)
def test_a_step_fits_the_instruction_budget_of_a_drive(core, model, mean, worst, code, tmp_path):
    if TARGETS[core].lacking:
        pytest.skip(f"needs {TARGETS[core].lacking}")
    result = counted(example_with(model), core, tmp_path / "out", steps=20_000)
    assert result.mean < mean
    assert result.worst < worst
    assert result.code < code
    assert result.stack <= 1024


def test_different_bits_are_reported(monkeypatch, tmp_path):
    target = TARGETS["clang"]._replace(build=("cc",))
    if shutil.which("cc") is None:
        pytest.skip("needs a C compiler")
    monkeypatch.setattr(subject, "FNV_PRIME", subject.FNV_PRIME + 2)
    text = answer(target, examples()["plain lugre"], Path(tmp_path) / "out")
    assert "expected" in text
