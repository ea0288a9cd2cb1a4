"""What bands around a prediction are made of, as a table of a model file."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core.errors import InputError
from bristle.files.components import check_keys, key_of, table_at

if TYPE_CHECKING:
    from tomlkit.items import Table


NUMBERS = ("scatter", "noise", "unexplained", "lasting", "inflation", "left_in_closed_loop", "left_in_open_loop")
MEMBERS = 40
DIGITS = 7


def bands_table(bands: Any) -> Table:
    """Return the table of a model file, with as many sets of parameters as a band is drawn from."""
    import tomlkit

    table = tomlkit.table()
    for name in NUMBERS:
        table.add(name, float(getattr(bands, name)))
    table["scatter"].comment("of the level of friction from reversal to reversal, a share of it")
    table["noise"].comment("of the effort, sample by sample")
    table["unexplained"].comment("left over beyond noise, encoder and scatter")
    table["lasting"].comment("s over which that keeps its side")
    table["inflation"].comment("factor set on blocks that were held out")
    for loop in ("closed", "open"):
        table[f"left_in_{loop}_loop"].comment("of the position in a simulation, beyond all that")
    draws = tomlkit.table()
    for name, values in bands.draws.items():
        draws.add(key_of(name), tomlkit.item([_short(draw) for draw in values[:MEMBERS]]))
    table.add("draws", draws)
    return table


def _short(value: Any) -> Any:
    if np.ndim(value):
        return [_short(entry) for entry in value]
    return float(f"{float(value):.{DIGITS}g}")


def bands_at(value: Any, parameters: Collection[str]) -> dict[str, Any] | None:
    """Return the table as `bristle.identification.simulated_bands.Bands` takes it; None where there is none."""
    if value is None:
        return None
    table = table_at(value, "bands")
    check_keys(table, (*NUMBERS, "draws"), "bands")
    bands: dict[str, Any] = {}
    for name in NUMBERS:
        if name not in table:
            raise InputError(
                "is missing, as from an earlier version",
                path=f"bands.{name}",
                mend="Identify again, or leave [bands] out to predict without bands",
            )
        number = table[name]
        if isinstance(number, bool) or not isinstance(number, (int, float)) or not math.isfinite(number) or number < 0:
            raise InputError(
                "must be a number", path=f"bands.{name}", value=number, allowed=">= 0", mend="Leave [bands] out to predict without bands"
            )
        bands[name] = float(number)
    names = {key_of(name): name for name in parameters}
    draws = table_at(table.get("draws", {}), "bands.draws")
    check_keys(draws, names, "bands.draws")
    bands["draws"] = {names[key]: _draws(draw, f"bands.draws.{key}") for key, draw in draws.items()}
    if len({len(draw) for draw in bands["draws"].values()}) > 1:
        raise InputError("must have as many numbers for each parameter", path="bands.draws")
    return bands


def _draws(value: Any, path: str) -> np.ndarray:
    try:
        numbers = np.array(value, dtype=float)
    except (TypeError, ValueError):
        numbers = np.zeros(())
    if numbers.ndim not in (1, 2) or not np.all(np.isfinite(numbers)):
        raise InputError("must be a list of numbers, or of lists of one length", path=path)
    return numbers
