"""What compiled entries are kept under, and who may write where they lie."""

import os
import time

import pytest

from bristle.engine import compilation, interpreted, is_interpreted
from bristle.engine.compilation import _EntryCache, _forget_old, _is_own, cache_folder
from bristle.engine.signature import flat


def test_a_product_is_kept_under_its_name_its_signature_and_its_code():
    names = {_EntryCache(*key)._file for key in (("a", "s", "c"), ("b", "s", "c"), ("a", "t", "c"), ("a", "s", "d"))}
    assert len(names) == 4
    assert _EntryCache("a/b", "s", "c")._file.startswith("a-b-")
    assert all(len(name) == len("a-") + 16 + len(".bin") for name in names)


def test_what_nobody_has_used_for_a_month_is_removed_and_nothing_else(tmp_path):
    now, day = time.time(), 86400.0
    kept = {"new-0123456789abcdef.bin": 29.0, "mine.txt": 99.0, "short-0123.bin": 99.0, "x-0123456789abcdef.bin.txt": 99.0}
    gone = {"old-0123456789abcdef.bin": 31.0, "left.partial": 31.0}
    for name, age in (kept | gone).items():
        (tmp_path / name).write_text("")
        os.utime(tmp_path / name, (now - age * day,) * 2)
    _forget_old(tmp_path)
    assert {item.name for item in tmp_path.iterdir()} == set(kept)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no users here")
def test_a_folder_that_others_can_write_into_is_closed(tmp_path):
    tmp_path.chmod(0o777)
    assert _is_own(tmp_path) is True
    assert tmp_path.stat().st_mode & 0o777 == 0o700
    tmp_path.chmod(0o755)
    assert _is_own(tmp_path) is True
    assert tmp_path.stat().st_mode & 0o777 == 0o755
    file, link = tmp_path / "file", tmp_path / "link"
    file.write_text("")
    link.symlink_to(tmp_path)
    assert not _is_own(file)
    assert not _is_own(link)


def test_the_cache_lies_where_it_is_told_or_nowhere(monkeypatch, tmp_path):
    monkeypatch.setenv("BRISTLE_CACHE_DIR", str(tmp_path))
    folder = cache_folder.__wrapped__()
    assert folder.parent == tmp_path
    assert folder.is_dir()
    assert "numba" in folder.name
    monkeypatch.setenv("BRISTLE_CACHE_DIR", "")
    assert cache_folder.__wrapped__() is None
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("BRISTLE_CACHE_DIR", str(tmp_path / "file"))
    assert cache_folder.__wrapped__() is None


@pytest.mark.parametrize(("value", "plain"), [("1", True), ("0", False), ("", False)])
def test_python_interprets_where_the_compiler_is_switched_off_or_in_a_block(monkeypatch, value, plain):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", value)
    assert is_interpreted() is plain
    with interpreted():
        assert is_interpreted()
    assert is_interpreted() is plain


def test_an_entry_is_plain_in_a_block_and_a_driver_is_itself():
    def made():
        return 3.0

    with interpreted():
        assert compilation.compiled("made", lambda: made, None) is made
        assert compilation.driver(made) is made


def test_arguments_of_a_driver_lie_in_a_row():
    assert flat([1, (2, (3, 4)), 5]) == [1, 2, 3, 4, 5]


def test_an_entry_is_compiled_once_one_vector_at_a_time_unless_it_asks_for_more(monkeypatch):
    requested = []
    monkeypatch.setattr(
        compilation, "_compile", lambda name, function, kind, code, parts, interleaved: requested.append(interleaved) or function
    )
    monkeypatch.setattr(compilation, "_entries", {})
    monkeypatch.setattr(compilation, "fingerprint", lambda *parts: "0")
    monkeypatch.setattr(compilation, "handed_over", lambda function, kind: function)
    monkeypatch.setattr(compilation, "is_interpreted", lambda: False)

    def made():
        return 3.0

    first = compilation.compiled("plain", lambda: made, None)
    assert compilation.compiled("plain", lambda: pytest.fail("made again"), None) is first is made
    compilation.compiled("lanes", lambda: made, None, (), 4)
    compilation.compiled("plain", lambda: made, None, (len,))  # of other parts: another entry
    assert requested == [1, 4, 1]


def test_what_is_compiled_of_two_codes_has_numbers_far_apart():
    from numba.core.bytecode import FunctionIdentity

    counting, first = FunctionIdentity._unique_ids, []
    for code in ("0" * 15 + "1" + "f" * 48, "0" * 15 + "2" + "0" * 48, "f" * 64):
        with compilation._numbered_from(code):
            first.append([next(FunctionIdentity._unique_ids) for _ in range(3)])
    assert FunctionIdentity._unique_ids is counting
    assert all(numbers == [numbers[0], numbers[0] + 1, numbers[0] + 2] for numbers in first)
    assert first[1][0] - first[0][0] >= 2**16
    assert first[2][0] == (2**64 - 1) * first[0][0]
