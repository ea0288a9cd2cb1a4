"""`python -m benchmarks.strangers --seed 5 --family coulomb --out x.csv`: write a record as CSV and its true values as JSON."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from benchmarks.strangers.draw import make
from benchmarks.strangers.habits import HABITS
from benchmarks.strangers.lies import LIES, Lied
from benchmarks.strangers.truth import FAMILIES, MOTIONS, Record


def write(record: Record, path: Path) -> None:
    """Write a record with a line of headers: the name and unit of each column."""
    length = record.position_unit
    columns = {"time [s]": record.t, f"position [{length}]": record.position}
    columns[f"effort [{record.effort_unit}]"] = record.effort
    if record.reference is not None:
        columns[f"reference [{length}]"] = record.reference
    if record.velocity is not None:
        columns[f"velocity [{length}/s]"] = record.velocity
    np.savetxt(
        path,
        np.column_stack(list(columns.values())),
        "%.10g",
        ",",
        header=",".join(columns),
        comments="",
    )


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.strangers", description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--family", choices=FAMILIES, default="lugre")
    parser.add_argument(
        "--motion", choices=MOTIONS, help="kind of motion; default: drawn from the seed"
    )
    parser.add_argument("--lie", choices=sorted(LIES), help="fault to add to the record")
    parser.add_argument(
        "--out",
        type=Path,
        help="CSV file for the record; the true values go into a JSON file of the same name",
    )
    parser.add_argument("--picture", type=Path, help="PNG file for a picture of the record")
    parser.add_argument(
        "--list", action="store_true", help="list friction families, motions and faults"
    )
    given = parser.parse_args()
    if given.list or (given.out is None and given.picture is None):
        print("families:", *FAMILIES, "\nmotions:", *MOTIONS, "\nfaults:")
        for name, lie in LIES.items():
            print(
                f"  {name}{' (from practice)' if name in HABITS else ''}: {(lie.__doc__ or '').splitlines()[0]}"
            )
        return
    truth, record = make(given.seed, given.family, given.motion)
    lied = (
        Lied("", truth, record, "", 0.0)
        if given.lie is None
        else LIES[given.lie](truth, record, given.seed)
    )
    if given.out is not None:
        write(lied.record, given.out)
        told = lied.truth.told() | {"effort_lead": lied.truth.effort_lead}
        told["lie"] = {
            "name": lied.name,
            "told": lied.told,
            "value": lied.value,
            "claimed_mass": lied.claimed_mass,
        }
        given.out.with_suffix(".json").write_text(
            json.dumps(told, indent=1) + "\n", encoding="utf-8"
        )
    if given.picture is not None:
        from benchmarks.strangers.pictures import picture

        picture(lied.truth, lied.record, given.picture)


if __name__ == "__main__":
    main()
