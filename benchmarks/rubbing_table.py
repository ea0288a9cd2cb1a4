"""Omissions of the rigid inertia in the source paper, its plant (18), if the friction acts on the table.

The loops of set A run on the rig of the paper, whose friction now acts on a table behind an elastic screw. The encoder
remains on the motor. Forces and lengths are those at the table. ``python -m benchmarks.rubbing_table`` prints the errors.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from importlib.resources import as_file, files
from typing import Any, NamedTuple

from bristle import friction, plants
from bristle.core import Experiment, Variant
from bristle.files import read_experiment
from bristle.simulation import simulate

__all__ = ["Row", "rows"]

TABLE = 20.0  # kg
DAMPING = 0.02  # ratio of the table on its screw
STIFFNESSES = (math.inf, 300e6, 100e6, 30e6)  # N/m
LOOPS = ("none", "printed", "identified", "observer_feedforward")


class Row(NamedTuple):
    """Peak-to-peak errors of a loop [m]: of the encoder on the motor, and of the table."""

    stiffness: float
    loop: str
    encoder: float
    table: float


def rows() -> Iterator[Row]:
    """Yield the errors of each loop on each screw, also with the friction of the table and the wind-up fed forward."""
    with as_file(files("bristle.apps.paper") / "experiments") as folder:
        variants = [
            variant
            for variant in read_experiment(folder / "set_a.toml").variants
            if variant.name in LOOPS
        ]
    for stiffness in STIFFNESSES:
        rigid = math.isinf(stiffness)
        loops = variants if rigid else [on_a_screw(variant, stiffness) for variant in variants]
        loops += (
            []
            if rigid
            else [
                wound_up(loop)
                for loop in loops
                if loop.feedforward.friction is not None and loop.name != "printed"
            ]
        )
        for name, result in simulate(
            Experiment("set A", loops[0].plant.kind, tuple(loops))
        ).variants.items():
            yield Row(
                stiffness, name, result.following_error.peak_to_peak, result.true_error.peak_to_peak
            )


def on_a_screw(variant: Variant, stiffness: float) -> Variant:
    """Return a loop of the paper with its friction on a table behind a screw."""
    mass, damper = variant.plant.values["M"], 2.0 * DAMPING * math.sqrt(stiffness * TABLE)
    # A lead of 2 pi: one radian of the motor is one metre of the table.
    screw = plants.ball_screw(
        kind="rotational", J=mass - TABLE, M=TABLE, lead=2.0 * math.pi, k=stiffness, d=damper
    )
    fed = variant.feedforward
    return replace(
        variant,
        plant=screw,
        friction=friction.viscous(kind="rotational", F_v=0.0),
        table=variant.friction,
        sensor_at="motor",
        feedforward=replace(fed, friction=rotational(fed.friction)),
        **{
            name: rotational(getattr(variant, name))
            for name in ("controller", "sensor", "reference")
        },
    )


def wound_up(loop: Variant) -> Variant:
    """Return a loop that feeds the friction of the table forward with the wind-up of the screw."""
    fed = loop.feedforward
    table = replace(fed.friction, kind="translational") if fed.friction is not None else None
    return replace(
        loop,
        name=f"{loop.name}, wound up",
        feedforward=replace(fed, plant=loop.plant, table=table, friction=None),
    )


def rotational(model: Any) -> Any:
    """Return a model of the travel as that of an equal angle."""
    return None if model is None else replace(model, kind="rotational")


if __name__ == "__main__":
    print(
        "stiffness [N/um]  loop                            encoder [um]  table [um]  (peak to peak)"
    )
    for row in rows():
        print(
            f"{1e-6 * row.stiffness:>16.4g}  {row.loop:<30}  {1e6 * row.encoder:>12.2f}  {1e6 * row.table:>10.2f}"
        )
