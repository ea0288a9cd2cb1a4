"""Record first-order reversal branches of the virtual rig, with encoder steps and noise: branches.csv and record.csv."""

import csv
import sys

import numpy as np

import bristle as br
from bristle.files.model import read_model

BRANCHES = 100
EXTENT = 7e-6  # m, of the table: the outer loop
SPEED = 2e-6  # m/s, slow enough for quasi-static loops
COUNT = 0.125e-6  # m, of the encoder
NOISE = 0.25  # N, standard deviation of the force: 0.2 mN*m of the screw
SAMPLE_TIME = 5e-3  # s


def motion():
    """Return the positions [m] of the whole motion, and the samples of its reversals.

    The motion is one cycle of the outer loop. Then, for each branch, it rises to the reversal and falls to the lower end.
    """
    tops = EXTENT * (1.0 - 2.0 * np.arange(BRANCHES) / BRANCHES)
    branches = np.column_stack([tops, np.full(BRANCHES, -EXTENT)]).ravel()
    corners = np.array([0.0, -EXTENT, EXTENT, -EXTENT, *branches])
    samples = np.maximum(np.round(np.abs(np.diff(corners)) / (SPEED * SAMPLE_TIME)).astype(int), 1)
    turns = np.concatenate([[0], np.cumsum(samples)])
    return np.interp(np.arange(turns[-1] + 1), turns, corners), turns


def stroke(x, force):
    """Return one point for each encoder step between two reversals: position and mean force."""
    way = 1.0 if x[-1] > x[0] else -1.0
    counts, places = np.unique(way * np.round(x / COUNT), return_inverse=True)
    return way * COUNT * counts, np.bincount(places, force) / np.bincount(places)


def write(target, head, rows):
    """Write a table: positions in micrometres, forces in newtons."""
    with open(target, "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(head)
        table.writerows([*number, f"{1e6 * u:.3f}", f"{f:.4f}"] for *number, u, f in rows)


def main(rig="paper/set_a_rig.toml"):
    """Record the rig along the motion and write both tables."""
    x, turns = motion()
    force = br.response(read_model(rig).friction, x, dt=SAMPLE_TIME)
    force = force + NOISE * np.random.default_rng(0).standard_normal(x.size)
    ends = zip(turns[:-1].tolist(), turns[1:].tolist(), strict=True)
    strokes = [np.column_stack(stroke(x[a : b + 1], force[a : b + 1])).tolist() for a, b in ends]
    write("record.csv", ["x", "F"], [row for one in strokes for row in one])
    write(
        "branches.csv",
        ["branch", "x", "F"],
        [(k, *row) for k, one in enumerate(strokes[4::2], 1) for row in one],
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
