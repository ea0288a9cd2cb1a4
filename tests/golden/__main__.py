"""Freeze the results of identifications and the output of commands, or compare them with the frozen ones.

``python -m tests.golden check [CASE ...]`` prints each difference; exit code 1 if there is one. Numbers frozen on
another processor may differ by more than their last bits (`tests.golden.comparison`); ``--relative 1e-6`` sets another
tolerance. The slow cases compare many models on logs that do not determine them. There, a search that stops at a
tolerance ends at another point on another processor. So `check` prints all differences of slow cases, but counts them
only on the processor of the frozen results.
``python -m tests.golden freeze [CASE ...]`` writes the present results, ``list`` prints the names of the cases.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
import traceback
from collections.abc import Callable
from functools import partial

import tests.blas  # before numpy
import tests.golden.cases
import tests.golden.commands  # noqa: F401  (both register theirs)
from tests.golden.case import CASES, Case, differences_of, tolerance_for
from tests.golden.comparison import frozen_text
from tests.golden.machine import elsewhere, note

TOLD, CRASH = 20, "ended with"  # differences of a case, and what no processor excuses
SAME, FROZEN = ["the same"], ["frozen"]


def main() -> int:
    """Do what is asked."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.golden", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("action", choices=("check", "freeze", "list"))
    parser.add_argument("cases", nargs="*", metavar="CASE", help="all where none is named")
    parser.add_argument("--fast", action="store_true", help="those that run among the tests only")
    parser.add_argument(
        "--relative", type=float, metavar="SHARE", help="by which numbers may differ"
    )
    chosen = parser.parse_args()
    unknown = [name for name in chosen.cases if name not in CASES]
    if unknown:
        parser.error(f"no such case: {', '.join(unknown)}")
    cases = [CASES[name] for name in chosen.cases or CASES]
    cases = [case for case in cases if case.fast or not chosen.fast]
    if chosen.action == "list":
        for case in cases:
            print(
                case.name,
                "fast" if case.fast else "slow",
                "measured" if case.measured else "",
                sep="\t",
            )
        return 0
    if chosen.action == "check":
        return _run(cases, partial(_checked, chosen.relative))
    return _run(cases, _frozen)


def _run(cases: list[Case], work: Callable[[Case], list[str]]) -> int:
    wrong, uncounted, begun = [], [], time.process_time()
    for case in cases:
        if case.measured and not os.environ.get("BRISTLE_DATA"):
            print(
                f"{case.name}: left out, BRISTLE_DATA names no folder of measured logs", flush=True
            )
            continue
        start = time.process_time()
        try:
            text = work(case)
        except Exception as error:  # noqa: BLE001  (whatever it is, the other cases tell more)
            traceback.print_exc()
            text = [f"{CRASH} {error!r}"]
        took = f"{'fast' if case.fast else 'slow'}, {time.process_time() - start:.1f} s of CPU"
        print(
            f"{case.name} ({took}): {text[0] if len(text) == 1 else f'{len(text)} differences'}",
            flush=True,
        )
        if text not in (SAME, FROZEN):
            (
                wrong
                if case.fast or text[0].startswith(CRASH) or not elsewhere(case.name)
                else uncounted
            ).append(case.name)
        for line in text[:TOLD] if len(text) > 1 else ():
            print(f"  {case.name}: {line}", flush=True)
    print(
        f"{len(cases)} cases, {time.process_time() - begun:.0f} s of CPU; wrong: {', '.join(wrong) or 'none'}"
    )
    if uncounted:
        print(f"differ, not counted ({elsewhere(uncounted[0])}): {', '.join(uncounted)}")
    return 1 if wrong else 0


def _frozen(case: Case) -> list[str]:
    case.file.parent.mkdir(exist_ok=True)
    case.file.write_text(frozen_text(case.found()), encoding="utf-8")
    note(case.name)
    return FROZEN


def _checked(relative: float, case: Case) -> list[str]:
    return [str(item) for item in differences_of(case, relative or tolerance_for(case))] or SAME


if __name__ == "__main__":
    sys.exit(main())
