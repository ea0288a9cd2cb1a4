"""Leave one test out, within each set and tension of the damper: fit to the others, predict it, compare the errors.

Usage: ``python leave_one_out.py brfd_all.npz [--models coulomb,gap_slider+asymmetry] [--only "set 1, 20 lb"]``.
The tests at 2 Hz are predicted, but nothing is fitted to them.
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


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("--models", default="coulomb,gap_slider+asymmetry")
    parser.add_argument("--only", help="one group, as it is printed")
    parser.add_argument("--json", type=Path, help="write the errors into this file")
    chosen = parser.parse_args()
    axis, found = read_axis(AXIS), []
    for group, tests in groups(chosen.file).items():
        if chosen.only not in (None, group):
            continue
        logs = {name: br.read_log(f"{chosen.file}::{name}", axis) for name, _ in tests}
        for left, frequency in tests:
            fitted = [logs[name] for name, other in tests if name != left and other < 2.0]
            errors = {model: error(fitted, logs[left], model, axis) for model in chosen.models.split(",")}
            deviation = float(np.std(logs[left].effort.values))
            print(f"{group:15} {frequency:4g} Hz  {left.split('__')[-1]:32}", end=" ")
            print("  ".join(f"{one} {value / deviation:.3f}" for one, value in errors.items()), flush=True)
            found.append({"group": group, "test": left, "frequency": frequency, "std": deviation} | errors)
    for name, kept in parts(found).items():
        pooled = {one: np.sqrt(np.mean([row[one] ** 2 for row in kept])) for one in chosen.models.split(",")}
        print(f"pooled, {name} ({len(kept)} tests):", {one: f"{value:.4g} N" for one, value in pooled.items()})
    if chosen.json:
        chosen.json.write_text(json.dumps(found, indent=1))


def groups(file: Path) -> dict[str, list[tuple[str, float]]]:
    """Return the tests, name and frequency [Hz], of each set and tension."""
    found = defaultdict(list)
    for name in np.load(file).files:
        place, frequency, tension = NAME.match(name).groups()
        found[f"set {place}, {tension} lb"].append((name, float(frequency)))
    return dict(found)


def error(fitted: list, left, model: str, axis) -> float:
    """Return the root mean square of the error of the force [N] on a test that was left out."""
    best = br.identify(fitted, model, axis=axis, blocks=0).best
    predicted = br.predict(best.plant, best.friction, left, axis)
    return float(np.sqrt(np.mean((predicted.effort - predicted.effort_predicted) ** 2)))


def parts(found: list[dict]) -> dict[str, list[dict]]:
    """Return the tests of each kind: those that the model is for, those of a loose band, and the fast ones."""
    kinds = {
        "20 lb and more, up to 1 Hz": lambda row: not row["group"].endswith(" 0 lb") and row["frequency"] <= 1.0,
        "0 lb": lambda row: row["group"].endswith(" 0 lb"),
        "2 Hz": lambda row: row["frequency"] > 1.0,
    }
    chosen = {name: [row for row in found if wanted(row)] for name, wanted in kinds.items()}
    return {name: rows for name, rows in chosen.items() if rows}


if __name__ == "__main__":
    main()
