"""Attacks that take minutes: ``python -m tests.attack.siege [--seed N] [NAME ...]``; exit code 1 if one got through.

``kills``: processes that are killed, terminated and interrupted at random moments. ``values``: thousands of values in
places of files where they do not belong. ``flips``: hundreds of files with flipped bytes, of each kind. Without a name
all three run. Each ends after nine minutes at the latest; another seed draws other attacks.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from tests.attack.yard import FILES, HOSTILE, assault, build, log_of, places_in, replaced, state_of
from tests.logs.conftest import WRITERS

from bristle.core.errors import InputError
from bristle.files.owned import NOTE, Folder, note_in, strangers_in
from bristle.logs.readers import read_table

KILLS, VALUES, FLIPS, SECONDS = 100, 2000, 250, 540.0
# A job of a shell ignores an interrupt. Asked by SIGUSR1, the process tells where all of its threads are.
START = """import faulthandler, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
faulthandler.register(signal.SIGUSR1)
"""
RUN = START + "from bristle.cli.main import main\nsys.exit(main())"
WORK = {
    "identify": [
        "identify",
        "log.csv",
        "--axis",
        "axis.toml",
        "--model",
        "lugre",
        "--out",
        "results",
        "--force",
    ],
    "run": ["run", "experiment.toml", "--out", "results", "--force", "--log"],
    "paper": ["paper", "--figure", "3", "--out", "results", "--force"],
    "demo": ["demo", "--out", "results", "--force"],
}


class Pace:
    """The attacks of one siege, counted, until its time is over."""

    def __init__(self) -> None:
        self.end, self.done = time.monotonic() + SECONDS, 0

    def of(self, attacks: Iterable[Any]) -> Iterator[Any]:
        for attack in attacks:
            if time.monotonic() > self.end:
                return
            self.done += 1
            yield attack


def kills(chance: random.Random, pace: Pace) -> Iterator[str]:
    """Yield what went wrong when a process was ended at a random moment."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        build(folder)
        mine = state_of(folder)
        for arguments in WORK.values():  # what is compiled for the first time takes its time
            begun(arguments, folder)
        took = {name: begun(arguments, folder)[1] for name, arguments in WORK.items()}
        for count in pace.of(range(KILLS)):
            name = chance.choice(list(WORK))
            number = chance.choice([signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
            before = unfinished_in(folder)
            process = started(WORK[name], folder)
            time.sleep(chance.uniform(0.0, 1.1 * took[name]))
            process.send_signal(number)
            what = f"{count} {name} {number.name}"
            try:
                _, errors = process.communicate(timeout=60)
            except subprocess.TimeoutExpired:
                yield f"{what}: has not ended after a minute: {threads_of(process)}"
                continue
            yield from wrongs(what, process.returncode, errors, number, folder, mine)
            # What a killed process left is cleared by the next one that comes to its results, not by one ended earlier.
            if number is not signal.SIGKILL and unfinished_in(folder) - before:
                yield f"{what}: left behind {unfinished_in(folder) - before}"
        code, _ = begun(WORK["run"], folder)
        left = unfinished_in(folder)
        if code or left:
            yield f"afterwards: exit code {code}, left behind {left}"
        if state_of(folder) != mine:
            yield "afterwards: files of a person are others"


def unfinished_in(folder: Path) -> set[str]:
    return {item.name for item in folder.iterdir() if item.name.startswith("bristle-")}


def started(arguments: list[str], folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", RUN, *arguments],
        cwd=folder,
        text=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )


def threads_of(process: subprocess.Popen[str]) -> str:
    """Return where the threads of a process are, and kill it."""
    process.send_signal(signal.SIGUSR1)
    time.sleep(2.0)
    process.kill()
    return process.communicate()[1]


def begun(arguments: list[str], folder: Path) -> tuple[int, float]:
    began = time.monotonic()
    process = started(arguments, folder)
    process.communicate(timeout=600)
    return process.returncode, time.monotonic() - began


def wrongs(
    what: str,
    code: int,
    errors: str,
    number: signal.Signals,
    folder: Path,
    mine: dict[str, tuple[int, str]],
) -> Iterator[str]:
    # Before anything is imported the interpreter answers a signal as it does without any program.
    if code not in (0, -number, 128 + number) and not (code == 1 and "KeyboardInterrupt" in errors):
        yield f"{what}: exit code {code}, {errors[:200]!r}"
    if "fault of bristle" in errors:
        yield f"{what}: {errors[:200]!r}"
    if not (folder / "results" / NOTE).is_file():
        yield f"{what}: the results are gone"
        return
    with Folder(folder / "results") as results:
        note = note_in(results)
        if (
            note is None
            or strangers_in(results, note) != ([], [])
            or set(note.files) - set(results.names())
        ):
            yield f"{what}: the results are not whole"
    rest = {
        item: fixed for item, fixed in state_of(folder).items() if not item.startswith("bristle-")
    }
    if rest != mine:
        yield f"{what}: touched {set(rest) ^ set(mine)}"


def values(chance: random.Random, pace: Pace) -> Iterator[str]:
    """Yield which hostile value in which place of a file got through."""
    from tests.attack.test_attack import COMMANDS

    places = {
        name: list(places_in(tomllib.loads(text)))
        for name, text in FILES.items()
        if name.endswith(".toml")
    }
    with tempfile.TemporaryDirectory() as place:
        built = Path(place) / "built"
        built.mkdir()
        build(built)
        for _ in pace.of(range(VALUES)):
            folder = Path(place) / "yard"
            shutil.copytree(built, folder)
            name = chance.choice(list(places))
            text, message = FILES[name], []
            for _ in range(chance.randint(1, 2)):
                path, value = chance.choice(places[name]), chance.choice(HOSTILE)
                try:
                    text = replaced(text, path, value)
                except (LookupError, TypeError):
                    continue
                message.append(f"{'.'.join(map(str, path))} = {str(value)[:30]!r}")
            (folder / name).write_text(text, encoding="utf-8")
            arguments = chance.choice(COMMANDS[name])
            try:
                assault(list(arguments), folder)
            except AssertionError as error:
                yield f"{arguments[0]} {name} {message}: {str(error)[:300]}"
            shutil.rmtree(folder)


def flips(chance: random.Random, pace: Pace) -> Iterator[str]:
    """Yield which flipped file of which kind got through."""
    with tempfile.TemporaryDirectory() as place:
        whole = {
            kind: write(
                Path(place) / f"log.{kind}", log_of(60 if kind != "tdms" else 1200)
            ).read_bytes()
            for kind, write in WRITERS.items()
        }
    attacks = [
        (kind, count)
        for kind in whole
        for count in range(FLIPS if kind in ("h5", "parquet", "tdms") else 10 * FLIPS)
    ]
    chance.shuffle(attacks)
    for kind, count in pace.of(attacks):
        spoiled = bytearray(whole[kind])
        for _ in range(chance.choice([1, 1, 1, 2, 5, 30])):
            spoiled[
                chance.randrange(len(spoiled) if chance.random() < 0.5 else min(2000, len(spoiled)))
            ] = chance.randrange(256)
        began = time.monotonic()
        try:
            read_table(bytes(spoiled))
        except InputError as error:
            if not str(error):
                yield f"{kind} {count}: says nothing"
        except Exception as error:  # noqa: BLE001  (that is what is looked for)
            yield f"{kind} {count}: {error!r}"
        if time.monotonic() - began > 10.0:
            yield f"{kind} {count}: takes {time.monotonic() - began:.0f} s"


SIEGES: dict[str, Callable[[random.Random, Pace], Iterator[str]]] = {
    "kills": kills,
    "values": values,
    "flips": flips,
}


def main(arguments: list[str]) -> int:
    """Run sieges; return 1 if something got through."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack.siege")
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(SIEGES))
    parser.add_argument("--seed", type=int, default=10)
    chosen = parser.parse_args(arguments)
    if unknown := set(chosen.names) - set(SIEGES):
        parser.error(f"unknown: {', '.join(sorted(unknown))}; known: {', '.join(SIEGES)}")
    os.environ["BRISTLE_STATE_DIR"] = tempfile.mkdtemp()
    through = 0
    for name in chosen.names or SIEGES:
        began, count, pace = time.monotonic(), 0, Pace()
        for wrong in SIEGES[name](random.Random(chosen.seed), pace):
            count += 1
            print(f"  {wrong}", flush=True)
        print(
            f"{name}: {pace.done} attacks of seed {chosen.seed}, {count} got through, {time.monotonic() - began:.0f} s",
            flush=True,
        )
        through += count
    return 1 if through else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
