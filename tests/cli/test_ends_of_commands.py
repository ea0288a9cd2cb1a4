"""How a command ends, each with its code and a line that says why, and how tables are printed."""

import errno
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from contextlib import suppress
from importlib import import_module

import pytest

from bristle.cli import signals, terminal
from bristle.cli.main import LEAST_MEMORY, main, refuse_little_memory
from bristle.cli.signals import SENTENCES, SignalledError, ended_by_signals
from bristle.cli.terminal import (
    complain,
    one_line,
    report,
    say,
    show,
    show_table,
    warnings_as_lines,
)
from bristle.core.errors import InputError
from bristle.report.table import Table


@pytest.fixture
def reported(capsys):
    """What was told on the standard error stream, without the name of the program."""
    return lambda: capsys.readouterr().err.removeprefix("bristle: ").rstrip("\n")


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (KeyboardInterrupt(), 130, "interrupted"),
        (KeyboardInterrupt("stopped early"), 130, "stopped early"),
        (SignalledError(signal.SIGTERM), 143, "terminated"),
        (InputError("is missing", path="axis"), 2, "axis: is missing"),
        (
            MemoryError(),
            2,
            "there is not enough memory for this command. Use a shorter log or experiment",
        ),
        (OSError(errno.EMFILE, "Too many open files"), 2, "bristle cannot open more files"),
        (
            ImportError("no libx", name="scipy"),
            2,
            "bristle cannot load a required library: no libx. Install the library again",
        ),
    ],
)
def test_an_error_has_its_code_and_a_line(reported, error, code, words):
    assert report(error) == code
    assert reported().startswith(words)


@pytest.mark.parametrize(
    ("arguments", "stays"),
    [
        ("run x.toml --out run", True),
        ("run x.toml --out=run", True),
        ("demo", True),
        ("paper", True),
        ("models", False),
    ],
)
def test_a_full_standard_output_is_reported(reported, monkeypatch, arguments, stays):
    def full(arguments):
        raise OSError(errno.ENOSPC, "No space left on device")

    let_go = []
    monkeypatch.setattr(terminal, "let_go", let_go.append)
    monkeypatch.setattr(import_module("bristle.cli.application"), "run", full)
    assert main(arguments.split()) == 2
    line = reported()
    assert line.startswith(
        "bristle cannot write to the standard output: No space left on device. Free disk space, or redirect the output"
    )
    assert line.endswith("The folder of results is complete") is stays
    assert let_go == [sys.stdout]


def test_a_reader_that_has_gone_is_no_error(reported, monkeypatch):
    let_go = []
    monkeypatch.setattr(terminal, "let_go", let_go.append)
    assert report(BrokenPipeError()) == 0
    assert (reported(), let_go) == ("", [sys.stdout])


def raised_by(call):
    """The error that a call raises, with its traceback."""
    with pytest.raises(Exception) as caught:
        call()
    return caught.value


FAULTS = (
    RuntimeError("x" * 1000),
    OSError(errno.ENOSPC, "no room", "a file"),
    ImportError("no y", name="bristle.y"),
)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_bristle_is_reported_with_its_details(reported, tmp_path, monkeypatch, fault):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))

    def fails():
        raise fault

    assert report(raised_by(fails)) == 70
    line = reported()
    assert line.startswith(f"this is a fault of bristle, not yours: {type(fault).__name__}: ")
    assert len(line) < 800
    (details,) = tmp_path.iterdir()
    assert line.endswith(f"Please report it with the details in {details}")
    text = details.read_text()
    assert text.startswith("command: ")
    assert "Traceback" in text


def test_a_fault_of_user_code_is_reported_with_its_line(reported, tmp_path):
    own = tmp_path / "own.py"
    own.write_text("\ndef law():\n    raise ZeroDivisionError('by nought')\n")
    module = {"__name__": "bristle_user_own"}
    exec(compile(own.read_text(), str(own), "exec"), module)
    assert report(raised_by(module["law"])) == 2
    assert (
        reported()
        == f"{own}, line 3: stops with ZeroDivisionError: by nought. Try: bristle check {own}"
    )


def test_a_line_is_a_line(capsys):
    assert one_line("a\nb\tc \x1b[31m d") == one_line("a b c \x1b[31m d")
    assert "\n" not in one_line("a\nb")
    complain("first\nsecond")
    assert capsys.readouterr().err == "bristle: first second\n"


def test_paragraphs_and_tables_are_printed_in_order(capsys):
    say("3\u00a0µm")
    assert capsys.readouterr().out == "3 µm\n"
    show("first", None, Table("T", ("Name", "Value"), [("a", "1")]), "last")
    text = capsys.readouterr().out
    assert text.index("first") < text.index("T") < text.index("a") < text.index("last")


def test_the_widest_column_is_narrowed_first(capsys, monkeypatch):
    monkeypatch.setattr(terminal, "PIPE_WIDTH", 40)
    show_table(
        Table("T", ("Name", "What"), [("abcdef", "one two three four five six seven eight nine")])
    )
    lines = [line for line in capsys.readouterr().out.splitlines() if "abcdef" in line]
    assert len(lines) == 1
    assert "one two three" in lines[0]


def test_numbers_are_right_aligned_and_words_left_aligned(capsys):
    show_table(Table("T", ("Name", "Value"), [("a", "1"), ("bcd", "234")]))
    lines = capsys.readouterr().out.splitlines()
    rows = [line.rstrip() for line in lines if line.strip().startswith(("a", "bcd"))]
    assert rows[0].index("a") == rows[1].index("bcd")
    assert len(rows[0]) == len(rows[1])


def test_a_warning_is_printed_once_and_its_fault_is_kept(capsys):
    fault = ZeroDivisionError("x")
    caused = UserWarning("with a cause")
    caused.__cause__ = fault
    with warnings_as_lines() as faults:
        for _ in range(2):
            warnings.warn("once\nonly", UserWarning, stacklevel=1)
        warnings.warn(caused, stacklevel=1)
    assert (
        capsys.readouterr().err == "bristle: warning: once only\nbristle: warning: with a cause\n"
    )
    assert faults == [fault]


@pytest.mark.parametrize(
    ("number", "code", "words"),
    [(None, 70, "this is a fault of bristle"), (signal.SIGTERM, 143, "a figure is not drawn")],
)
def test_an_error_that_a_library_makes_of_a_signal_is_no_fault(
    monkeypatch, capsys, number, code, words
):
    def work(arguments):
        if number is not None:
            with suppress(KeyboardInterrupt):
                signal.raise_signal(number)
        caused = UserWarning("a figure is not drawn")
        caused.__cause__ = ValueError("Invalid affine transformation matrix")
        warnings.warn(caused, stacklevel=1)
        return 0

    monkeypatch.setattr(import_module("bristle.cli.application"), "run", work)
    before = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        assert main(["models"]) == code
    finally:
        signal.signal(signal.SIGTERM, before)
    last = capsys.readouterr().err.splitlines()[-1]
    assert words in last


# --- signals --------------------------------------------------------------------------------------------------------

needs_main_thread = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")


@needs_main_thread
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGINT"])
def test_a_signal_ends_a_block_with_its_code_and_words(name):
    number = getattr(signal, name)
    handler = signal.default_int_handler if name == "SIGINT" else signal.SIG_DFL
    outside = signal.signal(number, handler)  # a shell may have it ignored, in the background
    try:
        with ended_by_signals() as block:
            assert block.exit_code is None
            block.check()
            with pytest.raises(SignalledError, match=SENTENCES[name]) as ended:
                signal.raise_signal(number)
        assert ended.value.exit_code == block.exit_code == 128 + number
        assert signal.getsignal(number) == handler
    finally:
        signal.signal(number, outside)


@needs_main_thread
def test_a_signal_that_comes_again_within_a_second_is_the_same():
    with ended_by_signals() as block:
        with pytest.raises(SignalledError):
            block._raise(signal.SIGTERM, None)
        block._raise(signal.SIGTERM, None)
        block._first = (signal.SIGTERM, time.monotonic() - 1.1)
        with pytest.raises(SignalledError):
            block._raise(signal.SIGTERM, None)
        with pytest.raises(SignalledError):
            block.check()


@needs_main_thread
def test_a_signal_that_is_sent_again_ends_no_later_command():
    with ended_by_signals() as block:
        block._send_again(signal.SIGTERM)
    with ended_by_signals():
        time.sleep(0.05)


@pytest.mark.fast_cases(1)
@needs_main_thread
@pytest.mark.parametrize(
    ("name", "patience", "code"), [("SIGTERM", 0.3, 143), ("SIGTERM", 60.0, 0), ("SIGINT", 0.3, 0)]
)
def test_a_lock_does_not_block_a_terminated_process(name, patience, code):
    program = f"""
import signal, threading
from bristle.cli import signals
signals.PATIENCE = {patience}
lock = threading.Lock()
with signals.ended_by_signals():
    try:
        signal.signal(signal.SIGINT, signals.signal.getsignal(signal.SIGTERM))
        signal.raise_signal(signal.{name})
    except KeyboardInterrupt:
        lock.acquire()
        lock.acquire(timeout=1.5)
"""
    ended = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False
    )
    assert (ended.returncode, ended.stderr) == (code, "bristle: terminated\n" if code else "")


@needs_main_thread
def test_a_signal_that_is_ignored_stays_so():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with ended_by_signals():
            os.kill(os.getpid(), signal.SIGHUP)
            assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_signals_are_unchanged_outside_the_main_thread():
    result = []

    def work():
        with ended_by_signals() as block:
            result.append((dict(block._before), block.exit_code))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert result == [({}, None)]


def test_modules_are_imported_by_frames_of_the_interpreter():
    assert not signals.is_importing(sys._getframe())
    assert not signals.is_importing(None)


# --- memory ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("limit", "refused"), [(LEAST_MEMORY - 1, True), (LEAST_MEMORY, False), (-1, False)]
)
@pytest.mark.parametrize("name", ["RLIMIT_AS", "RLIMIT_DATA"])
def test_too_little_memory_is_refused(monkeypatch, limit, refused, name):
    resource = pytest.importorskip("resource")
    limits = {getattr(resource, name): limit}
    monkeypatch.setattr(resource, "getrlimit", lambda number: (limits.get(number, -1), -1))
    if not refused:
        refuse_little_memory()
        return
    with pytest.raises(
        InputError,
        match=rf"ulimit -{'v' if name == 'RLIMIT_AS' else 'd'} 524287: is too little.*524288 or more",
    ):
        refuse_little_memory()


# --- tables: whatever the width of a terminal, nothing is cut off ----------------------------------------------------


HEADS = (
    "Model",
    "Parameters",
    "Held-out error [%]",
    "Spread over blocks [%]",
    "Error of the fit [%]",
    "Not identified",
)
ROWS = (
    ("coulomb_viscous+asymmetry", "5", "3.13", "± 0.18", "3.11", "gap, sigma_2_pos, sigma_2_neg"),
    ("coulomb_viscous", "4", "4.13", "± 0.20", "4.08", "–"),
)


@pytest.mark.parametrize("width", [40, 72, 83, 84, 85, 90, 100, 120, 160])
def test_no_word_is_cut_off(width, monkeypatch, capsys):
    monkeypatch.setattr(terminal, "PIPE_WIDTH", width)
    terminal.show_table(Table("Models compared", HEADS, ROWS))
    lines = capsys.readouterr().out.splitlines()
    words = {word for line in lines for word in line.replace(":", "").split()}
    # Where there is no room for columns, each row is told under its own name.
    assert {
        word
        for text in (*HEADS[1:], *(cell for row in ROWS for cell in row))
        for word in text.split()
    } <= words
    if any("───" in line for line in lines):
        assert max(len(line.rstrip()) for line in lines) <= width


@pytest.mark.parametrize(("letters", "has_columns"), [(10, True), (11, False)])
def test_a_table_without_room_for_its_words_is_written_row_by_row(
    monkeypatch, capsys, letters, has_columns
):
    monkeypatch.setattr(terminal, "PIPE_WIDTH", 30)
    word = letters * "x"
    # Two blanks and a line beside each of three columns leave 20 letters, of which Model and Value take ten.
    terminal.show_table(
        Table(
            "Two models",
            ("Model", "Value", "Note", "Empty"),
            [("a", "1.5", "", ""), ("b", "2", word, "")],
        )
    )
    lines = [line.rstrip() for line in capsys.readouterr().out.splitlines() if line.strip()]
    if has_columns:
        assert [line.split() for line in (lines[0], lines[1], *lines[-2:])] == [
            ["Two", "models"],
            ["Model", "Value", "Note"],
            ["a", "1.5"],
            ["b", "2", word],
        ]
    else:
        assert lines == ["Two models", "a", "  Value: 1.5", "b", "  Value: 2", f"  Note: {word}"]


@pytest.mark.parametrize(("width", "used"), [(99, 99), (100, 100), (101, 100), (160, 100)])
def test_equations_are_laid_out_in_lines_of_100_letters_at_most(monkeypatch, capsys, width, used):
    monkeypatch.setattr(terminal, "PIPE_WIDTH", width)
    terminal.say_laid_out(lambda columns: f"{columns}: {120 * 'x'}")
    assert capsys.readouterr().out == f"{used}: {120 * 'x'}\n\n"


def test_letters_missing_in_an_encoding_are_spelt_out():
    text, end = terminal._plain(UnicodeEncodeError("ascii", "5 µm", 2, 3, "no such letter"))
    assert (text.isascii(), len(text) > 0, end) == (True, True, 3)
    with pytest.raises(UnicodeDecodeError):
        terminal._plain(UnicodeDecodeError("ascii", b"\xff", 0, 1, "no letter"))
