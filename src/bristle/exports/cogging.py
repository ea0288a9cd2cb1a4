"""Cogging for a drive that compensates it by harmonics: order, amplitude and phase, the largest first.

Drives differ in the origin of the angle and in the sign of the phase, and public documentation states neither. The file
states its own convention; the user converts it.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from bristle.core import InputError, Model
from bristle.exports.described import Request
from bristle.exports.drive import behind_comments, rows_of, said_of_units
from bristle.exports.effect import Drive
from bristle.exports.targets import Product
from bristle.models.plants.terms import TermedPlant, terms_of
from bristle.prediction.drive_units import table_units

MOST = 9


class Wave(NamedTuple):
    """One harmonic: shaft, periods per turn, amplitude [N or N*m] and phase [deg, 0 to 360)."""

    turner: str
    order: int
    amplitude: float
    phase: float


def write(request: Request) -> Product:
    """Return the harmonics."""
    waves = _waves_of(request.plant)
    efforts = table_units(request.axis, request.model.kind).efforts
    notes = said_of_units(request.axis, efforts[0])
    if left := waves[MOST:]:
        amplitude = efforts[0].of(sum(wave.amplitude for wave in left))
        orders = ", ".join(str(wave.order) for wave in left)
        notes = (
            f"the file has at most {MOST} harmonics: bristle omitted the orders {orders}, in total {amplitude:.2g} {efforts[0].name}",
            *notes,
        )
    head = [
        "Cogging: add this effort to the command of the drive: the sum of amplitude * cos(order * angle - phase).",
        "angle: 0 at position 0 of the log, growing with the position. A drive has its own zero and may define the "
        "phase differently: test the sign with a part of the amplitude.",
        *request.source.lines,
        *notes,
    ]
    columns = ["order", *(f"amplitude [{unit.name}]" for unit in efforts), "phase [deg]", "turn of"]
    rows = [
        ",".join(
            [
                str(wave.order),
                *(f"{unit.of(wave.amplitude):.6g}" for unit in efforts),
                f"{wave.phase:.4f}",
                wave.turner,
            ]
        )
        for wave in waves[:MOST]
    ]
    return Product({f"{request.name}.csv": behind_comments(head, ",".join(columns), *rows)}, notes)


def _waves_of(plant: Model | None) -> list[Wave]:
    """Return the cogging of a plant, the largest harmonic first."""
    terms = None
    if plant is not None:
        terms = terms_of(plant)
    if plant is None or terms is None or not terms.cosines.size:
        raise InputError(
            "was not identified",
            path="cogging",
            value="" if plant is None else plant.name,
            mend="Write [[cogging]] into the axis file, identify again, and export the new model",
        )
    component: TermedPlant = plant.component
    parts = zip(component.orders, terms.cosines.tolist(), terms.sines.tolist(), strict=True)
    waves = [
        Wave(
            turner, order, math.hypot(cosine, sine), math.degrees(math.atan2(sine, cosine)) % 360.0
        )
        for (turner, order), cosine, sine in parts
    ]
    return sorted(waves, key=lambda wave: -wave.amplitude)


def reads(files: Mapping[str, str | bytes], request: Request) -> Drive | None:
    """Return the effort that a drive computes from the harmonics at each position."""
    plant = request.plant
    if plant is None:
        return None
    effort = table_units(request.axis, request.model.kind).efforts[0]
    rows = rows_of(str(files[f"{request.name}.csv"]))
    turns = {turner: plant.values[f"{turner}_turn"] for *_, turner in rows}

    def drive(x: np.ndarray, dt: float) -> np.ndarray:
        force = np.zeros(x.size)
        for order, amplitude, *_, phase, turner in rows:
            angle = 2.0 * math.pi * int(order) * x / turns[turner]
            force += float(amplitude) * effort.si * np.cos(angle - math.radians(float(phase)))
        return force

    return drive
