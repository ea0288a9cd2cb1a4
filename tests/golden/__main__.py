"""Freeze what identifications find, or check that they find it still.

``python -m tests.golden check [CASE ...]``: runs all cases, tells each difference, exit code 1 if there is one.
``python -m tests.golden freeze [CASE ...]``: writes what is found now. ``python -m tests.golden list``: their names.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
import traceback
from itertools import islice

import tests.golden.cases  # noqa: F401  (it registers them)
from tests.golden.case import CASES, Case
from tests.golden.comparison import differences, frozen_text

TOLD = 20  # differences of a case


def main() -> int:
    """Do what is asked."""
    parser = argparse.ArgumentParser(prog="python -m tests.golden", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("action", choices=("check", "freeze", "list"))
    parser.add_argument("cases", nargs="*", metavar="CASE", help="all where none is named")
    parser.add_argument("--fast", action="store_true", help="those that run among the tests only")
    chosen = parser.parse_args()
    unknown = [name for name in chosen.cases if name not in CASES]
    if unknown:
        parser.error(f"no such case: {', '.join(unknown)}")
    cases = [CASES[name] for name in chosen.cases or CASES]
    cases = [one for one in cases if one.fast or not chosen.fast]
    if chosen.action == "list":
        for one in cases:
            print(one.name, "fast" if one.fast else "slow", "measured" if one.measured else "", sep="\t")
        return 0
    return _run(cases, freeze=chosen.action == "freeze")


def _run(cases: list[Case], *, freeze: bool) -> int:
    wrong, begun = [], time.process_time()
    for case in cases:
        if case.measured and not os.environ.get("BRISTLE_DATA"):
            print(f"{case.name}: left out, BRISTLE_DATA names no folder of measured logs", flush=True)
            continue
        start = time.process_time()
        try:
            found = case.work()
        except Exception:  # noqa: BLE001  (whatever it is, the other cases tell more)
            print(f"{case.name}: ended with", flush=True)
            traceback.print_exc()
            wrong.append(case.name)
            continue
        took = f"{case.name} ({'fast' if case.fast else 'slow'}, {time.process_time() - start:.1f} s of CPU)"
        if freeze:
            case.file.parent.mkdir(exist_ok=True)
            case.file.write_text(frozen_text(found), encoding="utf-8")
            print(f"{took}: frozen, {case.file.stat().st_size / 1000:.0f} kB", flush=True)
        elif told(case, found, took):
            wrong.append(case.name)
    print(f"{len(cases)} cases, {time.process_time() - begun:.0f} s of CPU; differ: {', '.join(wrong) or 'none'}")
    return 1 if wrong else 0


def told(case: Case, found: dict, took: str) -> bool:
    """Tell how a case differs from what was frozen, and return whether it does."""
    if not case.file.is_file():
        print(f"{took}: was never frozen", flush=True)
        return True
    # What is found goes through JSON as what was frozen did.
    found = json.loads(frozen_text(found))
    every = list(differences(json.loads(case.file.read_text(encoding="utf-8")), found))
    print(f"{took}: {f'{len(every)} differences' if every else 'the same'}", flush=True)
    for one in islice(every, TOLD):
        print(f"  {case.name}: {one}", flush=True)
    if len(every) > TOLD:
        print(f"  and {len(every) - TOLD} more", flush=True)
    return bool(every)


if __name__ == "__main__":
    sys.exit(main())
