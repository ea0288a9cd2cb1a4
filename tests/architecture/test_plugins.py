"""The plugins of these tests: what a fast test may cost, where kernels are compiled, shares of the files, reasons of skips."""

import os
import subprocess
import sys
import textwrap
import time
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import pytest
from tests.needs import allowed_reason
from tests.plugins import budget, kernels, order, skips

ROOT = Path(__file__).parents[2]


class Taken:
    """A meter that has read these times [s]."""

    def __init__(self, seconds, own):
        self.seconds = lambda: seconds
        self.own_seconds = lambda: own


@pytest.mark.parametrize(
    ("seconds", "own", "machine", "fails"),
    [
        (1.9, 1.9, 1.0, False),
        (3.0, 3.0, 1.0, True),
        (3.0, 3.0, 2.0, False),  # a machine of half the speed
        (5.0, 0.5, 1.0, False),  # a child has compiled
    ],
)
def test_a_fast_test_has_two_seconds_of_processor_time(monkeypatch, seconds, own, machine, fails):
    monkeypatch.setattr(budget, "slowness", lambda: machine)
    if not fails:
        budget.judge(Taken(seconds, own), budget.TEST, "a test")
        return
    with pytest.raises(
        pytest.fail.Exception, match=r"a test takes 3\.0 s of processor time, allowed are 2\.0 s"
    ):
        budget.judge(Taken(seconds, own), budget.TEST, "a test")


def test_a_meter_leaves_out_compilation_and_what_is_shared(monkeypatch):
    now = SimpleNamespace(own=10.0, children=4.0)
    with monkeypatch.context() as patched:  # this test is measured, too
        patched.setattr(
            budget.process,
            "seconds",
            lambda *, children=True: now.own + (now.children if children else 0.0),
        )
        patched.setattr(budget.kernels.Clock, "seconds", 1.0)
        patched.setattr(budget.Spent, "shared", 2.0)
        patched.setattr(budget, "compiled_since", lambda begun: True)
        meter = budget.Meter()
        now.own, now.children = 20.0, 5.0
        budget.kernels.Clock.seconds = 4.0
        budget.Spent.shared = 3.0
        seconds, own = meter.seconds(), meter.own_seconds()
    assert seconds == pytest.approx(11.0 - 3.0 - 1.0)
    assert own == pytest.approx(10.0 - 3.0 - 1.0)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_large_process_compiles_in_a_child_and_counts_its_time(monkeypatch, tmp_path):
    processes = tmp_path / "processes"

    def compile_entry(name):
        with processes.open("a") as file:
            file.write(f"{name} {os.getpid()}\n")
        return name.upper()

    compiled = kernels.counted(compile_entry, lambda: tmp_path)
    monkeypatch.setattr(kernels, "LARGE", 1e6)
    assert compiled("small") == "SMALL"
    monkeypatch.setattr(kernels, "LARGE", 0.0)
    assert compiled("large") == "LARGE"
    entries = [line.split() for line in processes.read_text().splitlines()]
    assert [name for name, _ in entries] == ["small", "large", "large"]
    assert [int(process) == os.getpid() for _, process in entries] == [True, False, True]


@pytest.mark.skipif(kernels.fcntl is None, reason="this system locks no bytes")
def test_a_kernel_that_another_process_compiles_is_awaited(tmp_path):
    place, mark = f"a kernel of {tmp_path}", tmp_path / "released"
    child = os.fork()
    if child == 0:
        with kernels.one_worker(place):
            (tmp_path / "locked").touch()
            time.sleep(0.3)
            mark.touch()
        os._exit(0)
    while not (tmp_path / "locked").exists():
        time.sleep(0.01)
    with kernels.one_worker("another kernel"):
        assert not mark.exists()
    with kernels.one_worker(place):
        assert mark.exists()
    os.waitpid(child, 0)


class Item:
    """A collected test."""

    def __init__(self, nodeid, *marks):
        self.nodeid = nodeid
        self.marks = {mark.name: mark for mark in marks}

    def get_closest_marker(self, name):
        return self.marks.get(name)

    def add_marker(self, name):
        self.marks[name] = SimpleNamespace(name=name)


def shares(items, number):
    kept = []
    for position in range(1, number + 1):
        config = SimpleNamespace(
            getoption=lambda name, share=(position, number): share,
            hook=SimpleNamespace(pytest_deselected=lambda items: None),
        )
        share = list(items)
        order.keep_share(config, share)
        kept.append([item.nodeid for item in share])
    return kept


def test_shares_hold_each_slow_test_once_and_split_no_file():
    slow = SimpleNamespace(name="slow")
    items = [
        Item(f"tests/room{k % 2}/test_{k}.py::test_{n}", slow) for k in range(7) for n in range(2)
    ]
    kept = shares([*items, Item("tests/room1/test_fast.py::test_fast")], 3)
    assert sorted(name for share in kept for name in share) == sorted(item.nodeid for item in items)
    assert max(map(len, kept)) - min(map(len, kept)) <= 2
    files = [{name.partition("::")[0] for name in share} for share in kept]
    assert not files[0] & files[1]
    assert not files[1] & files[2]


def test_the_first_cases_are_fast():
    cases = [
        Item(f"tests/a.py::test[{k}]", SimpleNamespace(name="fast_cases", args=[2]))
        for k in range(4)
    ]
    order.mark_further_cases(cases)
    assert [budget.is_slow(case) for case in cases] == [False, False, True, True]


def test_folders_that_share_a_fixture_stay_in_one_process():
    assert order.scope_of("tests/apps/paper/test_a.py::test_x") == order.scope_of(
        "tests/apps/paper/test_b.py::test_y"
    )
    assert order.scope_of("tests/core/test_a.py::test_x") != order.scope_of(
        "tests/core/test_b.py::test_y"
    )


@pytest.mark.parametrize(
    ("reason", "is_allowed"),
    [
        ("could not import 'torch': No module named 'torch'", True),
        ("needs a graphics processor: no driver", True),
        ("BRISTLE_DATA does not name the folder of the measured logs", True),
        ("needs chromium", False),
        ("needs arm-none-eabi-gcc, qemu-system-arm", True),
        ("needs a C compiler", False),
        ("needs the grammar of Structured Text for tree-sitter", False),
        ("could not import 'pandas': No module named 'pandas'", False),
        ("later", False),
    ],
)
def test_few_reasons_of_skips_are_allowed(reason, is_allowed):
    assert (allowed_reason(reason) is not None) == is_allowed


def test_a_file_that_is_skipped_as_a_whole_needs_an_allowed_reason_too(monkeypatch):
    monkeypatch.setattr(skips, "REASONS", Counter({"needs a C compiler": 2, "needs casadi": 1}))
    monkeypatch.setattr(
        skips, "FILES", Counter({"could not import 'pandas'": 1, "could not import 'torch'": 1})
    )
    assert sorted(skips.refused()) == ["could not import 'pandas'", "needs a C compiler"]


COSTLY = """
import pytest
from tests.plugins import budget
budget.TEST = 0.01
budget.slowness = lambda: 1.0

def test_long():
    sum(range(3_000_000))

@pytest.mark.slow
def test_slow():
    sum(range(3_000_000))
"""
SKIPPED = """
import pytest

@pytest.mark.skipif(True, reason="needs chromium")
def test_browser():
    pass
"""


LIBRARY = """
import pytest
pytest.importorskip("bristle_is_not_this")
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("tests", "options", "status", "says"),
    [
        (COSTLY, (), 1, ["1 failed, 1 passed", "this fast test takes"]),
        (
            SKIPPED,
            ("--ci",),
            1,
            ["1 tests and 0 files skipped, by reason", "NOT ALLOWED: needs chromium"],
        ),
        (SKIPPED, (), 0, ["1 tests and 0 files skipped, by reason"]),
        (
            LIBRARY + SKIPPED.replace("chromium", "casadi"),
            ("--ci",),
            1,
            ["0 tests and 1 files skipped", "NOT ALLOWED: could not import"],
        ),
    ],
    ids=["costly", "skipped", "skipped, no CI", "library"],
)
@pytest.mark.parametrize("workers", ["0", "2"])
def test_a_run_fails_for_what_costs_too_much_and_for_what_is_skipped(
    tmp_path, tests, options, status, says, workers
):
    (tmp_path / "test_x.py").write_text(textwrap.dedent(tests), encoding="utf-8")
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers =\n  slow: x\n", encoding="utf-8")
    plugins = [
        word
        for name in ("kernels", "budget", "order", "skips")
        for word in ("-p", f"tests.plugins.{name}")
    ]
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-p",
        "no:cacheprovider",
        "-n",
        workers,
        *plugins,
        *options,
        ".",
    ]
    environment = os.environ | {"PYTHONPATH": str(ROOT), "PYTEST_ADDOPTS": ""}
    ended = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert ended.returncode == status, ended.stdout
    for text in says:
        assert text in ended.stdout
