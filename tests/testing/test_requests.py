"""What every target of the export is tried with, and how it is judged."""

import math
from types import SimpleNamespace

import pytest

from bristle.core.errors import InputError
from bristle.testing import targets
from bristle.testing.check import UnmetError
from bristle.testing.targets import described_target, example_requests, notes_in_words, same_bytes_twice, writes_or_refuses


def test_models_of_both_kinds_are_tried_with_an_axis_file_and_without():
    requests = example_requests()
    assert [request.model.kind for request in requests.values()] == ["translational", "translational", "rotational", "translational"]
    assert [request.axis is not None for request in requests.values()] == [False, True, False, False]
    assert [request.speed for request in requests.values()] == [0.2, 0.2, 5.0, 0.0]
    assert [request.plant is not None for request in requests.values()] == [False, True, True, False]
    assert {request.name for request in requests.values()} == {"axis_x"}


def test_an_interval_lies_evenly_around_its_value():
    request = example_requests()["coulomb_viscous"]
    low, high = request.source.uncertainty["F_C"]["interval"]
    assert low < high
    assert 0.5 * (low + high) == request.model.values["F_C"]
    assert request.model.values["F_v"] == 100.0


def test_directions_of_an_example_differ_and_keep_their_order():
    values = example_requests()["stribeck+asymmetry with an axis file"].model.values
    for name in ("F_C", "F_S", "F_v"):
        assert values[f"{name}_pos"] > values[f"{name}_neg"]
    assert values["F_S_neg"] > values["F_C_pos"]
    assert values["offset"] == 1.5
    cogging = example_requests()["lugre, rotational, on a motor that cogs"].plant.values
    assert cogging["motor_turn"] == pytest.approx(2.0 * math.pi)


def test_no_number_of_an_example_is_the_same_without_being_written():
    for request in example_requests().values():
        assert all(value != 0.0 for name, value in request.model.values.items() if name not in ("offset", "sigma_1", "sigma_2", "v_d"))
    assert example_requests()["coulomb_viscous without a speed"].model == example_requests()["coulomb_viscous"].model


def product(notes=(), **files):
    return SimpleNamespace(files=files, notes=notes)


def trial(first=None, again=None, refused=None, description="writes numbers"):
    target = SimpleNamespace(description=description)
    written = {} if first is None else first
    return SimpleNamespace(target=target, first=written, refused=refused or {}, written=lambda: written if again is None else again)


@pytest.mark.parametrize("description", ["", "  ", "two\nlines"])
def test_a_target_is_described_in_a_line(description):
    assert described_target(trial()).detail == "writes numbers"
    with pytest.raises(UnmetError, match="the description is"):
        described_target(trial(description=description))


def test_a_target_writes_a_model_at_least():
    refused = {"b": InputError("no")}
    assert writes_or_refuses(trial({"a": product()}, refused=refused)).detail == "1 of 2 models; refuses b"
    with pytest.raises(UnmetError, match="it refuses every model: b, no"):
        writes_or_refuses(trial(refused=refused))


def test_a_target_writes_the_same_bytes_twice():
    first = {"a": product(x="1", y="2")}
    assert same_bytes_twice(trial(first)).detail == "2 files"
    for again in ({}, {"a": product(x="1")}, {"a": product(x="1", y="3")}, {"a": product(("note",), x="1", y="2")}):
        with pytest.raises(UnmetError, match=r"of a differs in the second call"):
            same_bytes_twice(trial(first, again))
    assert {request.dt for request in example_requests().values()} == {targets.STEP} == {1e-3}


@pytest.mark.parametrize(
    ("note", "fits"), [("two words", True), ("word", False), (f"a {398 * 'x'}", True), (f"a {399 * 'x'}", False), ("a tab\there", False)]
)
def test_a_note_is_a_line_of_words_of_400_letters_at_most(note, fits):
    item = trial({"a": product((note,))})
    if fits:
        assert notes_in_words(item).detail == "1 notes"
    else:
        with pytest.raises(UnmetError, match=r"a note is .*") as caught:
            notes_in_words(item)
        assert caught.value.advice == "Write each in one line of 400 letters at most, in words"
