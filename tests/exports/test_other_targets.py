"""The same bits on other targets, in emulators of them; every model is tried by `tests.exports.other_targets`."""

import shutil
from pathlib import Path

import pytest
from tests.exports.other_targets import TARGETS, answer, examples

from bristle.exports import walk


@pytest.mark.parametrize("name", TARGETS)
@pytest.mark.parametrize("model", ["plain lugre", "sided preisach_lugre"])
def test_the_self_test_finds_the_same_bits(name, model, tmp_path):
    target = TARGETS[name]
    if target.lacking:
        pytest.skip(f"needs {target.lacking}")
    assert answer(target, examples()[model], tmp_path / "out") == ""


def test_other_bits_are_told(monkeypatch, tmp_path):
    target = TARGETS["clang"]._replace(build=("cc",))
    if shutil.which("cc") is None:
        pytest.skip("needs a C compiler")
    monkeypatch.setattr(walk, "FNV_PRIME", walk.FNV_PRIME + 2)
    said = answer(target, examples()["plain lugre"], Path(tmp_path) / "out")
    assert "expected" in said
