"""What is refused says where, what was found, what is allowed and what to do, and no more than can be read."""

import datetime

import numpy as np
import pytest

from bristle.core.errors import InputError, close_names, did_you_mean, error_text, in_one_line, located, shortened


def test_a_message_has_its_parts_in_order():
    error = InputError("is wrong", path="a.b", value=3.0, allowed="2 to 4", mend="Write 3")
    assert str(error) == "a.b: is wrong; found 3.0, allowed 2 to 4. Write 3"
    assert str(InputError("is wrong")) == "is wrong"
    assert str(InputError("is wrong", value=0)) == "is wrong; found 0"
    assert str(InputError("is wrong", allowed="1")) == "is wrong; allowed 1"
    assert (error.exit_code, isinstance(error, ValueError)) == (2, True)


@pytest.mark.parametrize(("part", "most"), [("path", 400), ("message", 800), ("allowed", 1200), ("mend", 800)])
def test_long_parts_of_a_message_are_shortened(part, most):
    def reported(length):
        parts = {"message": "is wrong"} | {part: "x" * length}
        return str(InputError(**parts))

    assert "x" * most in reported(most)
    assert "..." not in reported(most)
    assert "x" * (most - 3) + "..." in reported(most + 1)
    assert reported(most + 1).count("x") == most - 3


def test_values_are_shortened_and_arrays_are_shown_by_shape():
    def result(value):
        return str(InputError("is wrong", value=value)).partition("found ")[2]

    assert result("y" * 58) == repr("y" * 58)
    assert result("y" * 59) == "'" + "y" * 56 + "..."
    assert result(np.zeros((40, 3))) == "an array of shape (40, 3)"
    assert result(np.zeros(2)) == "array([0., 0.])"
    assert result(list(range(20))) == shortened(repr(list(range(20))), 60)
    assert result(list(range(21))) == "[0, 1, 2, 3, 4, 5, ...]"
    assert result(datetime.date(2024, 3, 1)) == "2024-03-01"

    class Silent:
        def __repr__(self):
            raise RuntimeError

    assert result(Silent()) == "a value of type Silent"


def test_an_error_is_located_before_its_own_place():
    with pytest.raises(InputError) as reported, located("axis.toml", mend="Look there"):
        raise InputError("is wrong", path="plant.mass", value=1.0)
    assert str(reported.value) == "axis.toml: plant.mass: is wrong; found 1.0. Look there"
    assert InputError("is wrong").at("a").path == "a"
    assert InputError("is wrong", path="b").at().path == "b"


def test_names_that_are_meant_are_close_and_not_too_long_or_too_many():
    assert close_names("POSITON", ["time", "Position"]) == ["Position"]
    assert close_names("p" * 80, ["p" * 80]) == ["p" * 80]
    assert close_names("p" * 81, ["p" * 81]) == close_names("p" * 80, ["p" * 81]) == []
    many = [f"{number:08d}" for number in range(10_000)]
    assert close_names("position", [*many[1:], "position"]) == ["position"]
    assert close_names("position", [*many, "position"]) == []
    assert did_you_mean("xyz", ["position"]) == ""


def test_messages_are_a_single_printable_line():
    assert in_one_line("a\nb\x07") == "a b\\x07"
    assert in_one_line("plain") == "plain"
    assert error_text(ValueError("two\n  lines")) == "two lines"
    assert (shortened("abcdef", 6), shortened("abcdefg", 6)) == ("abcdef", "abc...")
