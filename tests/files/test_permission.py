"""Code that a file names runs only if this person allowed it."""

import errno
import hashlib
import io
import os
import sys
from pathlib import Path

import pytest

from bristle.core import InputError
from bristle.core.content import content_of
from bristle.core.errors import InputWarning
from bristle.exports.writing import load_target_file
from bristle.files import load_code, load_slot_file, read_model
from bristle.files.permission import allow, is_allowed, state_folder
from bristle.files.user_model import load_checked, load_reader_file

MODEL = "schema = 1\n[friction]\nfile = '{file}'\nF_0 = 1.0\n"


@pytest.fixture
def treacherous(own_model) -> Path:
    """A model that leaves a trace when it is run."""
    trace = own_model.with_name("ran")
    own_model.write_text(
        own_model.read_text() + f"\nimport pathlib; pathlib.Path({str(trace)!r}).touch()\n"
    )
    return own_model


def named(folder: Path, file: str) -> Path:
    path = folder / "model.toml"
    path.write_text(MODEL.format(file=file))
    return path


def test_code_needs_permission_and_is_identified_by_name_and_hash(tmp_path, treacherous):
    checksum = hashlib.sha256(treacherous.read_bytes()).hexdigest()
    with pytest.raises(
        InputError, match=rf"own\.py \(SHA-256 {checksum}\).*--allow-code.*bristle check"
    ):
        read_model(named(tmp_path, "own.py"))
    assert not (tmp_path / "ran").exists()
    with pytest.warns(InputWarning, match=rf"own\.py \(SHA-256 {checksum}\) is run"):
        read_model(named(tmp_path, "own.py"), allow_code=True)
    assert (tmp_path / "ran").exists()
    assert not is_allowed(checksum)  # asked for once is allowed once


def test_a_permission_is_for_this_content_and_this_user_only(tmp_path, treacherous, monkeypatch):
    allow(content_of(treacherous))
    with pytest.warns(InputWarning, match="is run"):
        read_model(named(tmp_path, "own.py"))
    treacherous.write_text(treacherous.read_text() + "# one more letter\n")
    with pytest.raises(InputError, match="needs permission to run"):
        read_model(named(tmp_path, "own.py"))
    allow(content_of(treacherous))
    monkeypatch.setenv("BRISTLE_STATE_DIR", str(tmp_path / "another person"))
    with pytest.raises(InputError, match="needs permission to run"):
        read_model(named(tmp_path, "own.py"))


@pytest.mark.parametrize("where", ["{line}\n{text}", "{text}{line}\n"])
@pytest.mark.parametrize(
    "line", ["allow_code = true", "allow-code = true", "code_sha256 = '{checksum}'"]
)
def test_a_file_cannot_allow_its_own_code(tmp_path, treacherous, line, where):
    path = named(tmp_path, "own.py")
    path.write_text(
        where.format(
            line=line.format(checksum=content_of(treacherous).checksum), text=path.read_text()
        )
    )
    with pytest.raises(InputError):
        read_model(path)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    "name",
    [
        lambda folder, own: os.path.relpath(own, folder),
        lambda folder, own: str(own),
        lambda folder, own: str((folder / "link.py").symlink_to(own) or "link.py"),
        lambda folder, own: str((folder / "deep").symlink_to(own.parent) or "deep/own.py"),
        lambda folder, own: f"x/../../{own.name}",
    ],
)
def test_code_elsewhere_is_not_run_even_where_it_is_allowed_and_in_a_subfolder_it_is(
    tmp_path, treacherous, name
):
    folder = tmp_path / "mailed"
    (folder / "x").mkdir(parents=True)
    allow(content_of(treacherous))
    with pytest.raises(InputError, match="names code in another folder"):
        read_model(named(folder, name(folder, treacherous)), allow_code=True)
    assert not (tmp_path / "ran").exists()
    with pytest.warns(InputWarning, match="is run"):
        assert (
            read_model(
                named(tmp_path.parent, f"{tmp_path.name}/own.py"), allow_code=True
            ).friction.name
            == "own"
        )


@pytest.mark.parametrize(
    "file", ["gone.py", "folder.py", "a\0.py", "x" * 300 + ".py", "loop.py", "pipe.py"]
)
def test_files_without_usable_code_are_refused(tmp_path, monkeypatch, file):
    (tmp_path / "folder.py").mkdir()
    (tmp_path / "loop.py").symlink_to("loop.py")
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.py")
    text = MODEL.format(file=file).replace("\0", "\\u0000").replace("'", '"')
    (tmp_path / "model.toml").write_text(text)
    monkeypatch.setattr("bristle.core.content.SILENCE", 0.1)
    with pytest.raises(InputError):
        read_model(tmp_path / "model.toml", allow_code=True)


@pytest.mark.filterwarnings("error")
def test_a_file_named_in_python_is_asked_for(treacherous):
    load_code(treacherous)
    assert not is_allowed(content_of(treacherous).checksum)  # only a command line remembers


@pytest.mark.parametrize("values", ["no", "False", 1, [0]])
def test_only_true_allows(tmp_path, treacherous, values):
    (tmp_path / "model.toml").write_text(MODEL.format(file=treacherous.name))
    with pytest.raises(InputError, match="allow_code: must be True or False"):
        read_model(tmp_path / "model.toml", allow_code=values)


def refused(folder: Path, code: str | bytes, words: str) -> str:
    """Load code that must be refused, and return why."""
    path = folder / "own.py"
    path.write_bytes(code if isinstance(code, bytes) else code.encode())
    with pytest.raises(InputError, match=words) as caught:
        load_code(path)
    assert str(caught.value).startswith(str(path))
    assert len(str(caught.value).splitlines()) == 1


UMLAUT = "# von Müller\n".encode("latin-1")


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (UMLAUT, r"own\.py: is not valid Python \(invalid or missing encoding"),
        (b"x = 1\n\n\n" + UMLAUT, r"own\.py: is not valid Python \('utf-8' codec"),
        (b"# coding: latin-1\n" + UMLAUT, "defines no friction model"),
        (
            "from bristle.models.friction.dahl import MODEL as dahl\nfrom dataclasses import replace\nMODEL = replace(dahl, name=5)\n",
            "an invalid name for its model; found 5",
        ),
    ],
)
def test_code_must_have_its_declared_encoding_and_a_model_a_name(tmp_path, code, words):
    refused(tmp_path, code, words)


@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_a_stream_that_code_closes_stays_usable(tmp_path, capsys, stream):
    refused(
        tmp_path,
        f"import sys\nprint('said', file=sys.{stream})\nsys.{stream}.close()\n",
        "defines no friction model",
    )
    sys.stdout.write("out")
    sys.stderr.write("err")
    assert capsys.readouterr() == ("out", "said\nerr")


def test_user_code_cannot_change_the_recursion_limit(tmp_path):
    before = sys.getrecursionlimit()
    refused(tmp_path, "import sys\nsys.setrecursionlimit(150)\n", "defines no friction model")
    assert sys.getrecursionlimit() == before


@pytest.mark.parametrize(
    ("name", "found", "mend"),
    [
        ("own.toml", ".toml", r'Read a model file with bristle\.read_model\("own\.toml"\)'),
        ("own.txt", ".txt", r"rename it to own\.py"),
        ("own.PY", ".PY", r"rename it to own\.py"),
        ("own.py.bak", ".bak", r"rename it to own\.py"),
        ("own", "own", r"rename it to own\.py"),
        ("<own>", "<own>", r"rename it to <own>\.py"),
    ],
)
@pytest.mark.parametrize(
    "load", [load_code, load_slot_file, load_checked, load_reader_file, load_target_file]
)
def test_only_files_with_the_ending_py_are_run(treacherous, load, name, found, mend):
    path = treacherous.rename(treacherous.with_name(name))
    text = rf"{name}: is not a Python file, so bristle does not run it; found '{found}', allowed a name that ends with \.py\. "
    for values in (path, content_of(path)):
        with pytest.raises(InputError, match=f"{text}.*{mend}$"):
            load(values)
    assert not treacherous.with_name("ran").exists()


def test_code_without_a_name_is_run(own_model):
    assert (
        load_code(own_model.read_bytes()).name
        == load_code(io.BytesIO(own_model.read_bytes())).name
        == "own"
    )
    with own_model.open("rb") as opened:
        assert load_code(opened).name == "own"


def test_a_permission_that_cannot_be_saved_gives_a_warning(tmp_path, treacherous, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("BRISTLE_STATE_DIR", str(tmp_path / "file"))
    assert not is_allowed(content_of(treacherous).checksum)
    with pytest.warns(InputWarning, match="cannot save the permission"):
        allow(content_of(treacherous))


def test_an_incomplete_record_on_a_full_disk_gives_no_permission(treacherous, monkeypatch):
    def full(path, text, **options):
        path.write_bytes(text.encode()[:3])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.warns(InputWarning, match="No space left"):
        allow(content_of(treacherous))
    assert not is_allowed(content_of(treacherous).checksum)


@pytest.mark.skipif(os.name != "posix", reason="modes of POSIX")
def test_permissions_are_private():
    assert state_folder("allowed-code").stat().st_mode & 0o077 == 0


RAISED = [
    "raise SystemExit",
    "raise SystemExit('now')",
    "raise BaseException('odd')",
    "raise GeneratorExit",
    "import sys; sys.exit(0)",
    "class Odd(BaseException):\n    def __str__(self):\n        raise RuntimeError\nraise Odd",
    "def f(): f()\nf()",
    "raise InputError",
    "import no_such_module",
    "(" * 500 + ")" * 500,
    "x = " + "-" * 100_000 + "1",
    "x = '''",
    "raise ExceptionGroup('several', [ValueError('one')])",
    "assert False",
    "1 / 0",
    "del __builtins__\nopen",
    "\ufeff\ufeff",
    "MODEL = 3",
    "MODEL = None",
    "from bristle.core import FrictionModel\nMODEL = FrictionModel(name='a')",
]


@pytest.mark.parametrize("code", RAISED, ids=range(len(RAISED)))
def test_any_exception_of_code_becomes_a_single_message(tmp_path, code):
    refused(tmp_path, code, ".")


def test_code_beyond_the_limits_of_the_compiler_is_refused_with_the_name_of_the_error(
    tmp_path, monkeypatch
):
    def compiled(*arguments, **options):
        raise MemoryError

    monkeypatch.setattr("bristle.files.user_model.compile", compiled, raising=False)
    # Code of one text runs once in a process: no other test has this one.
    refused(
        tmp_path,
        "more_than_the_compiler_takes = 1\n",
        r"own\.py: is not valid Python \(MemoryError\)",
    )
