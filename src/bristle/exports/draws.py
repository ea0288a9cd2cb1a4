"""Draws of what was identified, a row each, with the correlations of the fit: for simulators that vary an axis."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError, MissingExtraError
from bristle.core.tabular import library
from bristle.exports.mjcf import mjcf_attributes

__all__ = ["draws_files"]

SEED = 0
MASS, OFFSET = "M", "offset"


def draws_files(
    model: Model, plant: Model | None, drawn: Mapping[str, np.ndarray], count: int, name: str
) -> tuple[dict[str, str | bytes], tuple[str, ...]]:
    """Return tables of draws, and what is to be known of them, a sentence each.

    Parameters
    ----------
    model : Model
        The friction model that was identified.
    plant : Model or None
        What it is on, where that is known.
    drawn : mapping of str to ndarray, shape (draw,) or (draw, element)
        What the bootstrap found, in SI, by name of a parameter.
    count : int
        How many rows are wanted.
    name : str
        What the files are called.

    Returns
    -------
    files : dict
        ``NAME_draws.csv``, the same as Parquet where pyarrow is there, and ``NAME_mjcf.csv`` where MuJoCo has this
        friction: a column for each attribute of the scene that the target mjcf writes.
    notes : tuple of str
        Whether rows were drawn again, and which were left out.

    Raises
    ------
    InputError
        If there are no draws, or fewer than one is wanted.
    """
    if not drawn:
        raise InputError("holds no draws: it was identified without intervals", path="draws",
                         mend="Identify again with --draws 1000, and export the folder of its results")  # fmt: skip
    if count < 1:
        raise InputError("out of range", path="draws", value=count, allowed="1 or more")
    stored = min(len(values) for values in drawn.values())
    notes = [f"{count} of the {stored} draws of the fit"] if count <= stored else [
        f"{count} draws, with replacement, of the {stored} of the fit: identify with --draws {count} for as many others"
    ]  # fmt: skip
    rows = np.arange(count) if count <= stored else np.random.default_rng(SEED).integers(stored, size=count)
    chosen = {key: np.asarray(values, dtype=float)[rows] for key, values in drawn.items()}
    columns = {column: values for key, array in chosen.items() for column, values in _columns(key, array).items()}
    units = {column: _unit(column.partition("[")[0], model, plant) for column in columns}
    files: dict[str, str | bytes] = {f"{name}_draws.csv": _text(columns, units)}
    try:
        files[f"{name}_draws.parquet"] = _parquet(columns, units)
    except MissingExtraError:
        notes.append('Parquet needs pyarrow: pip install "bristle[io]"')
    scenes, refused = _attributes(model, plant, chosen, count)
    if scenes is not None:
        files[f"{name}_mjcf.csv"] = _text(scenes, {})
    if refused:
        notes.append(f"{refused} of them break a condition of the model and are left out of {name}_mjcf.csv")
    return files, tuple(notes)


def _columns(name: str, values: np.ndarray) -> dict[str, np.ndarray]:
    return {name: values} if values.ndim == 1 else {f"{name}[{k}]": column for k, column in enumerate(values.T)}


def _unit(name: str, model: Model, plant: Model | None) -> str:
    owners = (owner for owner in (model, plant) if owner is not None and name in owner.component.variables)
    owner = next(owners, None)
    return "" if owner is None else owner.component.variables[name].unit(owner.kind)


def _text(columns: Mapping[str, Any], units: Mapping[str, str]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([f"{name} [{units[name]}]" if units.get(name, "1") not in ("", "1") else name for name in columns])
    writer.writerows(zip(*(values.tolist() if isinstance(values, np.ndarray) else values
                           for values in columns.values()), strict=True))  # fmt: skip
    return out.getvalue()


def _parquet(columns: Mapping[str, np.ndarray], units: Mapping[str, str]) -> bytes:
    wanted_by = "draws as Parquet"
    pyarrow, parquet = library("pyarrow", wanted_by), library("pyarrow.parquet", wanted_by)
    fields = [pyarrow.field(name, pyarrow.float64(), metadata={"unit": units[name]}) for name in columns]
    arrays = [pyarrow.array(values.tolist(), pyarrow.float64()) for values in columns.values()]
    sink = pyarrow.BufferOutputStream()
    parquet.write_table(pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields)), sink)
    return sink.getvalue().to_pybytes()


def _attributes(
    model: Model, plant: Model | None, chosen: Mapping[str, np.ndarray], count: int
) -> tuple[dict[str, list[str]] | None, int]:
    """Return what each draw is in a scene of MuJoCo, and how many are none; None where it has no such friction."""
    own = {key: values for key, values in chosen.items() if key in model.component.variables}
    mass = float(plant.values.get(MASS, 1.0)) if plant is not None else 1.0
    masses = chosen.get(MASS, np.full(count, mass))
    columns: dict[str, list[str]] = {}
    refused = 0
    for row in range(count):
        try:
            drawn = model.with_values(**{key: values[row] for key, values in own.items()})
        except InputError:
            refused += 1
            continue
        try:
            attributes = {"draw": str(row), **mjcf_attributes(drawn, float(masses[row]))}
        except InputError:
            return None, 0
        if OFFSET in own:  # a motor with constant control
            attributes["key.ctrl"] = f"0 {-float(own[OFFSET][row])!r}"
        for key, value in attributes.items():
            columns.setdefault(key, []).append(value)
    return columns, refused
