"""What is refused says where, what was found, what is allowed and what to do, and no more than can be read."""

import datetime

import numpy as np
import pytest

from bristle.core.errors import (
    InputError,
    close_names,
    did_you_mean,
    error_text,
    in_one_line,
    located,
    shortened,
)


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (
            InputError("is wrong", path="a.b", value=3.0, allowed="2 to 4", mend="Write 3"),
            "a.b: is wrong; found 3.0, allowed 2 to 4. Write 3",
        ),
        (InputError("is wrong"), "is wrong"),
        (InputError("is wrong", value=0), "is wrong; found 0"),
        (InputError("is wrong", allowed="1"), "is wrong; allowed 1"),
        (InputError("is wrong").at("a"), "a: is wrong"),
        (InputError("is wrong", path="b").at(), "b: is wrong"),
    ],
)
def test_a_message_has_its_parts_in_order(error, text):
    assert str(error) == text
    assert (error.exit_code, isinstance(error, ValueError)) == (2, True)


@pytest.mark.parametrize(
    ("part", "most"), [("path", 400), ("message", 800), ("allowed", 1200), ("mend", 800)]
)
def test_long_parts_of_a_message_are_shortened(part, most):
    whole, cut = (
        str(InputError(**{"message": "is wrong"} | {part: "x" * length}))
        for length in (most, most + 1)
    )
    assert "x" * most in whole
    assert "..." not in whole
    assert "x" * (most - 3) + "..." in cut
    assert cut.count("x") == most - 3


class Silent:
    def __repr__(self):
        raise RuntimeError


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("y" * 58, repr("y" * 58)),
        ("y" * 59, "'" + "y" * 56 + "..."),
        (np.zeros((40, 3)), "an array of shape (40, 3)"),
        (np.zeros(2), "array([0., 0.])"),
        (list(range(20)), shortened(repr(list(range(20))), 60)),
        (list(range(21)), "[0, 1, 2, 3, 4, 5, ...]"),
        (datetime.date(2024, 3, 1), "2024-03-01"),
        (Silent(), "a value of type Silent"),
    ],
)
def test_values_are_shortened_and_arrays_are_shown_by_shape(value, text):
    assert str(InputError("is wrong", value=value)).partition("found ")[2] == text


def test_an_error_is_located_before_its_own_place():
    with pytest.raises(InputError) as reported, located("axis.toml", mend="Look there"):
        raise InputError("is wrong", path="plant.mass", value=1.0)
    assert str(reported.value) == "axis.toml: plant.mass: is wrong; found 1.0. Look there"


MANY = [f"{number:08d}" for number in range(10_000)]


@pytest.mark.parametrize(
    ("name", "known", "close"),
    [
        ("POSITON", ["time", "Position"], ["Position"]),
        ("p" * 80, ["p" * 80], ["p" * 80]),
        ("p" * 81, ["p" * 81], []),
        ("p" * 80, ["p" * 81], []),
        ("position", [*MANY[1:], "position"], ["position"]),
        ("position", [*MANY, "position"], []),
    ],
    ids=range(6),
)
def test_names_that_are_meant_are_close_and_not_too_long_or_too_many(name, known, close):
    assert close_names(name, known) == close


@pytest.mark.parametrize(
    ("result", "text"),
    [
        (in_one_line("a\nb\x07"), "a b\\x07"),
        (in_one_line("plain"), "plain"),
        (error_text(ValueError("two\n  lines")), "two lines"),
        (shortened("abcdef", 6), "abcdef"),
        (shortened("abcdefg", 6), "abc..."),
        (did_you_mean("xyz", ["position"]), ""),
    ],
)
def test_messages_are_a_single_printable_line(result, text):
    assert result == text
