"""The command as a whole: help, exit codes, what goes where, any terminal."""

import gc
import io
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from bristle.cli import application, terminal
from bristle.cli.main import _own_the_compiler, main
from bristle.cli.signals import SignalledError, ended_by_signals
from bristle.core.former import FORMER

COMMANDS = [
    registered_command.name for registered_command in application.application().registered_commands
]
HEAVY = ("numba", "scipy", "pint", "pydantic", "rich", "matplotlib", "numpy")


# A job of a shell without job control ignores the signal from its start, and so would this one.
INTERRUPTIBLE = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # under nohup it would stay ignored, as it should
from bristle.cli.main import main
sys.exit(main())
"""


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize(
    "arguments",
    [
        ["--help"],
        [],
        ["--version"],
        *([registered_command, "--help"] for registered_command in COMMANDS),
    ],
)
def test_help_loads_nothing_heavy(arguments):
    code = (
        "import sys; from bristle.cli.main import main; code = main(sys.argv[1:]); "
        f"print([one for one in {HEAVY!r} if one in sys.modules], code)"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True
    )
    # Newer releases of typer themselves read the options of a command through pydantic.
    by_typer = [] if arguments == ["--help"] else ["pydantic"]
    # Its list of formats asks their readers.
    listed = ["numpy"] if arguments == ["log", "--help"] else []
    assert ended.stdout.splitlines()[-1] in (f"{listed} 0", f"{by_typer + listed} 0")
    assert ended.stderr == ""


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_an_example_and_json(bristle, command):
    shown = bristle(command, "--help", code=0, shown="--json")
    assert f"Example:\n    bristle {command} " in shown.out


def test_the_list_of_commands_has_whole_sentences(bristle):
    shown = bristle("--help").out.partition("Commands:")[2]
    assert [line.split()[0] for line in shown.strip().splitlines()] == COMMANDS
    assert "..." not in shown


FORMER_OPTIONS = (
    *(
        "--data",
        "--size-limit",
        "--decimation",
        "--global",
        "--no-global",
        "--set",
        "--truth",
        "--window",
        "--dry-run",
    ),
    *(
        "lab --log",
        "lab --axis",
        "paper --axis",
        "demo --format",
        "export --draws",
        "check --allow-code",
        "excite --allow-code",
    ),
)


@pytest.mark.parametrize("former", FORMER_OPTIONS)
def test_former_options_are_refused_with_their_successor(bristle, former):
    command, _, option = former.rpartition(" ")
    ended = bristle(
        command or "identify", option, "1", said=f"{option} was removed. {FORMER[former]}"
    )
    assert (ended.code, ended.out) == (2, "")


NATIVE = """
import ctypes, signal, sys
import bristle.cli.application
from bristle.cli.main import main
from bristle.files.results import results_folder
signal.signal(signal.SIGINT, signal.default_int_handler)

def work(arguments):
    with results_folder("run") as folder:
        folder.write("model.toml", "half")
        print("working", flush=True)
        lock = ctypes.create_string_buffer(64)
        while True:  # a lock that is held already: native code that no signal ends, as a loop in a library is
            ctypes.CDLL(None).pthread_mutex_lock(lock)

bristle.cli.application.run = work
sys.exit(main(["identify"]))
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize(
    ("numbers", "code", "said"),
    [
        ((signal.SIGTERM,), 143, ["terminated"]),
        (
            (signal.SIGINT, signal.SIGINT),
            130,
            ["interrupted: waiting for a library", "interrupted"],
        ),
    ],
)
def test_native_code_that_never_returns_is_ended_without_files(tmp_path, numbers, code, said):
    process = subprocess.Popen(
        [sys.executable, "-c", NATIVE],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
    )
    assert process.stdout.readline() == "working\n"
    time.sleep(0.2)
    for number in numbers:
        assert process.poll() is None
        process.send_signal(number)
        time.sleep(2.4)
    _, errors = process.communicate(timeout=20)
    assert process.returncode == code
    assert [
        line.removeprefix("bristle: ")[: len(words)]
        for line, words in zip(errors.splitlines(), said, strict=True)
    ] == said
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_signals_that_arrive_together_are_seen_as_one():
    # While the first is handled, the others wait: they must not count as signals that nobody sees.
    def work():
        with ended_by_signals():
            try:
                for _ in range(5):
                    os.kill(os.getpid(), signal.SIGTERM)
            finally:
                time.sleep(2.5)

    with pytest.raises(SignalledError, match="terminated"):
        work()


def test_a_signal_that_a_finalizer_swallows_is_sent_again():
    class Last:
        def __del__(self):
            signal.raise_signal(signal.SIGTERM)

    def work():
        with ended_by_signals():
            Last()
            time.sleep(5.0)

    with pytest.raises(SignalledError, match="terminated"):
        work()


def test_changes_for_signals_are_restored():
    hook, before = (
        sys.unraisablehook,
        len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").exists() else 0,
    )
    woken, waking = os.pipe()
    os.set_blocking(waking, False)
    outer = signal.set_wakeup_fd(waking)
    try:
        for _ in range(5):
            with ended_by_signals():
                assert sys.unraisablehook is not hook
        assert sys.unraisablehook is hook
        assert signal.set_wakeup_fd(outer) == waking
    finally:
        signal.set_wakeup_fd(outer)
        os.close(woken)
        os.close(waking)
    assert not before or len(os.listdir("/proc/self/fd")) == before


@pytest.mark.slow
def test_a_signal_with_another_purpose_does_not_end_the_program():
    # Were it watched, nobody would see it, and the process would end after two seconds.
    received = []
    before = signal.signal(signal.SIGUSR1, lambda number, _: received.append(number))
    try:
        with ended_by_signals():
            signal.raise_signal(signal.SIGUSR1)
            time.sleep(2.5)
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert received == [signal.SIGUSR1]


def test_other_errors_dropped_by_a_finalizer_are_reported_as_before(monkeypatch):
    class Last:
        def __del__(self):
            raise ValueError("dropped")

    message = []
    monkeypatch.setattr(sys, "unraisablehook", lambda item: message.append(str(item.exc_value)))
    with ended_by_signals():
        Last()
    assert message == ["dropped"]


def test_an_interrupt_during_imports_is_reported_in_one_line(monkeypatch, capsys):
    class Interrupting:
        def find_spec(self, name, *_):
            if name == "bristle.cli.application":
                signal.raise_signal(signal.SIGTERM)

    monkeypatch.delitem(sys.modules, "bristle.cli.application")
    monkeypatch.setattr(sys, "meta_path", [Interrupting(), *sys.meta_path])
    assert main(["models"]) == 143
    assert capsys.readouterr().err == "bristle: terminated\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("argument", ["--version", "models"])
def test_a_full_output_is_reported_once(argument):
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-c", INTERRUPTIBLE, argument]
        ended = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert ended.returncode == 2
    assert len(ended.stderr.splitlines()) == 1
    assert "No space left" in ended.stderr


ENDS = [(["nonsense"], 2), (["models"], 0), (["models", "--json"], 0), (["log", "log.csv"], 0)]


@pytest.mark.fast_cases(1)
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
@pytest.mark.parametrize(("arguments", "code"), ENDS)
def test_unwritable_messages_change_no_exit_code(place, arguments, code):
    with open("/dev/full", "w") as full:
        process = [sys.executable, "-c", INTERRUPTIBLE, *arguments]
        assert (
            subprocess.run(process, stdout=subprocess.DEVNULL, stderr=full, check=False).returncode
            == code
        )


@pytest.mark.parametrize(
    ("seconds", "kept"),
    [
        ("1700000000", True),
        ("9" * 10, True),
        ("9" * 11, False),
        ("never", False),
        ("", False),
        ("1.5", False),
    ],
)
def test_compiler_settings_of_other_programs_are_dropped(monkeypatch, seconds, kept):
    given = {
        "NUMBA_CPU_FEATURES": "-sse2",
        "NUMBA_NUM_THREADS": "abc",
        "NUMBA_DISABLE_JIT": "0",
        "SOURCE_DATE_EPOCH": seconds,
    }
    environment = given | {"HOME": "here"}
    monkeypatch.setattr(os, "environ", environment)
    _own_the_compiler()
    assert set(environment) == {"HOME", "NUMBA_DISABLE_JIT"} | (
        {"SOURCE_DATE_EPOCH"} if kept else set()
    )


def test_a_thread_of_a_user_model_does_not_block_the_exit(monkeypatch):
    ended, goes_on = [], threading.Event()
    monkeypatch.setattr(
        application, "run", lambda arguments: threading.Thread(target=goes_on.wait).start() or 3
    )
    monkeypatch.setattr(sys, "argv", ["bristle", "check", "own.py"])
    monkeypatch.setattr(gc, "freeze", lambda: None)
    monkeypatch.setattr(gc, "set_threshold", lambda *_: None)
    monkeypatch.setattr(os, "_exit", ended.append)
    main()
    goes_on.set()
    assert ended == [3]


@pytest.mark.skipif(not shutil.which("sh"), reason="needs bash and git")
@pytest.mark.skipif(os.name != "posix", reason="limits of POSIX")
@pytest.mark.parametrize("option", ["-v", "-d"])
def test_too_low_a_memory_limit_is_reported_before_libraries_load(option):
    code = "from bristle.cli.main import main; raise SystemExit(main(['models']))"
    words = f'ulimit {option} 327680; exec "$0" -c "{code}"'
    ended = subprocess.run(
        ["sh", "-c", words, sys.executable], capture_output=True, text=True, check=False, timeout=60
    )
    assert ended.returncode == 2, ended.stderr
    assert f"ulimit {option} 327680: is too little memory" in ended.stderr


@pytest.mark.skipif(not shutil.which("bash"), reason="needs bash and git")
@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(("arguments", "code"), ENDS)
def test_a_closed_output_changes_no_exit_code(place, arguments, code):
    shell = [
        "bash",
        "-c",
        '"$0" -c "$1" "${@:2}" >&- 2>&-',
        sys.executable,
        INTERRUPTIBLE,
        *arguments,
    ]
    assert subprocess.run(shell, check=False).returncode == code


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("arguments", [["--version"], ["models"], ["models", "--json"]])
def test_a_closed_pipe_is_no_error(arguments):
    process = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTIBLE, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    process.stdout.close()
    with process.stderr:
        assert process.stderr.read() == b""
    assert process.wait(timeout=60) == 0


def test_any_encoding_of_the_terminal_works(monkeypatch):
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written, encoding="ascii"))
    assert main(["models", "lugre"]) == 0
    assert "N*m*s/rad" in written.getvalue().decode("ascii")


class Terminal(io.StringIO):
    """A stream that claims to be a terminal."""

    def isatty(self) -> bool:
        return True


def test_progress_is_shown_on_a_terminal_after_a_while(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(terminal, "PATIENCE", 0.05)
    monkeypatch.setattr(sys, "stderr", Terminal())
    with terminal.progress("working") as report:
        report(0.5, "fitting [lugre]")
        time.sleep(0.4)
    assert "fitting [lugre]" in sys.stderr.getvalue()
    monkeypatch.setattr(terminal, "PATIENCE", 10.0)
    monkeypatch.setattr(sys, "stderr", Terminal())
    with terminal.progress("working") as report:
        report(0.5, "quick")
    assert "quick" not in sys.stderr.getvalue()


def test_a_command_loads_no_module_of_another():
    code = "import sys; from bristle.cli.main import main; main(['models']); print(*sys.modules)"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(ended.stdout.splitlines()[-1].split())
    assert "bristle.cli.models" in loaded
    assert not {name for name in loaded if name.startswith("bristle.apps")} - {"bristle.apps"}
    assert "bristle.cli.identify" not in loaded


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--help", "--json"], "No such option: --json"),
        (["--nonsense"], "No such option: --nonsense"),
        (["watch"], "bristle watch was removed"),
    ],
)
def test_a_line_that_begins_with_no_command_is_refused_in_one_line(words, said, capsys):
    assert main(words) == 2
    assert said in capsys.readouterr().err
