"""Mutation testing: faults of one line are put into the package, and the fast tests have to notice.

``python -m tests.mutants`` draws lines of each group of rooms by a seed, puts one fault into each (a comparison turned,
+ for -, a constant doubled, a statement left out ...), and runs the test files that are related to it, then those that
hold results of every room, in a copy of the tree. It ends with the share of faults that were noticed, in each group, and
the lines that no test holds; exit code 1 where the share is below ``--least`` in all or below ``--least-group`` in a
group. Results are kept in a file, so that a later call goes on where this one was interrupted. ``--share 2/8`` tries the
second of eight equal shares of the faults, and judges it alone: eight calls, on as many machines, try each fault once.

Neither of the two common tools does this here: mutmut chooses a fault while the program runs, by a wrapper around each
function, which compiled kernels cannot go through; cosmic-ray changes the working tree itself, draws no sample, and has
one test command for all lines.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

from tests.mutants.bench import NOTHING_COLLECTED, PASSED, Bench, Job, Verdict, abreast
from tests.mutants.mutations import Mutant, applied, chosen, mutants_of, whole_line
from tests.mutants.related import Imports

ROOT = Path(__file__).parents[2]
# Which rooms are judged together; a test holds that each room is in one group.
GROUPS: dict[str, tuple[str, ...]] = {
    "kernels": ("models",),
    "engine": ("engine",),
    "core": ("core",),
    "files": ("files",),
    "logs": ("logs",),
    "identification": ("identification",),
    "simulation": ("simulation",),
    "prediction": ("prediction",),
    "exports": ("exports", "apps/targets"),
    "report": ("report",),
    "study": ("apps/study", "apps/tune", "apps/arm", "apps/design"),
    "lab": ("apps/lab",),
    "commands": ("cli", "contract", "apps/paper"),
}
# What holds results of every room: JSON of all commands, their pages, figures and files, and the documentation's numbers.
WIDE = (
    "tests/docs/test_reference.py",
    "tests/contract/test_contract.py",
    "tests/files/test_results.py",
    "tests/report/test_pages.py",
    "tests/report/figures/test_figures.py",
    "tests/cli/test_json.py",
    "tests/cli/test_main.py",
    "tests/docs/test_pages.py",
)
EQUIVALENTS = Path(__file__).with_name("equivalents.toml")
# How much longer tests may take with a fault: so many times, and so many seconds for what is compiled anew.
SLOWER, COMPILING = 3.0, 60.0
COLD = 5.0  # how many times the budget a file may take that is run for the first time, with nothing compiled


def main(arguments: list[str] | None = None) -> int:
    """Test the tests; return the exit code."""
    requested = _asked(arguments)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # what runs is ended then
    groups = {
        name: sources_of(rooms)
        for name, rooms in GROUPS.items()
        if name in (requested.groups or GROUPS)
    }
    sources = {path: source for group in groups.values() for path, source in group.items()}
    equal = set(equivalents(sources))
    sample = [
        mutant
        for group in groups.values()
        for mutant in chosen(group, requested.each, requested.seed, equal)
    ]
    sample = shared(sample, *requested.share)
    if not sample:
        print("no faults to be tried")
        return 0
    kept = Kept(requested.out)
    keys = {mutant: mutant.key(sources[mutant.path]) for mutant in sample}
    again = {"survived"} if requested.again else set()
    left = [
        item
        for item in sample
        if kept.results.get(keys[item], {"outcome": "survived"})["outcome"] in again
        or keys[item] not in kept.results
    ]
    print(
        f"{len(sample)} faults in {len({item.path for item in sample})} files, {len(left)} of them to be tried"
    )
    if left:
        with tempfile.TemporaryDirectory(prefix="mutants-") as place:
            _try(left, keys, kept, requested, requested.work or Path(place))
    result = [kept.results[keys[item]] | {"line": item.line} for item in sample]
    print(report(result, sources, sample))
    shares = shares_of(result, sample)
    return (
        0
        if shares["all"] >= requested.least and min(shares.values()) >= requested.least_group
        else 1
    )


def sources_of(rooms: tuple[str, ...]) -> dict[str, bytes]:
    """Return the files of some rooms, by their path in the repository."""
    files = [
        file for room in rooms for file in sorted((ROOT / "src" / "bristle" / room).rglob("*.py"))
    ]
    return {file.relative_to(ROOT).as_posix(): file.read_bytes() for file in files}


def shared(sample: list[Mutant], share: int, shares: int) -> list[Mutant]:
    """Return one of some equal shares of a sample, the first of which is 1: each has its part of every group."""
    return sample[share - 1 :: shares]


def group_of(mutant: Mutant) -> str:
    """Return the group of rooms that a fault is in."""
    return next(name for name, rooms in GROUPS.items() if mutant.room in rooms)


def shares_of(results: list[dict[str, Any]], sample: list[Mutant]) -> dict[str, float]:
    """Return the share of faults that a test noticed, in each group and in all."""
    killed: dict[str, list[bool]] = {"all": [result["outcome"] != "survived" for result in results]}
    for result, mutant in zip(results, sample, strict=True):
        killed.setdefault(group_of(mutant), []).append(result["outcome"] != "survived")
    return {name: sum(outcomes) / len(outcomes) for name, outcomes in killed.items() if outcomes}


class Kept:
    """What was found so far, in a file."""

    def __init__(self, file: Path) -> None:
        self.file = file
        message = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
        self.results: dict[str, dict[str, Any]] = message.get("results", {})
        self.seconds: dict[str, float | None] = message.get("seconds", {})

    def write(self) -> None:
        """Write the file whole, or leave the old one."""
        fresh = self.file.with_name(f"{self.file.name}.partial")
        text = json.dumps(
            {"results": self.results, "seconds": self.seconds}, indent=1, ensure_ascii=False
        )
        fresh.write_text(text, encoding="utf-8")
        fresh.replace(self.file)


def told_equivalent() -> list[dict[str, str]]:
    """Return what is told to be no fault."""
    return tomllib.loads(EQUIVALENTS.read_text(encoding="utf-8")).get("equivalent", [])


def equivalents(sources: dict[str, bytes]) -> dict[str, str]:
    """Return the keys of mutants that are told to be no faults, with the reasons."""
    message = told_equivalent()
    reasons = {
        (item["path"], item["line"], item["old"], item["new"]): item["because"] for item in message
    }
    result = {}
    for path in {item["path"] for item in message} & set(sources):
        source = sources[path]
        for mutant in mutants_of(path, source):
            known = (path, whole_line(source, mutant.begin).strip(), mutant.old, mutant.new)
            if known in reasons:
                result[mutant.key(source)] = reasons[known]
    return result


def _try(
    left: list[Mutant],
    keys: dict[Mutant, str],
    kept: Kept,
    requested: argparse.Namespace,
    place: Path,
) -> None:
    """Run the tests of each fault, those of each file first as it is."""
    benches = [Bench(ROOT, place / str(number)) for number in range(requested.processes)]
    imports = Imports(ROOT)
    near = {
        path: list(islice(imports.tests_of(path), requested.files))
        for path in {item.path for item in left}
    }
    wide = [name for name in WIDE if (ROOT / name).exists()]
    _measure(
        benches,
        sorted({test for tests in (*near.values(), wide) for test in tests}),
        kept,
        requested.budget,
    )

    def jobs() -> Iterator[Job]:
        for mutant in left:
            tests = near_and_wide(near[mutant.path], wide, kept.seconds, requested.budget)
            took = sum(kept.seconds[item] or 0.0 for item in tests)
            yield Job(tuple(tests), SLOWER * took + COMPILING, mutant)

    def done(job: Job, verdict: Verdict) -> None:
        if job.mutant is None:
            raise RuntimeError("a job without a fault")
        survived = verdict.code in (PASSED, NOTHING_COLLECTED)
        outcome = "survived" if survived else "too slow" if verdict.code is None else "killed"
        mutant = job.mutant
        kept.results[keys[mutant]] = {
            "path": mutant.path,
            "kind": mutant.kind,
            "old": mutant.old,
            "new": mutant.new,
            "outcome": outcome,
            "seconds": round(verdict.seconds, 1),
            "by": "" if survived else verdict.failed,
            "tests": list(job.tests),
        }
        kept.write()
        print(
            f"{outcome:9} {verdict.seconds:6.1f} s  {mutant.path[12:]}:{mutant.line} {mutant.kind}",
            flush=True,
        )

    abreast(benches, jobs(), done)


def _measure(benches: list[Bench], tests: list[str], kept: Kept, budget: float) -> None:
    """Find out how long test files take as they are, once compiled. One that fails, or takes too long, is left out."""

    def done(job: Job, verdict: Verdict) -> None:
        (test,) = job.tests
        kept.seconds[test] = round(verdict.seconds, 1) if verdict.code == PASSED else None
        kept.write()
        if verdict.code not in (PASSED, NOTHING_COLLECTED):
            why = "takes too long" if verdict.code is None else f"fails by itself: {verdict.failed}"
            print(f"left out: {test} {why}", flush=True)

    left = [item for item in tests if item not in kept.seconds]
    abreast(benches, (Job((item,), COLD * budget) for item in left), done)
    _share_compiled(benches)
    slow = [item for item in left if (kept.seconds[item] or 0.0) > COLD]
    abreast(benches, (Job((item,), budget) for item in slow), done)


def _share_compiled(benches: list[Bench]) -> None:
    """Give each bench what the others have compiled."""
    first, *rest = benches
    for bench in rest:
        for folder in (bench, first):
            folder.cache.mkdir(exist_ok=True)
        shutil.copytree(bench.cache, first.cache, dirs_exist_ok=True)
    for bench in rest:
        shutil.copytree(first.cache, bench.cache, dirs_exist_ok=True)


def within(tests: list[str], seconds: dict[str, float | None], budget: float) -> list[str]:
    """Return the test files to be run for a fault: the nearest that take no longer than the budget [s] together.

    One that takes longer by itself is run where no other can be.
    """
    result, took = [], 0.0
    message = {test: long for test in tests if (long := seconds.get(test)) is not None}
    for test, long in message.items():
        if took + long <= budget:
            result.append(test)
            took += long
    return result or list(message)[:1]


def near_and_wide(
    near: list[str], wide: list[str], seconds: dict[str, float | None], budget: float
) -> list[str]:
    """Return the nearest test files and behind them those of every room, each once and each group within the budget [s]."""
    return list(dict.fromkeys((*within(near, seconds, budget), *within(wide, seconds, budget))))


def report(found: list[dict[str, Any]], sources: dict[str, bytes], sample: list[Mutant]) -> str:
    """Return the table by group of rooms, and the lines of the faults that no test noticed."""
    rows = [f"\n{'group':16} {'killed':>7} {'survived':>9} {'share':>7} {'s each':>7}"]
    groups = sorted({group_of(item) for item in sample})
    for room in (*groups, "all") if len(groups) > 1 else groups:
        among = [
            item
            for item, mutant in zip(found, sample, strict=True)
            if room in (group_of(mutant), "all")
        ]
        killed = sum(item["outcome"] != "survived" for item in among)
        each = sum(item["seconds"] for item in among) / len(among)
        rows.append(
            f"{room:16} {killed:7} {len(among) - killed:9} {100.0 * killed / len(among):5.0f} % {each:7.1f}"
        )
    for item, mutant in sorted(zip(found, sample, strict=True), key=lambda pair: pair[1]):
        if item["outcome"] == "survived":
            rows.append(
                f"\n{mutant.path}:{mutant.line}  {mutant.kind}\n{difference(mutant, sources[mutant.path])}"
            )
    return "\n".join(rows)


def difference(mutant: Mutant, source: bytes) -> str:
    """Return the line as it is and with the fault."""
    changed = whole_line(applied(mutant, source), mutant.begin)
    return f"  - {whole_line(source, mutant.begin).strip()}\n  + {changed.strip()}"


def _share(text: str) -> tuple[int, int]:
    """Read K/N."""
    share, _, shares = text.partition("/")
    if not (share.isdecimal() and shares.isdecimal() and 1 <= int(share) <= int(shares)):
        raise argparse.ArgumentTypeError(f"{text!r} is not K/N with K from 1 to N, such as 2/8")
    return int(share), int(shares)


def _asked(arguments: list[str] | None) -> argparse.Namespace:
    rooms = "\n".join(f"  {name:15} {' '.join(rooms)}" for name, rooms in GROUPS.items())
    parser = argparse.ArgumentParser(
        prog="python -m tests.mutants",
        description=__doc__.partition("\n")[0],
        epilog=f"A GROUP is named by the first of these words, not by a path; behind it are its folders of src/bristle:\n{rooms}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add: Callable[..., Any] = parser.add_argument
    add(
        "--groups",
        nargs="+",
        choices=tuple(GROUPS),
        metavar="GROUP",
        help="names of groups, see below; all where none is named",
    )
    add("--each", type=int, default=12, help="how many lines of each group")
    add(
        "--share",
        type=_share,
        default=(1, 1),
        metavar="K/N",
        help="only the Kth of N equal shares of these lines",
    )
    add("--seed", type=int, default=12)
    add("--processes", type=int, default=os.cpu_count() or 1)
    add("--files", type=int, default=8, help="how many test files are run for a fault at most")
    add(
        "--budget",
        type=float,
        default=60.0,
        help="how long they may take together without it [s of a processor]",
    )
    add("--again", action="store_true", help="try those again that survived")
    add("--least", type=float, default=0.85, help="share of all that must be noticed")
    add("--least-group", type=float, default=0.75, help="share of each group that must be noticed")
    add(
        "--work",
        type=Path,
        help="where the copies are made, and stay with what was compiled; else nothing stays",
    )
    add("--out", type=Path, default=Path("mutants.json"), help="where what was found is kept")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
