"""Terms of a plant that an axis file names: gravity of a link, cogging, known columns."""

from __future__ import annotations

import math
import re
from typing import Any

from bristle.core.axis import Cogging, KnownColumn
from bristle.core.errors import InputError
from bristle.core.motion import Transmission
from bristle.files.schema import AxisFile


def terms_of(file: AxisFile, transmission: Transmission) -> dict[str, Any]:
    """Return the terms of an axis by the names that `Axis` has for them."""
    return {"gravity": _gravity(file), "cogging": _cogging(file, transmission), "regressors": _columns(file)}


def _gravity(file: AxisFile) -> bool:
    if file.plant.gravity is not None and file.kind != "rotational":
        raise InputError(
            "turns with the angle of a link, and this axis is translational",
            path="plant.gravity",
            value=file.plant.gravity,
            mend="A weight on a vertical axis is the offset, which is identified",
        )
    return file.plant.gravity is not None


def _cogging(file: AxisFile, transmission: Transmission) -> tuple[Cogging, ...]:
    turners = [entry.turn for entry in file.cogging]
    for place, turner in enumerate(turners):
        if turner in turners[:place]:
            raise InputError(
                "is there twice", path=f"cogging[{place}].turn", value=turner, mend="Write all its harmonics into one [[cogging]]"
            )
    coggings = []
    for place, entry in enumerate(file.cogging):
        try:
            side = "motor" if entry.turn == "motor" else "load"
            turn = 2.0 * math.pi * transmission.travel("rotational", side)
        except InputError:
            raise InputError(
                "needs to know how far a turn moves the axis",
                path=f"cogging[{place}].turn",
                value=entry.turn,
                mend='Write lead = "10 mm" (and gear_ratio, where there is a gear) under [transmission]',
            ) from None
        harmonics = None if entry.harmonics == "identify" else tuple(sorted(set(entry.harmonics)))
        coggings.append(Cogging(entry.turn, turn, harmonics))
    return tuple(coggings)


def _columns(file: AxisFile) -> tuple[KnownColumn, ...]:
    columns: list[KnownColumn] = []
    for place, entry in enumerate(file.known):
        name = entry.name or re.sub(r"\W+", "_", entry.column).strip("_") or f"column_{place + 1}"
        if name in [column.name for column in columns]:
            raise InputError("is there twice", path=f"known[{place}].name", value=name, mend="Give each known column a name of its own")
        columns.append(KnownColumn(entry.column, name, entry.optional))
    return tuple(columns)
