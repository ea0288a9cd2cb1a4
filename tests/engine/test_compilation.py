"""What compiled entries are kept under, and who may write where they lie."""

import hashlib
import os
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from bristle.engine import compilation, interpreted, is_interpreted
from bristle.engine.compilation import _EntryCache, _forget_old, _is_own, cache_folder
from bristle.engine.signature import flat


def test_a_product_is_stored_by_name_signature_and_code():
    names = {
        _EntryCache(*key)._file
        for key in (("a", "s", "c"), ("b", "s", "c"), ("a", "t", "c"), ("a", "s", "d"))
    }
    assert len(names) == 4
    assert _EntryCache("a/b", "s", "c")._file.startswith("a-b-")
    assert all(len(name) == len("a-") + 16 + len(".bin") for name in names)


def test_a_product_that_names_a_module_of_another_time_is_compiled_anew(monkeypatch, tmp_path):
    monkeypatch.setattr(compilation, "cache_folder", lambda: tmp_path)
    entry = _EntryCache("run", "()", "code")
    payload = b"cbristle.a_module_that_was_moved\nkernel\n."  # pickled by its name
    (tmp_path / entry._file).write_bytes(hashlib.sha256(payload).digest() + payload)
    assert entry.load_overload(None, SimpleNamespace(refresh=lambda: None)) is None


def test_only_products_unused_for_a_month_are_removed(tmp_path):
    now, day = time.time(), 86400.0
    kept = {
        "new-0123456789abcdef.bin": 29.0,
        "mine.txt": 99.0,
        "short-0123.bin": 99.0,
        "x-0123456789abcdef.bin.txt": 99.0,
    }
    gone = {"old-0123456789abcdef.bin": 31.0, "left.partial": 31.0}
    for name, age in (kept | gone).items():
        (tmp_path / name).write_text("")
        os.utime(tmp_path / name, (now - age * day,) * 2)
    _forget_old(tmp_path)
    assert {item.name for item in tmp_path.iterdir()} == set(kept)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no users here")
@pytest.mark.parametrize(("mode", "mode_after"), [(0o777, 0o700), (0o755, 0o755)])
def test_a_folder_of_the_user_is_closed_to_writers(tmp_path, mode, mode_after):
    tmp_path.chmod(mode)
    assert _is_own(tmp_path) is True
    assert tmp_path.stat().st_mode & 0o777 == mode_after


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no users here")
@pytest.mark.parametrize("make", [Path.touch, lambda path: path.symlink_to(path.parent)])
def test_a_file_or_a_link_is_no_folder_of_the_user(tmp_path, make):
    make(tmp_path / "cache")
    assert not _is_own(tmp_path / "cache")


def test_the_cache_uses_the_given_folder(monkeypatch, tmp_path):
    monkeypatch.setenv("BRISTLE_CACHE_DIR", str(tmp_path))
    folder = cache_folder.__wrapped__()
    assert (folder.parent, folder.is_dir(), "numba" in folder.name) == (tmp_path, True, True)


@pytest.mark.parametrize("value", ["", __file__])
def test_the_cache_is_off_without_a_folder(monkeypatch, value):
    monkeypatch.setenv("BRISTLE_CACHE_DIR", value)
    assert cache_folder.__wrapped__() is None


@pytest.mark.parametrize(("value", "plain"), [("1", True), ("0", False), ("", False)])
def test_interpreted_mode_follows_the_environment_or_a_block(monkeypatch, value, plain):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", value)
    assert is_interpreted() is plain
    with interpreted():
        assert is_interpreted()
    assert is_interpreted() is plain


def test_entries_and_drivers_are_plain_python_in_interpreted_mode():
    def made():
        return 3.0

    with interpreted():
        assert compilation.compiled("made", lambda: made, None) is made
        assert compilation.driver(made) is made


def test_arguments_of_a_driver_are_flat():
    assert flat([1, (2, (3, 4)), 5]) == [1, 2, 3, 4, 5]


def test_an_entry_is_compiled_once_without_interleaving_by_default(monkeypatch):
    requested = []
    monkeypatch.setattr(
        compilation,
        "_compile",
        lambda name, function, kind, code, parts, interleaved: (
            requested.append(interleaved) or function
        ),
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


def test_products_of_different_code_have_distant_symbol_numbers():
    from numba.core.bytecode import FunctionIdentity

    counting, first = FunctionIdentity._unique_ids, []
    for code in ("0" * 15 + "1" + "f" * 48, "0" * 15 + "2" + "0" * 48, "f" * 64):
        with compilation._numbered_from(code):
            first.append([next(FunctionIdentity._unique_ids) for _ in range(3)])
    assert FunctionIdentity._unique_ids is counting
    assert all(numbers == [numbers[0], numbers[0] + 1, numbers[0] + 2] for numbers in first)
    assert first[1][0] - first[0][0] >= 2**16
    assert first[2][0] == (2**64 - 1) * first[0][0]
