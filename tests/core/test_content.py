"""What can be read is read once, up to a limit; what has no end is not begun."""

import io
import os
import pickle
import shutil
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from bristle.core import InputError, content
from bristle.core.content import SIZE_LIMIT, Content, FixedLimit, content_of, size_in_words, size_of
from bristle.files.permission import CODE_LIMIT
from bristle.files.toml import TOML_LIMIT

pytestmark = pytest.mark.skipif(os.name != "posix", reason="pipes and devices of POSIX")


@pytest.fixture
def impatient(monkeypatch):
    monkeypatch.setattr(content, "SILENCE", 0.4)


def test_paths_bytes_and_open_files_can_be_read(tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes(b"a log")
    text = io.StringIO("a log")
    for values in (
        path,
        str(path),
        b"a log",
        bytearray(b"a log"),
        memoryview(b"a log"),
        io.BytesIO(b"a log"),
        text,
    ):
        assert content_of(values).data == b"a log"
    with path.open("rb") as opened:
        result = content_of(opened)
    assert result.origin == content_of(path).origin
    assert content_of(result) is result
    assert pickle.loads(pickle.dumps(result)).origin == result.origin


def test_a_content_does_not_follow_changes_of_its_file(tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes(b"a log")
    result = content_of(path)
    path.write_bytes(b"another")
    assert result.data == b"a log"
    assert result.checksum != content_of(path).checksum


def bound(path):
    with socket.socket(socket.AF_UNIX) as item:
        item.bind(str(path))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda p: None, "no such file"),
        (lambda p: p.mkdir(), "is a folder"),
        (lambda p: p.symlink_to(p), "cannot be read"),
        *(
            (
                lambda p, name=name: p.symlink_to(f"/dev/{name}"),
                r"is a device, not a file\. Name a file",
            )
            for name in ("zero", "null")
        ),
        (lambda p: p.symlink_to("gone"), "is a link to gone, which does not exist"),
        (bound, "is a socket"),
        pytest.param(
            lambda p: p.touch(mode=0),
            "cannot be read",
            marks=pytest.mark.skipif(
                os.name == "posix" and os.getuid() == 0, reason="the superuser reads all"
            ),
        ),
    ],
)
def test_folders_devices_and_missing_files_are_refused_by_name(tmp_path, monkeypatch, make, words):
    monkeypatch.chdir(tmp_path)  # a socket has a short name
    make(Path("log.csv"))
    with pytest.raises(InputError, match=words) as caught:
        content_of("log.csv")
    assert caught.value.path == "log.csv"


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ("a\0b", None),
        ("x" * 300, None),
        ("x/" * 3000, None),
        ("", None),
        ("a" * 5000, "is too long for a file name"),
    ],
    ids=range(5),
)
def test_invalid_file_names_are_refused(values, words):
    with pytest.raises(InputError, match=words):
        content_of(values)


@pytest.mark.parametrize("values", [None, 3, 2.5, [1, 2], object(), {"a": 1}])
def test_objects_without_content_are_refused(values):
    with pytest.raises(InputError, match="axis: must be an axis or an axis file"):
        content_of(values, path="axis", what="an axis or an axis file")


BYTES = bytes(1001)


@pytest.mark.parametrize(
    "source", [lambda path: path, lambda path: BYTES, lambda path: io.BytesIO(BYTES)]
)
def test_the_limit_is_asked_for_before_reading(tmp_path, source):
    path = tmp_path / "log.csv"
    path.write_bytes(BYTES)
    assert len(content_of(source(path), limit=1001).data) == 1001
    with pytest.raises(
        InputError, match=r"has more than 1 kB, more than the limit.*up to 1 kB.*BRISTLE_SIZE_LIMIT"
    ) as caught:
        content_of(source(path), limit=1000)
    assert size_of(caught.value.mend.split('"')[1]) > 1001


def test_a_fixed_limit_cannot_be_raised(tmp_path):
    with pytest.raises(
        InputError, match=r"has more than 1 kB, more than the limit; .*right file"
    ) as caught:
        content_of(BYTES, limit=FixedLimit(1000))
    assert "BRISTLE_SIZE_LIMIT" not in str(caught.value)


def test_the_limit_is_asked_for_while_reading():
    read, write = os.pipe()
    os.write(write, bytes(2000))
    with pytest.raises(InputError, match="more than the limit"):
        content_of(f"/dev/fd/{read}", limit=1000)
    for item in (read, write):
        os.close(item)


def test_of_an_open_file_no_more_is_read_than_the_limit():
    endless = io.BytesIO(bytes(10_000))
    with pytest.raises(InputError):
        content_of(endless, limit=1000)
    assert endless.tell() == 1001


@pytest.mark.slow
def test_a_pipe_is_read_to_its_end_however_slowly_it_speaks(tmp_path, impatient):
    path = tmp_path / "pipe"
    os.mkfifo(path)

    def speak():
        with path.open("wb", buffering=0) as pipe:
            for _ in range(4):
                time.sleep(0.2)
                pipe.write(b"a bit ")

    speaker = threading.Thread(target=speak)
    speaker.start()
    assert content_of(path).data == b"a bit " * 4
    speaker.join()


@pytest.mark.parametrize("said", [b"", b"a bit"])
def test_a_silent_pipe_times_out(tmp_path, impatient, said):
    path, began = tmp_path / "pipe", time.monotonic()
    os.mkfifo(path)
    keeper = os.open(path, os.O_RDWR)
    os.write(keeper, said)
    with pytest.raises(InputError, match="sent no data for"):
        content_of(path)
    os.close(keeper)
    assert time.monotonic() - began < 30.0


@pytest.mark.parametrize(
    "stream", [None, "closed", io.StringIO("t,x")], ids=["none", "closed", "of a notebook"]
)
def test_a_missing_standard_input_is_refused(monkeypatch, stream):
    if stream == "closed":
        stream = io.StringIO()
        stream.close()
    monkeypatch.setattr(sys, "stdin", stream)
    with pytest.raises(InputError, match=r"<stdin>: has no input.*bristle log -"):
        content_of("-")


@pytest.mark.skipif(not shutil.which("bash"), reason="needs bash and git")
def test_process_substitution_of_a_shell_is_read(tmp_path):
    (tmp_path / "log").write_bytes(b"a log\n" * 50_000)
    code = "import sys; from bristle.core.content import content_of; print(content_of(sys.argv[1]).checksum)"
    for words in (
        '"$0" -c "$1" <(cat "$2")',
        'cat "$2" | "$0" -c "$1" -',
        'cat "$2" | "$0" -c "$1" /dev/stdin',
    ):
        ended = subprocess.run(
            ["bash", "-c", words, sys.executable, code, str(tmp_path / "log")],
            capture_output=True,
            text=True,
            check=True,
        )
        assert ended.stdout.strip() == content_of(tmp_path / "log").checksum


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("2 GB", 2e9),
        ("1.5GiB", 1.5 * 2**30),
        ("700 B", 700),
        ("64 kB", 64_000),
        (5, 5),
        (" 3 MB ", 3e6),
    ],
)
def test_a_size_is_read_with_its_unit(text, size):
    assert size_of(text) == size


@pytest.mark.parametrize(
    "text",
    ["", "2", "two GB", "2 Gb", "-1 GB", "0 B", 0, -5, True, None, 1.5, "9" * 5000 + " B", "1e9 B"],
)
def test_invalid_sizes_are_refused(text):
    with pytest.raises(InputError, match="BRISTLE_SIZE_LIMIT"):
        size_of(text, "BRISTLE_SIZE_LIMIT")


@pytest.mark.parametrize("size", [1, 999, 1000, 1_234_567, 5 * 10**8, 2 * 10**9, 7 * 10**13])
def test_sizes_in_words_are_read_again(size):
    assert size_of(size_in_words(size)) == pytest.approx(size, rel=0.06)


def test_the_origin_is_the_file_name_without_its_folder(tmp_path):
    assert Content(tmp_path / "log.h5", b"", "first").origin.name == "log.h5::first"


def test_the_limits_are_those_of_the_documentation():
    page = (Path(__file__).parents[2] / "docs" / "how-to" / "safe-in-any-hands.md").read_text(
        encoding="utf-8"
    )
    for limit, what in (
        (SIZE_LIMIT, "a log, and"),
        (TOML_LIMIT, "a file of settings"),
        (CODE_LIMIT, "a model of your"),
    ):
        (line,) = (
            splitline for splitline in page.splitlines() if splitline.startswith(f"| {what}")
        )
        assert size_of(line.split("|")[2].strip()) == limit
