"""Folder of a study: one complete file for each block, and the description of the study."""

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np

from bristle.apps.study.plan import Block
from bristle.core import InputError, guarded, library
from bristle.files import Growing, as_json, growing_folder, plain, verified

STUDY = "study.json"  # file with the description
RUNS = "runs"  # folder of the blocks
OF_STUDIES = ("bristle study", "study")  # command that needs pyarrow, and the extra with it
WRITTEN = (STUDY, "summary.json", "report.html")
SCHEMA = 1
LONGEST = 60


class Store:
    """Folder of a study, locked for writing by this process."""

    kind: ClassVar[str] = "study"

    def __init__(self, folder: Growing, study: Any, damaged: Sequence[str] = ()) -> None:
        self.grown = folder
        self.folder = folder.path
        self.study = study
        self.damaged = list(damaged)
        self.pyarrow, self.parquet = (
            library(name, *OF_STUDIES) for name in ("pyarrow", "pyarrow.parquet")
        )
        texts = [name for name, values in self._probe().items() if values.dtype.kind == "U"]
        self.schema = self.pyarrow.schema(
            self._field(name, column, texts) for name, column in study.columns.items()
        )

    def _field(self, name: str, column: Mapping[str, str], texts: Sequence[str]) -> object:
        """Return the field of a column in the schema, a text or a number."""
        pa = self.pyarrow
        if column["role"] == "run":
            kinds = {"run": pa.int64(), "seed": pa.int64(), "time_of_log": pa.timestamp("us")}
            return pa.field(name, kinds.get(name, pa.string()))
        kind = pa.float64()
        if name in texts:
            kind = pa.string()
        return pa.field(name, kind, metadata={"unit": column["unit"]})

    def begin(self, provenance: Mapping[str, str]) -> None:
        """Write the description into the folder; refuse a folder of another study."""
        if self.grown.is_whole(STUDY):
            refuse_another(
                study_in(self.folder)["described"], plain(self.study.described), self.folder
            )
        else:
            study = self.study
            described = {
                "schema": SCHEMA,
                "name": study.name,
                "kind": study.experiment.kind,
                "runs": study.count,
                "block": study.block,
                "draws": study.sampling.count,
                "sampling": study.sampling.method,
                "sobol_indices": study.sampling.indices,
                "seed": study.seed,
                "causes": {cause.name: list(cause.units) for cause in study.causes},
                "grid": {target.path: list(values) for target, values in study.grid},
                "metrics": [metric.column for metric in study.metrics],
                "columns": study.columns,
                "described": study.described,
                "provenance": provenance,
            }
            text = as_json(described)
            if any(
                name.startswith(f"{RUNS}/") for name in self.grown.names
            ) and not self.grown.has_held(STUDY, text):
                raise InputError(
                    "is missing, and the runs in this folder do not identify their study",
                    path=str(self.folder / STUDY),
                    mend="Restore this file, or name another folder",
                )
            self.grown.write(STUDY, text)
        self.grown.make(RUNS)

    def blocks_present(self) -> set[int]:
        """Return the first runs of the complete blocks; set damaged blocks, and other files under their names, aside."""
        blocks = _named_blocks(self.study)
        known = {*self.grown.names, *self.damaged}
        others = [
            name for name in blocks if name not in known and os.path.lexists(self.grown / name)
        ]
        self.grown.set_all_aside([*self.damaged, *others])
        self.damaged = []
        names = [name for name in self.grown.names if name.startswith(f"{RUNS}/")]
        unknown = sorted(set(names) - set(blocks))
        if unknown:
            raise InputError(
                "is not a file of this study",
                path=str(self.folder / unknown[0]),
                mend="Move it elsewhere: programs that read this folder would include it",
            )
        return {blocks[name].first for name in names}

    def write(self, block: Block, columns: Mapping[str, Any]) -> None:
        """Write a block. Its file appears under its name only when it is complete."""
        arrays = [self._array(columns[field.name], field) for field in self.schema]
        self.write_table(
            f"{RUNS}/{block.file}", self.pyarrow.Table.from_arrays(arrays, schema=self.schema)
        )

    def write_table(self, name: str, table: Any) -> None:
        """Write a table into a file of the folder."""
        sink = self.pyarrow.BufferOutputStream()
        self.parquet.write_table(table, sink)
        self.grown.write(name, sink.getvalue().to_pybytes())

    def _array(self, values: Any, field: Any) -> Any:
        if field.name == "reason":
            values = [value or None for value in values]
        elif isinstance(values, np.ndarray):
            values = values.tolist()
        return self.pyarrow.array(values, type=field.type)

    def _probe(self) -> Mapping[str, np.ndarray]:
        return self.study.values(self.study.blocks[0])


def _named_blocks(study: Any) -> dict[str, Block]:
    return {f"{RUNS}/{block.file}": block for block in study.blocks}


AnyStore = TypeVar("AnyStore", bound=Store)


@contextmanager
def opened(
    folder: str | Path, study: Any, provenance: Mapping[str, str], kind: type[AnyStore] = Store
) -> Iterator[AnyStore]:
    """Open the folder of a study for this process alone, new or that of the same study."""
    blocks = _named_blocks(study)

    def is_block(name: str) -> bool:
        return name.startswith(f"{RUNS}/")

    def is_used(name: str) -> bool:
        # Users may keep other files in the folder; those under the names of blocks are set aside.
        return name in WRITTEN or (name.partition("/")[0] == RUNS and name not in blocks)

    with growing_folder(folder, kind.kind, made_anew=is_block, used=is_used) as (grown, damaged):
        store = kind(grown, study, damaged)
        store.begin(provenance)
        yield store


def study_in(folder: Path) -> dict[str, Any]:
    """Return the content of ``study.json`` in a folder."""
    file = folder / STUDY
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(
            "is not the folder of a study: it has no study.json",
            path=str(folder),
            mend="Name a folder written by bristle study or bristle identify --each",
        ) from None
    except (ValueError, OSError) as error:
        raise InputError(f"cannot be read ({error})", path=str(file)) from None
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        raise InputError("has a format that this version of bristle cannot read", path=str(file))
    return data


def refuse_another(before: Any, now: Any, folder: Path) -> None:
    """Refuse a folder with a different description, and name a difference."""
    differences = list(_differences(before, now, ""))
    if differences:
        more = ""
        if len(differences) == 2:
            more = ", and there is 1 more difference"
        elif len(differences) > 2:
            more = f", and there are {len(differences) - 1} more differences"
        raise InputError(
            f"contains another study: {differences[0]}{more}",
            path=str(folder),
            mend="Name another folder",
        )


def _differences(before: Any, now: Any, path: str) -> Iterator[str]:
    """Yield the differences of two descriptions in words."""
    if isinstance(before, dict) and isinstance(now, dict):
        for key in {**before, **now}:
            below = key
            if path:
                below = f"{path}.{key}"
            yield from _differences(before.get(key), now.get(key), below)
    elif before != now:
        place = path.removeprefix("study.").removeprefix("files.")
        if path.startswith("files."):
            yield f"the file of {place.replace(': ', ', ', 1)}, has changed"
        else:
            yield f"{place} was {_brief(before)} and is now {_brief(now)}"


def _brief(value: object) -> str:
    """Return a value of a description as a short text."""
    if value is None:
        return "missing"
    text = json.dumps(value, ensure_ascii=False)
    if len(text) > LONGEST:
        return f"{text[: LONGEST - 1]}…"
    return text


OK = "ok"  # status of a run, or of a log of a fleet, that ended well


@dataclass(frozen=True)
class Runs:
    """Runs in the folder of a study."""

    described: Mapping[str, Any]
    columns: Mapping[str, np.ndarray]

    @property
    def count(self) -> int:
        """Count of the runs."""
        return len(self.columns["run"])


def runs_in(folder: str | Path) -> Runs:
    """Return the runs in the folder of a study."""
    place = Path(folder)
    described = study_in(place)
    pyarrow, parquet = (library(name, *OF_STUDIES) for name in ("pyarrow", "pyarrow.parquet"))
    files = []
    if (place / RUNS).is_dir():
        files = sorted(name for name in os.listdir(place / RUNS) if name.endswith(".parquet"))
    verified(place, [STUDY, *(f"{RUNS}/{name}" for name in files)])
    try:
        tables = [parquet.read_table(place / RUNS / name, use_threads=False) for name in files]
    except (pyarrow.ArrowException, OSError) as error:
        raise InputError(
            f"cannot be read ({error})",
            path=str(place / RUNS),
            mend="Repeat the command of the study: it replaces damaged files",
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
        encoded = column.combine_chunks().dictionary_encode()  # text of fixed width
        words = np.array([*encoded.dictionary.to_pylist(), ""])
        columns[name] = words[encoded.indices.fill_null(len(words) - 1).to_numpy()]
    return Runs(described, columns)


@guarded()
def read_study(folder: str | Path) -> Any:
    """Return the runs of a study as a data set of xarray, labelled, with units.

    Parameters
    ----------
    folder : path-like
        Folder written by ``bristle study --out``; it may be incomplete.

    Returns
    -------
    xarray.Dataset
        The dimension is ``run``; with a grid, the dimensions are ``draw`` and the quantities of the grid. Each variable
        has its SI unit as ``units``. ``run``, ``seed`` and ``status`` are coordinates. A missing run has the number -1, and
        NaN for its metrics.

    Raises
    ------
    InputError
        If the folder does not belong to a study, or bristle cannot read a file in it.
    MissingExtraError
        If pyarrow or xarray is not installed.

    Notes
    -----
    The files are plain Parquet: ``polars.read_parquet("DIR/runs/*.parquet")``, ``duckdb.sql("from 'DIR/runs/*'")`` and
    ``pandas.read_parquet("DIR/runs")`` also read them.
    """
    runs = runs_in(folder)
    xarray = library("xarray", "read_study()")
    described = runs.described
    grid: dict[str, list[Any]] = described["grid"]
    attributes = {
        key: described[key] for key in ("name", "kind", "seed", "sampling") if key in described
    }
    data = xarray.Dataset(attrs=attributes)
    shape = (described["draws"], *(len(values) for values in grid.values()))
    dimensions = ("run",)
    if grid:
        dimensions = ("draw", *grid)
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
    # Columns that accompany the numbers of a run.
    return data.set_coords(
        [
            name
            for name in ("seed", "folder", "log", "time_of_log", "status", "reason")
            if name in data
        ]
    )
