"""The runs of a study as columns, and as a labelled data set."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.errors import InputError
from bristle.core.tabular import library
from bristle.files.growing import verified
from bristle.study.store import OF_STUDIES, RUNS, STUDY, study_in

OK = "ok"  # status of a run, or of a log of a fleet, that ended well


@dataclass(frozen=True)
class Runs:
    """What a folder of a study holds."""

    described: Mapping[str, Any]
    columns: Mapping[str, np.ndarray]

    @property
    def count(self) -> int:
        """How many runs are there."""
        return len(self.columns["run"])


def runs_in(folder: str | Path) -> Runs:
    """Return the runs of a study that are there."""
    place = Path(folder)
    described = study_in(place)
    pyarrow, parquet = (library(name, *OF_STUDIES) for name in ("pyarrow", "pyarrow.parquet"))
    files = sorted(name for name in os.listdir(place / RUNS) if name.endswith(".parquet")) if (place / RUNS).is_dir() else []
    verified(place, [STUDY, *(f"{RUNS}/{name}" for name in files)])
    try:
        tables = [parquet.read_table(place / RUNS / name, use_threads=False) for name in files]
    except (pyarrow.ArrowException, OSError) as error:
        raise InputError(
            f"cannot be read: {error}", path=str(place / RUNS), mend="Give the command of the study again: it replaces what is damaged"
        ) from None
    if not tables:
        return Runs(described, {name: np.empty(0) for name in described["columns"]})
    table = pyarrow.concat_tables(tables)
    columns = {}
    for name in table.column_names:
        column = table[name]
        if str(column.type) != "string":
            columns[name] = column.to_numpy()
            continue
        encoded = column.combine_chunks().dictionary_encode()  # text of one width
        words = np.array([*encoded.dictionary.to_pylist(), ""])
        columns[name] = words[encoded.indices.fill_null(len(words) - 1).to_numpy()]
    return Runs(described, columns)


def read_study(folder: str | Path) -> Any:
    """Return the runs of a study as a data set of xarray, labelled, with units.

    Parameters
    ----------
    folder : path-like
        What ``bristle study --out`` wrote. A study that is not whole can be read, too.

    Returns
    -------
    xarray.Dataset
        Over ``run``; over ``draw`` and the quantities of the grid where the study has one. Each number has its
        ``units`` in SI; ``run``, ``seed`` and ``status`` stand beside the numbers. A run that is not there has the
        number -1, and NaN for its numbers.

    Raises
    ------
    InputError
        If the folder is none of a study, or a file of it cannot be read.
    MissingExtraError
        If pyarrow or xarray is not installed.

    Notes
    -----
    The files are plain Parquet: ``polars.read_parquet("DIR/runs/*.parquet")``, ``duckdb.sql("from 'DIR/runs/*'")`` and
    ``pandas.read_parquet("DIR/runs")`` read them, too.
    """
    runs = runs_in(folder)
    xarray = library("xarray", "read_study()")
    described = runs.described
    grid: dict[str, list[Any]] = described["grid"]
    attributes = {key: described[key] for key in ("name", "kind", "seed", "sampling") if key in described}
    data = xarray.Dataset(attrs=attributes)
    shape = (described["draws"], *(len(values) for values in grid.values()))
    dimensions = ("draw", *grid) if grid else ("run",)
    numbers = runs.columns["run"].astype(int)
    for name, column in runs.columns.items():
        if name in grid or (name == "run" and not grid):
            continue
        about = described["columns"][name]
        label = {key: about[key] for key in ("unit", "description", "role") if about.get(key)}
        if "unit" in label:
            label["units"] = label.pop("unit")
        if grid:
            missing = {"f": np.nan, "U": ""}.get(column.dtype.kind, -1)
            spread = np.full(int(np.prod(shape)), missing, dtype=column.dtype)
            spread[numbers] = column
            column = spread.reshape(shape)
        data[name] = (dimensions, column, label)
    if grid:
        data = data.assign_coords(draw=np.arange(shape[0]))
        for name, values in grid.items():
            unit = described["columns"][name]["unit"]
            data = data.assign_coords({name: (name, values, {"units": unit} if unit else {})})
    else:
        data = data.assign_coords(run=numbers)
    # Columns that stand beside the numbers of a run.
    return data.set_coords([name for name in ("seed", "folder", "log", "time_of_log", "status", "reason") if name in data])
