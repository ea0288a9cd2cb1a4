"""Leave each test out in turn, within each set and tension: fit to the others, predict this test, compare the errors.

Usage: ``python leave_one_out.py brfd_all.npz [--models coulomb,gap_slider+asymmetry] [--only "set 1, 20 lb"]``.
The models predict the tests at 2 Hz, but are not fitted to them.
"""

import argparse
import json
import re
from collections import defaultdict
from pathlib import Path

import numpy as np

import bristle as br
from bristle.files import read_axis

NAME = re.compile(r"dataset-(\d)__.*__([\d.]+)Hz(\d+)lb")
AXIS = Path(__file__).parent / "axis.toml"
FAST = 2.0  # [Hz]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("--models", default="coulomb,gap_slider+asymmetry")
    parser.add_argument("--only", help="run one group only, named as in the output")
    parser.add_argument("--json", type=Path, help="JSON file for the errors")
    chosen = parser.parse_args()
    models, found = chosen.models.split(","), []
    for group, tests in groups(chosen.file).items():
        if chosen.only not in (None, group):
            continue
        for row in errors_of(chosen.file, tests, models):
            told = "  ".join(f"{one} {row[one] / row['std']:.3f}" for one in models)
            print(
                f"{group:15} {row['frequency']:5g} Hz  {row['test'].split('__')[-1]:32} {told}",
                flush=True,
            )
            found.append({"group": group} | row)
    for name, rows in parts(found).items():
        pooled = {one: float(np.sqrt(np.mean([row[one] ** 2 for row in rows]))) for one in models}
        ratios = {one: [row[models[0]] / row[one] for row in rows] for one in models[1:]}
        print(
            f"{name}, {len(rows)} tests: pooled error",
            {one: f"{value:.4g} N" for one, value in pooled.items()},
        )
        for one, ratio in ratios.items():
            pooled_ratio = pooled[models[0]] / pooled[one]
            spread = f"median {np.median(ratio):.2f}, smallest {min(ratio):.2f}"
            print(f"  error of {models[0]} / error of {one}: pooled {pooled_ratio:.2f}, {spread}")
    if chosen.json:
        chosen.json.write_text(json.dumps(found, indent=1))


def groups(file: Path) -> dict[str, list[tuple[str, float]]]:
    """Return the tests, name and frequency [Hz], of each set and tension."""
    found = defaultdict(list)
    for name in np.load(file).files:
        place, frequency, tension = NAME.match(name).groups()
        found[f"set {place}, {tension} lb"].append((name, float(frequency)))
    return dict(found)


def errors_of(file: Path, tests: list[tuple[str, float]], models: list[str]) -> list[dict]:
    """Return the rms force error [N] of each model on each test, fitted to the other tests."""
    axis = read_axis(AXIS)
    logs = {name: br.read_log(f"{file}::{name}", axis) for name, _ in tests}
    slow = [name for name, frequency in tests if frequency < FAST]
    # identify holds out each of several logs in turn. draws=0: no intervals.
    found = br.identify([logs[name] for name in slow], models, axis=axis, draws=0)
    rows = []
    for name, frequency in tests:
        effort = logs[name].effort.values
        row = {"test": name, "frequency": frequency, "std": float(np.std(effort))}
        for fit in found.fits:
            if name in slow:
                percent = fit.held_out.block_errors_percent[slow.index(name)]
                row[fit.name] = 0.01 * percent * float(np.sqrt(np.mean(effort**2)))
            else:
                predicted = br.predict(fit.plant, fit.friction, logs[name], axis)
                row[fit.name] = float(
                    np.sqrt(np.mean((predicted.effort - predicted.effort_predicted) ** 2))
                )
        rows.append(row)
    return rows


def parts(found: list[dict]) -> dict[str, list[dict]]:
    """Return the tests of each kind: slow tests with a tight band, tests with a loose band, and fast tests."""
    kinds = {
        "20 lb and more, up to 1 Hz": lambda row: (
            not row["group"].endswith(" 0 lb") and row["frequency"] < FAST
        ),
        "0 lb": lambda row: row["group"].endswith(" 0 lb"),
        "2 Hz": lambda row: row["frequency"] >= FAST,
    }
    chosen = {name: [row for row in found if wanted(row)] for name, wanted in kinds.items()}
    return {name: rows for name, rows in chosen.items() if rows}


if __name__ == "__main__":
    main()
