"""The edge at which files of settings come in: what no file of an axis holds is refused there, with its place."""

import io
import time

import pytest

from bristle.core import InputError
from bristle.core.content import content_of
from bristle.files import read_axis, read_experiment, read_model
from bristle.files.toml import TOML_LIMIT, read_toml

HOSTILE = {
    "a whole number of 5 000 digits": ("x = " + "9" * 5000, "not valid TOML"),
    "a whole number beyond 64 bits": (
        "a = [1, {b = 9223372036854775808}]",
        r"a\[1\]\.b: is too large",
    ),
    "a number beyond all quantities": ("a.b = 1e101", r"a\.b: is too large"),
    "no number": ("a = nan", "a: must be a finite number"),
    "no number in a long list": ("a = [1.0, nan, 2.0]", r"a\[1\]: must be a finite number"),
    "too large in a long list": ("a = [1.0, 2.0, 1e200]", r"a\[2\]: is too large"),
    "arrays in arrays": ("a = " + "[" * 50 + "]" * 50, "nested too deeply"),
    "arrays without end": (
        "a = " + "[" * 100_000,
        "nested too deeply|cannot be read|not valid TOML",
    ),
    "tables in tables": ("a = " + "{b = " * 40 + "1" + "}" * 40, "nested too deeply"),
    "a key of many parts": ("a." * 200_000 + "b = 1", "nested too deeply"),
    "a table of many parts": ("[" + "a." * 100_000 + "b]", "nested too deeply"),
    "a key of many parts inside": ("x = {" + "a . " * 100_000 + "b = 1}", "nested too deeply"),
    "a quoted key of many parts": ('"a".' * 100_000 + "b = 1", "nested too deeply"),
    "a control character": ('a = "x\\u001b[31m"', "a: holds control characters"),
    "a control character in a key": ('"a\\u0000" = 1', "key contains control characters"),
    "no text": (b"\xff\xfe\x00", "not a text file in UTF-8"),
    "no TOML": ("a = = 1", r"not valid TOML.*line 1"),
    "a value twice": ("schema = 1\nschema = 1\n", "at line 2"),
    "a table twice": ("[plant]\n[plant]", "is not valid TOML: Cannot declare 'plant' twice"),
    "a table below twice": (
        "[plant.a]\n[plant.a]",
        r"is not valid TOML: Cannot declare 'plant\.a' twice",
    ),
    "a unit without quotation marks": ("b = 1\na = 3 mm", 'at line 2, .*quotation marks: "3 mm"'),
    "a bracket that is missing": ("b = 1\n[columns\n", r"at line 2, .*The line reads: \[columns"),
    "a quotation mark that is missing": ('name = "EMPS', "is not valid TOML"),
    "too much": (b"#" * (TOML_LIMIT + 1), "more than the limit"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_absurd_content_is_refused_quickly_with_its_place(tmp_path, name):
    text, words = HOSTILE[name]
    path = tmp_path / "axis.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    began = time.process_time()
    with pytest.raises(InputError, match=words) as caught:
        read_toml(path)
    assert time.process_time() - began < 3.0
    assert str(caught.value).startswith(str(path))
    assert len(str(caught.value)) < 1000


@pytest.mark.parametrize("name", ["secret", "passwd.txt", "axis.toml"])
def test_only_lines_of_settings_files_are_quoted(tmp_path, name):
    (tmp_path / name).write_text("password = hunter2\n")
    with pytest.raises(InputError, match="not valid TOML") as caught:
        read_toml(tmp_path / name)
    assert ("hunter2" in str(caught.value)) is (name == "axis.toml")


def test_as_deep_as_it_may_be_and_no_deeper():
    assert read_toml(b"a = " + b"[" * 32 + b"]" * 32)
    assert read_toml(b"a." * 31 + b"b = 1")
    with pytest.raises(InputError, match="nested too deeply"):
        read_toml(b"a = " + b"[" * 33 + b"]" * 33)


def test_valid_content_is_read(tmp_path):
    text = 'v_d = inf\nnote = """two\nlines\t."""\nx = 1e100\nn = 9223372036854775807\ndate = 2026-01-01\n'
    text += "a.b.c = [[1.5], []]\n"
    text += "dots = ['" + "." * 80 + "']\nrow = [" + "0.125, " * 500 + "]\n"
    result = read_toml(text.encode())
    assert (result.data["n"], result.data["a"]) == (2**63 - 1, {"b": {"c": [[1.5], []]}})
    assert read_toml(result.data).data == result.data
    assert read_toml(io.BytesIO(b"\xef\xbb\xbfa = 1\r\nb = 2\r\n")).data == {"a": 1, "b": 2}


@pytest.mark.parametrize(
    "data", [{"a": float("nan")}, {"a": [10**40]}, {"a\0": 1}, {3: 1}, {"a": {"b": "\x07"}}]
)
def test_a_dict_is_examined_as_a_file_is(data):
    with pytest.raises(InputError):
        read_toml(data)


AXIS = {"schema": 1, "kind": "rotational", "columns": {"position": {"column": "q", "unit": "deg"}}}


def test_an_axis_is_read_from_tables(tmp_path):
    text = b"schema = 1\nkind = 'rotational'\ncolumns.position = { column = 'q', unit = 'deg' }\n"
    (tmp_path / "axis.toml").write_bytes(text)
    expected = read_axis(tmp_path / "axis.toml")
    for values in (AXIS, text, io.BytesIO(text), content_of(text), str(tmp_path / "axis.toml")):
        assert read_axis(values) == expected
    assert AXIS == {
        "schema": 1,
        "kind": "rotational",
        "columns": {"position": {"column": "q", "unit": "deg"}},
    }


@pytest.mark.parametrize("read", [read_axis, read_model, read_experiment])
@pytest.mark.parametrize("values", [None, 3, [1], ()])
def test_invalid_sources_are_refused_by_argument_name(read, values):
    with pytest.raises(InputError, match=r"^(axis|model|experiment): must be an? "):
        read(values)
