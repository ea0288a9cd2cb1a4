"""Draws of what was identified, a row each, with the correlations of the fit: for simulators that vary an axis."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError, MissingExtraError
from bristle.core.tabular import library
from bristle.exports.mjcf import mjcf_attributes
from bristle.exports.targets import Product, Request

MOST = 1_000_000
"""Rows of a table: it is made whole, in the memory."""
USUAL, SEED = 1000, 0
MASS, OFFSET = "M", "offset"


def write(request: Request) -> Product:
    """Return the tables."""
    return Product(*draws_files(request.model, request.plant, request.drawn, request.draws or USUAL, request.name))


def draws_files(
    model: Model, plant: Model | None, drawn: Mapping[str, np.ndarray], count: int, name: str
) -> tuple[dict[str, str | bytes], tuple[str, ...]]:
    """Return tables of draws, and what is to be known of them, a sentence each."""
    if not drawn:
        raise InputError(
            "holds no draws: it was identified without intervals",
            path="draws",
            mend="Identify again with --draws 1000, and export the folder of its results",
        )
    if not 1 <= count <= MOST:
        raise InputError(
            "out of range",
            path="draws",
            value=count,
            allowed=f"1 to {MOST}",
            mend="Draw rows of the file again, as often as the simulator needs them",
        )
    stored = min(len(values) for values in drawn.values())
    notes = [f"{count} of the {stored} draws of the fit"]
    rows = np.arange(count)
    if count > stored:
        notes = [f"{count} draws, with replacement, of the {stored} of the fit: identify with --draws {count} for as many others"]
        rows = np.random.default_rng(SEED).integers(stored, size=count)
    of_fit = {key: np.asarray(values, dtype=float)[:stored] for key, values in drawn.items()}
    columns: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}
    for key, values in of_fit.items():
        of_key = {key: values} if values.ndim == 1 else {f"{key}[{k}]": column for k, column in enumerate(values.T)}
        owner = next((owner for owner in (model, plant) if owner is not None and key in owner.component.variables), None)
        columns |= of_key
        units |= dict.fromkeys(of_key, "" if owner is None else owner.component.variables[key].unit(owner.kind))
    titles = [f"{name} [{unit}]" if unit not in ("", "1") else name for name, unit in units.items()]
    lines = _lines(zip(*(values.tolist() for values in columns.values()), strict=True))
    files: dict[str, str | bytes] = {f"{name}_draws.csv": "".join([*_lines([titles]), *(lines[row] for row in rows)])}
    try:
        pyarrow, parquet = (library(module, "draws as Parquet") for module in ("pyarrow", "pyarrow.parquet"))
        fields = [pyarrow.field(name, pyarrow.float64(), metadata={"unit": unit}) for name, unit in units.items()]
        arrays = [pyarrow.array(values[rows], pyarrow.float64()) for values in columns.values()]
        sink = pyarrow.BufferOutputStream()
        parquet.write_table(pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields)), sink)
        files[f"{name}_draws.parquet"] = sink.getvalue().to_pybytes()
    except MissingExtraError:
        notes.append('Parquet needs pyarrow: pip install "bristle[io]"')
    scenes = _scenes(model, plant, of_fit, np.unique(rows))
    if scenes is not None:
        titles = ["draw", *next(iter(scenes.values()), {})]
        lines = dict(zip(scenes, _lines(scene.values() for scene in scenes.values()), strict=True))
        held = (f"{place},{lines[row]}" for place, row in enumerate(rows.tolist()) if row in lines)
        files[f"{name}_mjcf.csv"] = "".join([*_lines([titles]), *held])
        if refused := int(np.sum(~np.isin(rows, list(scenes)))):
            notes.append(f"{refused} of them break a condition of the model and are left out of {name}_mjcf.csv")
    return files, tuple(notes)


def _lines(rows: Iterable[Iterable[Any]]) -> list[str]:
    """Return rows of a table as lines."""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue().splitlines(keepends=True)


def _scenes(model: Model, plant: Model | None, of_fit: Mapping[str, np.ndarray], rows: np.ndarray) -> dict[int, dict[str, str]] | None:
    """Return what each draw of the fit is in a scene of MuJoCo, those that are models; None without such friction."""
    own = {key: values for key, values in of_fit.items() if key in model.component.variables}
    mass = float(plant.values.get(MASS, 1.0)) if plant is not None else 1.0
    scenes: dict[int, dict[str, str]] = {}
    for row in rows.tolist():
        try:
            drawn = model.with_values(**{key: values[row] for key, values in own.items()})
        except InputError:
            continue  # a condition of the model is broken
        try:
            scenes[row] = mjcf_attributes(drawn, float(of_fit[MASS][row]) if MASS in of_fit else mass)
        except InputError:
            return None
        if OFFSET in own:  # a motor with constant control
            scenes[row]["key.ctrl"] = f"0 {-float(own[OFFSET][row])!r}"
    return scenes
