"""The command as a whole: help, exit codes, what goes where, any terminal."""

import errno
import importlib
import io
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bristle.cli import identify, terminal
from bristle.cli.application import app
from bristle.cli.main import main
from bristle.cli.options import REMOVED
from bristle.cli.signals import SignalledError, ended_by_signals

COMMANDS = [registered_command.name for registered_command in app.registered_commands]
HEAVY = ("numba", "scipy", "pint", "pydantic", "rich", "matplotlib", "numpy")


# A job of a shell without job control ignores the signal from its start, and so would this one.
INTERRUPTIBLE = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # under nohup it would stay ignored, as it should
from bristle.cli.main import main
sys.exit(main())
"""


def run_apart(*arguments: str, **options) -> subprocess.CompletedProcess:
    command = [sys.executable, "-c", "import sys; from bristle.cli.main import main; sys.exit(main())", *arguments]
    return subprocess.run(command, capture_output=True, check=False, timeout=120, **options)


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize("arguments", [["--help"], [], ["--version"], *([registered_command, "--help"] for registered_command in COMMANDS)])
def test_help_loads_nothing_heavy(arguments):
    code = (
        "import sys; from bristle.cli.main import main; code = main(sys.argv[1:]); "
        f"print([one for one in {HEAVY!r} if one in sys.modules], code)"
    )
    ended = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    # Newer releases of typer themselves read the options of a command through pydantic.
    by_typer = [] if arguments == ["--help"] else ["pydantic"]
    listed = ["numpy"] if arguments == ["log", "--help"] else []  # its list of formats asks their readers
    assert ended.stdout.splitlines()[-1] in (f"{listed} 0", f"{by_typer + listed} 0")
    assert ended.stderr == ""


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_an_example_and_json(bristle, command):
    shown = bristle(command, "--help")
    assert shown.code == 0
    assert f"Example:\n    bristle {command} " in shown.out
    assert "--json" in shown.out


def test_the_list_of_commands_has_whole_sentences(bristle):
    shown = bristle("--help").out.partition("Commands:")[2]
    assert [line.split()[0] for line in shown.strip().splitlines()] == COMMANDS
    assert "..." not in shown


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["identfy"], "Did you mean 'identify'"),
        (["identify"], "LOG"),
        (["identify", "x.csv", "--axes", "a.toml"], "--axis"),
        (["identify", "x.csv", "--draws", "ten"], "--draws"),
        (["run", "a.toml", "b.toml"], "b.toml"),
        (["predict", "--mode"], "--mode"),
    ],
)
def test_a_mistyped_command_line_gives_one_line_with_advice(bristle, arguments, words):
    ended = bristle(*arguments)
    assert ended.code == 2
    assert ended.out == ""
    assert words in ended.err
    assert "Try: bristle" in ended.err
    assert len(ended.err.splitlines()) == 1


@pytest.mark.parametrize("removed", REMOVED)
def test_removed_options_are_refused_with_their_replacement(bristle, removed):
    command, _, option = removed.rpartition(" ")
    arguments = [removed] if not removed.startswith("--") and not command else [command or "identify", option, "1"]
    ended = bristle(*arguments)
    assert (ended.code, ended.out) == (2, "")
    assert f"{option} was removed. {REMOVED[removed]}" in ended.err


def test_a_size_limit_of_the_environment_applies(bristle, place, monkeypatch):
    monkeypatch.setenv("BRISTLE_SIZE_LIMIT", "1 kB")
    ended = bristle("log", "log.csv")
    assert (ended.code, "up to 1 kB" in ended.err) == (2, True)
    monkeypatch.setenv("BRISTLE_SIZE_LIMIT", "9" * 5000)
    assert "BRISTLE_SIZE_LIMIT" in bristle("log", "log.csv").err


def test_a_bug_is_one_message_and_a_saved_traceback(bristle, monkeypatch, place):
    def broken(*_, **__):
        raise ZeroDivisionError("float division\nby zero")

    monkeypatch.setattr("bristle.files.axis.read_axis", broken)
    ended = bristle("identify", "log.csv", "--axis", "axis.toml", "--out", "run")
    assert ended.code == 70
    assert ended.out == ""
    assert len(ended.err.splitlines()) == 1
    assert "ZeroDivisionError: float division by zero" in ended.err
    saved = Path(re.search(r"\S+\.txt", ended.err)[0])
    assert "in broken" in saved.read_text()
    saved.unlink()
    assert not list(place.glob("run*"))


@pytest.mark.parametrize(("error", "code"), [(KeyboardInterrupt(), 130), (MemoryError(), 2), (BrokenPipeError(32, "Broken pipe"), 0)])
def test_other_ends_have_separate_codes(bristle, monkeypatch, error, code):
    def ends(*_, **__):
        raise error

    monkeypatch.setattr(terminal, "let_go", lambda stream: None)
    monkeypatch.setattr("bristle.friction.find", ends)
    monkeypatch.setattr("bristle.cli.models._families", ends)
    ended = bristle("models")
    assert ended.code == code
    assert ended.out == ""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "code", "said"), [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated"), (signal.SIGHUP, 129, "hung up")]
)
def test_a_signal_ends_the_work_without_files(place, number, code, said):
    process = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTIBLE, "identify", "log.csv", "--axis", "axis.toml", "--model", "lugre", "--out", "run"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    until = time.monotonic() + 60
    while not list(place.glob("bristle-*.partial")) and time.monotonic() < until:
        time.sleep(0.01)
    process.send_signal(number)
    process.send_signal(number)  # as a terminal does that is closed: it must not end the cleaning up
    out, errors = process.communicate(timeout=60)
    assert (process.returncode, out, errors) == (code, "", f"bristle: {said}\n")
    assert not list(place.glob("run*")) + list(place.glob("bristle-*"))


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


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize(
    ("numbers", "code", "said"),
    [
        ((signal.SIGTERM,), 143, ["terminated"]),
        ((signal.SIGINT, signal.SIGINT), 130, ["interrupted: waiting for a library", "interrupted"]),
    ],
)
def test_native_code_that_never_returns_is_ended_without_files(tmp_path, numbers, code, said):
    process = subprocess.Popen([sys.executable, "-c", NATIVE], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    assert process.stdout is not None
    assert process.stdout.readline() == "working\n"
    time.sleep(0.2)
    for number in numbers:
        assert process.poll() is None
        process.send_signal(number)
        time.sleep(2.4)
    _, errors = process.communicate(timeout=20)
    assert process.returncode == code
    assert [line.removeprefix("bristle: ")[: len(words)] for line, words in zip(errors.splitlines(), said, strict=True)] == said
    assert not list(tmp_path.iterdir())


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


def test_signals_that_arrive_while_native_code_runs_are_seen_as_one():
    def work():
        with ended_by_signals():
            words = f"read go; for i in 1 2 3; do kill -TERM {os.getpid()}; sleep 0.02; done"
            sender = subprocess.Popen(["sh", "-c", words], stdin=subprocess.PIPE)
            try:
                sender.stdin.close()  # no signal is sent before whoever waits for the sender stands ready
                sum(range(60_000_000))  # one step of the interpreter, longer than the sender takes
                time.sleep(1.0)
            finally:
                sender.wait()
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


def test_a_repeated_signal_within_a_second_does_not_end_the_cleanup():
    done = []

    def work():
        with ended_by_signals():
            try:
                signal.raise_signal(signal.SIGTERM)
            finally:
                signal.raise_signal(signal.SIGTERM)
                done.append("cleaned")

    with pytest.raises(SignalledError, match="terminated"):
        work()
    assert done == ["cleaned"]


def test_changes_for_signals_are_restored():
    hook, before = sys.unraisablehook, len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").exists() else 0
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


def test_a_signal_that_an_import_would_swallow_is_sent_again(tmp_path, monkeypatch):
    (tmp_path / "swallowing.py").write_text(
        "import signal\ntry:\n    signal.raise_signal(signal.SIGTERM)\nexcept BaseException:\n    raised = True\n"
    )
    monkeypatch.syspath_prepend(tmp_path)

    def work():
        with ended_by_signals():
            swallowing = importlib.import_module("swallowing")
            assert not hasattr(swallowing, "raised")
            time.sleep(5.0)

    with pytest.raises(SignalledError, match="terminated"):
        work()


def test_ignored_signals_stay_ignored_and_handlers_are_restored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with ended_by_signals():
            signal.raise_signal(signal.SIGHUP)
            assert signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    finally:
        signal.signal(signal.SIGHUP, before)


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
def test_a_full_output_is_reported_once():
    with open("/dev/full", "w") as full:
        ended = subprocess.run(
            [sys.executable, "-c", "import sys; from bristle.cli.main import main; sys.exit(main(['models']))"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert ended.returncode == 2
    assert len(ended.stderr.splitlines()) == 1
    assert "No space left" in ended.stderr


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_output_keeps_the_results(place):
    with open("/dev/full", "w") as full:
        process = [sys.executable, "-c", INTERRUPTIBLE, "run", "experiment.toml", "--out", "run"]
        ended = subprocess.run(process, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert ended.returncode == 2
    assert "The folder of results is complete" in ended.stderr
    assert (place / "run" / "summary.json").is_file()


ENDS = [(["models"], 0), (["models", "--json"], 0), (["nonsense"], 2), (["log", "log.csv"], 0)]


@pytest.mark.fast_cases(1)
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
@pytest.mark.parametrize(("arguments", "code"), ENDS)
def test_unwritable_messages_change_no_exit_code(place, arguments, code):
    with open("/dev/full", "w") as full:
        process = [sys.executable, "-c", INTERRUPTIBLE, *arguments]
        assert subprocess.run(process, stdout=subprocess.DEVNULL, stderr=full, check=False).returncode == code


def test_a_library_that_cannot_be_loaded_is_no_fault_of_bristle_but_its_own_module_is(monkeypatch, capsys):
    for name, code, text in (("numpy", 2, "bristle cannot load a required library"), ("bristle.x", 70, "a fault of bristle")):

        def ends(*_, name=name):
            raise ImportError("failed to map segment", name=name)

        monkeypatch.setattr("bristle.cli.models._families", ends)
        assert main(["models"]) == code
        message = capsys.readouterr().err
        assert text in message
        for saved in re.findall(r"\S+\.txt", message):
            Path(saved).unlink()


def as_typed(*arguments: str, **environment: str) -> subprocess.CompletedProcess:
    code = f"import sys; sys.argv[1:] = {arguments!r}; from bristle.cli.main import main; code = main()"
    code += "; import os; print([one for one in os.environ if one.startswith(('NUMBA_', 'SOURCE_'))]); sys.exit(code)"
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60, env=os.environ | environment
    )


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize("seconds", ["never", "9" * 20, "", "1.5"])
def test_compiler_settings_of_other_programs_are_dropped(place, seconds):
    ended = as_typed("models", NUMBA_CPU_FEATURES="-sse2", NUMBA_NUM_THREADS="abc", NUMBA_DISABLE_JIT="0", SOURCE_DATE_EPOCH=seconds)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout.splitlines()[-1] == "['NUMBA_DISABLE_JIT']"


def test_a_valid_build_date_is_kept(place):
    ended = as_typed("models", SOURCE_DATE_EPOCH="1700000000")
    assert "SOURCE_DATE_EPOCH" in ended.stdout.splitlines()[-1]


def test_a_thread_of_a_user_model_does_not_block_the_exit(tmp_path):
    custom = tmp_path / "own.py"
    custom.write_text("import threading, time\nthreading.Thread(target=time.sleep, args=(1000.0,)).start()\n")
    ended = as_typed("check", str(custom))
    assert ended.returncode == 2
    assert "defines no object that can be checked" in ended.stderr
    assert "End the file with such an object, for example MODEL = FrictionModel(...)" in ended.stderr


@pytest.mark.skipif(os.name != "posix", reason="limits of POSIX")
@pytest.mark.parametrize("option", ["-v", "-d"])
def test_too_low_a_memory_limit_is_reported_before_libraries_load(option):
    code = "from bristle.cli.main import main; raise SystemExit(main(['models']))"
    words = f'ulimit {option} 327680; exec "$0" -c "{code}"'
    ended = subprocess.run(["sh", "-c", words, sys.executable], capture_output=True, text=True, check=False, timeout=60)
    assert ended.returncode == 2, ended.stderr
    assert f"ulimit {option} 327680: is too little memory" in ended.stderr


@pytest.mark.skipif(os.name != "posix", reason="limits of POSIX")
def test_a_limit_of_open_files_is_no_fault_of_bristle(monkeypatch, capsys):
    def ends(*_, **__):
        raise OSError(errno.EMFILE, "Too many open files", "log.csv")

    monkeypatch.setattr("bristle.cli.models._families", ends)
    assert main(["models"]) == 2
    assert "bristle cannot open more files" in capsys.readouterr().err


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(("arguments", "code"), ENDS)
def test_a_closed_output_changes_no_exit_code(place, arguments, code):
    shell = ["bash", "-c", '"$0" -c "$1" "${@:2}" >&- 2>&-', sys.executable, INTERRUPTIBLE, *arguments]
    assert subprocess.run(shell, check=False).returncode == code


@pytest.mark.parametrize("json", [(), ("--json",)])
def test_a_closed_pipe_is_no_error(json):
    code = f"import sys; from bristle.cli.main import main; sys.exit(main(['models', *{json!r}]))"
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    errors = process.stderr.read()
    process.stderr.close()
    assert process.wait(timeout=60) == 0
    assert errors == b""


def test_any_encoding_of_the_terminal_works():
    ended = run_apart("models", "lugre", env=os.environ | {"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"})
    assert ended.returncode == 0
    assert "N*m*s/rad" in ended.stdout.decode("ascii")


@pytest.mark.slow
def test_piped_output_carries_no_colours_and_no_progress(place):
    ended = run_apart("identify", "log.csv", "--axis", "axis.toml", env=os.environ | {"NO_COLOR": "1"})
    assert ended.returncode == 0
    assert b"\x1b" not in ended.stdout + ended.stderr
    assert ended.stderr == b""


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


def test_a_narrow_terminal_cuts_no_number(monkeypatch, capsys, place):
    monkeypatch.setenv("COLUMNS", "50")
    monkeypatch.setattr(terminal, "PIPE_WIDTH", 50)
    assert main(["models", "lugre"]) == 0
    shown = capsys.readouterr().out
    assert max(map(len, shown.splitlines())) <= 50
    assert "1e-12" in re.sub(r"\s", "", shown)


@pytest.mark.slow
def test_warnings_are_lines_and_each_is_shown_once(bristle, monkeypatch, place):
    import warnings

    from bristle.core import InputWarning

    original = identify.size_limit

    def warned():
        for _ in range(2):
            warnings.warn("the clock\x1b[31m jitters", InputWarning, stacklevel=1)
        return original()

    monkeypatch.setattr(identify, "size_limit", warned)
    ended = bristle("identify", "log.csv", "--axis", "axis.toml", "--json")
    assert ended.err == "bristle: warning: the clock [31m jitters\n"
    assert ended.data["model"] == "coulomb_viscous"
