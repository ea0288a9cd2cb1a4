"""A model of a person's own is tried before it is used: refused by form, warned of by physics."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

from bristle.contract import admit
from bristle.core import InputError, InputWarning
from bristle.engine import response
from bristle.files import load_code
from bristle.models.friction import MODELS, with_slots

EXAMPLE = Path(__file__).parents[2] / "examples" / "quadratic_drag.py"
SPEED = "    v = motion.v\n"


def edited(folder: Path, old: str, new: str):
    text = EXAMPLE.read_text(encoding="utf-8")
    assert old in text
    (folder / "own.py").write_text(text.replace(old, new), encoding="utf-8")
    return load_code(folder / "own.py")


@pytest.mark.parametrize("model", [*MODELS.values(), load_code(EXAMPLE)], ids=lambda one: one.name)
def test_a_sound_model_is_admitted_without_a_word(model):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        admit(model)
        admit(with_slots(model, ["asymmetry"]))


@pytest.mark.parametrize(
    ("new", "said"),
    [
        ("v = undefined_thing * p.F_q", "undefined_thing"),
        ("v = motion.v * p.F_Q", "F_Q"),
        ("v = (motion.v - motion.v) / (motion.v - motion.v)", "ZeroDivisionError"),
    ],
)
def test_a_model_that_cannot_run_is_refused_with_its_file(tmp_path, new, said):
    with pytest.raises(
        InputError,
        match=rf"own\.py: cannot be used, because .*{said}.* Try: bristle check .*own\.py",
    ):
        admit(edited(tmp_path, SPEED, f"    {new}\n"))


@pytest.mark.slow
def test_the_text_read_first_is_tested_even_if_its_file_changes(tmp_path):
    text = EXAMPLE.read_text(encoding="utf-8") + "# one of many copies\n"
    file = tmp_path / "own.py"
    for later in ("", "raise ValueError('another text')\n", None):
        file.write_text(text, encoding="utf-8")
        model = load_code(file)
        file.unlink() if later is None else file.write_text(later, encoding="utf-8")
        admit(model)


def test_an_example_of_something_else_is_refused(tmp_path):
    model = edited(tmp_path, '"F_q": 125.0', '"F_Q": 125.0')
    with pytest.raises(InputError, match=r"own\.py: .*F_Q"):
        admit(model)
    with pytest.raises(InputError, match=r"the example has F_Q.*Did you mean 'F_q'"):
        with_slots(model, ["asymmetry"])


def test_friction_that_creates_energy_causes_a_warning(tmp_path):
    model = edited(tmp_path, "return p.F_C * ", "return -p.F_C * ")
    with pytest.warns(
        InputWarning, match=r"fails the contract.*opposes sliding, dissipates.*bristle check"
    ):
        admit(model(F_C=20.0, F_q=125.0))


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("new", "said"),
    [
        ("v = undefined_thing * p.F_q", "name 'undefined_thing' is not"),
        ("v = motion.v * p.F_Q", "'F_Q'"),
    ],
)
def test_a_compile_error_is_a_fault_of_the_file(tmp_path, new, said):
    model = edited(tmp_path, SPEED, f"    {new}\n")(F_C=20.0, F_q=125.0)
    with pytest.raises(
        InputError, match=rf"own\.py.*: cannot be compiled: .*{said}.*Try: bristle check"
    ):
        response(model, [0.0, 1e-3], 1e-3)
