"""What every target of the export is tried with, and how it is judged."""

import math
from types import SimpleNamespace

import pytest

from bristle.contract import targets
from bristle.contract.check import UnmetError
from bristle.contract.targets import (
    described_target,
    example_requests,
    notes_in_words,
    same_bytes_twice,
    writes_or_refuses,
)
from bristle.core.errors import InputError

REQUESTS = example_requests()
PLAIN, LEVELS = (
    REQUESTS["coulomb_viscous"],
    REQUESTS["stribeck+asymmetry with an axis file"].model.values,
)
COGS = REQUESTS["lugre, rotational, on a motor that cogs"]
MAY_VANISH = ("offset", "sigma_1", "sigma_2", "v_d")


@pytest.mark.parametrize(
    ("numbers", "expected"),
    [
        (
            [request.model.kind for request in REQUESTS.values()],
            ["translational", "translational", "rotational", "translational"],
        ),
        ([request.axis is not None for request in REQUESTS.values()], [False, True, False, False]),
        ([request.speed for request in REQUESTS.values()], [0.2, 0.2, 5.0, 0.0]),
        ([request.plant is not None for request in REQUESTS.values()], [False, True, True, False]),
        (
            [(request.name, request.dt) for request in REQUESTS.values()],
            [("axis_x", targets.STEP)] * 4,
        ),
        # An interval lies evenly around its value.
        (0.5 * sum(PLAIN.source.uncertainty["F_C"]["interval"]), PLAIN.model.values["F_C"]),
        (PLAIN.model.values["F_v"], 100.0),
        (REQUESTS["coulomb_viscous without a speed"].model, PLAIN.model),
        # Directions differ and keep their order.
        (
            [LEVELS[f"{name}_pos"] > LEVELS[f"{name}_neg"] for name in ("F_C", "F_S", "F_v")],
            [True] * 3,
        ),
        ((LEVELS["F_S_neg"] > LEVELS["F_C_pos"], LEVELS["offset"]), (True, 1.5)),
        (COGS.plant.values["motor_turn"], pytest.approx(2.0 * math.pi)),
        # No number is the same without being written.
        (
            [
                (r.name, n)
                for r in REQUESTS.values()
                for n, value in r.model.values.items()
                if value == 0.0 and n not in MAY_VANISH
            ],
            [],
        ),
    ],
)
def test_every_target_is_tried_with_models_of_both_kinds(numbers, expected):
    assert numbers == expected


def test_an_interval_of_an_example_has_a_width():
    low, high = PLAIN.source.uncertainty["F_C"]["interval"]
    assert low < high
    assert targets.STEP == 1e-3


def product(notes=(), **files):
    return SimpleNamespace(files=files, notes=notes)


def trial(first=None, again=None, refused=None, description="writes numbers"):
    target = SimpleNamespace(description=description)
    written = {} if first is None else first
    return SimpleNamespace(
        target=target,
        first=written,
        refused=refused or {},
        written=lambda: written if again is None else again,
    )


@pytest.mark.parametrize("description", ["", "  ", "two\nlines"])
def test_a_target_is_described_in_a_line(description):
    assert described_target(trial()).detail == "writes numbers"
    with pytest.raises(UnmetError, match="the description is"):
        described_target(trial(description=description))


def test_a_target_writes_a_model_at_least():
    refused = {"b": InputError("no")}
    assert (
        writes_or_refuses(trial({"a": product()}, refused=refused)).detail
        == "1 of 2 models; refuses b"
    )
    with pytest.raises(UnmetError, match="it refuses every model: b, no"):
        writes_or_refuses(trial(refused=refused))


def test_a_target_writes_the_same_bytes_twice():
    first = {"a": product(x="1", y="2")}
    assert same_bytes_twice(trial(first)).detail == "2 files"
    for again in (
        {},
        {"a": product(x="1")},
        {"a": product(x="1", y="3")},
        {"a": product(("note",), x="1", y="2")},
    ):
        with pytest.raises(UnmetError, match=r"of a differs in the second call"):
            same_bytes_twice(trial(first, again))


@pytest.mark.parametrize(
    ("note", "fits"),
    [
        ("two words", True),
        ("word", False),
        (f"a {398 * 'x'}", True),
        (f"a {399 * 'x'}", False),
        ("a tab\there", False),
    ],
)
def test_a_note_is_a_line_of_words_of_400_letters_at_most(note, fits):
    item = trial({"a": product((note,))})
    if fits:
        assert notes_in_words(item).detail == "1 notes"
    else:
        with pytest.raises(UnmetError, match=r"a note is .*") as caught:
            notes_in_words(item)
        assert caught.value.advice == "Write each in one line of 400 letters at most, in words"
