"""The folder of a study: one file for each block, whole or not there, and what the study says."""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from bristle.core.errors import InputError
from bristle.core.tabular import library
from bristle.files.owned import lock, sync_folder
from bristle.files.summary import as_json, plain
from bristle.study.plan import Block

__all__ = ["OF_STUDIES", "RUNS", "SCHEMA", "STUDY", "Store", "opened", "refuse_another", "study_in"]

STUDY, RUNS = "study.json", "runs"
OF_STUDIES = ("bristle study", "study")  # what needs pyarrow, and the extra that brings it
LOCK, PARTIAL = ".lock", ".partial"
SCHEMA = 1
_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO}
LONGEST = 60


class Store:
    """The folder of a study while this process writes into it.

    Parameters
    ----------
    folder : Path
        The folder.
    study : Study
        The study.
    """

    def __init__(self, folder: Path, study: Any) -> None:
        self.folder, self.study = folder, study
        self.pyarrow, self.parquet = (library(name, *OF_STUDIES) for name in ("pyarrow", "pyarrow.parquet"))
        self.schema = self._schema()

    def begin(self, provenance: Mapping[str, str]) -> None:
        """Say in the folder what it holds, once it is this process's own; refuse what holds something else."""
        if (self.folder / STUDY).is_file():
            refuse_another(study_in(self.folder)["described"], plain(self.study.described), self.folder)
        else:
            self.write_file(STUDY, as_json(_described(self, provenance)).encode())

    def blocks_present(self) -> set[int]:
        """Return the first runs of the blocks that are there, whole; one that cannot be read is removed."""
        blocks = {block.file: block for block in self.study.blocks}
        present = set()
        for name in sorted(os.listdir(self.folder / RUNS)):
            if name not in blocks:
                raise InputError("is none of the files of this study", path=str(self.folder / RUNS / name),
                                 mend="Move it elsewhere: whoever reads the folder would read it, too")  # fmt: skip
            if self._is_whole(self.folder / RUNS / name, blocks[name]):
                present.add(blocks[name].first)
            else:
                (self.folder / RUNS / name).unlink()
        return present

    def _is_whole(self, file: Path, block: Block) -> bool:
        """Return whether a file holds the runs of its block: a disk that failed may have left less."""
        try:
            with self.parquet.ParquetFile(file) as opened_file:
                metadata = opened_file.metadata
                return metadata.num_rows == block.count and opened_file.schema_arrow.names == self.schema.names
        except (self.pyarrow.ArrowException, OSError):
            return False

    def write(self, block: Block, columns: Mapping[str, Any]) -> None:
        """Write a block; it appears whole under its name.

        Raises
        ------
        InputError
            If the disk does not take it: what is there stays.
        """
        arrays = [self._array(columns[field.name], field) for field in self.schema]
        table = self.pyarrow.Table.from_arrays(arrays, schema=self.schema)
        sink = self.pyarrow.BufferOutputStream()
        self.parquet.write_table(table, sink)
        self.write_file(f"{RUNS}/{block.file}", sink.getvalue().to_pybytes())

    def write_file(self, name: str, content: bytes) -> None:
        """Write a file of the folder; it appears whole under its name, in the place of an earlier one."""
        target, partial = self.folder / name, self.folder / PARTIAL / name.replace("/", "-")
        try:
            target.parent.mkdir(exist_ok=True)
            with open(partial, "wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            os.replace(partial, target)
            sync_folder(target.parent)
        except OSError as error:
            with suppress(OSError):
                partial.unlink()
            if error.errno not in _FULL:
                raise
            raise InputError(
                f"cannot be written: {os.strerror(error.errno or 0).lower()}", path=str(target),
                mend="What is there stays. Make room and give the same command again",
            ) from error  # fmt: skip

    def _array(self, values: Any, field: Any) -> Any:
        if field.name == "reason":
            values = [value or None for value in values]
        return self.pyarrow.array(values.tolist() if isinstance(values, np.ndarray) else values, type=field.type)

    def _schema(self) -> Any:
        pa = self.pyarrow
        texts = {"status": pa.string(), "reason": pa.string()}
        fields = [pa.field("run", pa.int64()), pa.field("seed", pa.int64())]
        fields += [pa.field(name, kind) for name, kind in texts.items()]
        probe = self.study.values(self.study.blocks[0])
        for path, unit in self.study.units.items():
            kind = pa.string() if probe[path].dtype.kind == "U" else pa.float64()
            names = [path] if probe[path].ndim == 1 else [f"{path}[{k}]" for k in range(probe[path].shape[1])]
            fields += [pa.field(name, kind, metadata={"unit": unit}) for name in names]
        fields += [
            pa.field(metric.column, pa.float64(), metadata={"unit": metric.unit}) for metric in self.study.metrics
        ]
        return pa.schema(fields)

    @property
    def columns(self) -> dict[str, dict[str, str]]:
        """What each column of a block is: its role and its unit in SI."""
        metrics = {metric.column: metric for metric in self.study.metrics}
        grid = {target.path for target, _ in self.study.grid}
        columns = {}
        for field in self.schema:
            unit = (field.metadata or {}).get(b"unit", b"").decode()
            if field.name in metrics:
                columns[field.name] = {"role": "metric", "unit": unit, "description": metrics[field.name].described}
            elif field.metadata is not None:
                columns[field.name] = {"role": "grid" if field.name in grid else "drawn", "unit": unit}
            else:
                columns[field.name] = {"role": "run", "unit": ""}
        return columns


AnyStore = TypeVar("AnyStore", bound=Store)


@contextmanager
def opened(folder: Path, study: Any, provenance: Mapping[str, str], kind: type[AnyStore] = Store) -> Iterator[AnyStore]:
    """Give the folder of a study to write into, new or that of the same study, to this process alone.

    Raises
    ------
    InputError
        If another process writes there, or the folder holds something else: another study is told by what differs.
    """
    store = kind(folder, study)
    _refuse_foreign(folder)
    folder.mkdir(exist_ok=True)
    descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        _lock(descriptor, folder)
        (folder / RUNS).mkdir(exist_ok=True)
        (folder / PARTIAL).mkdir(exist_ok=True)
        for name in os.listdir(folder / PARTIAL):  # of a process that was killed: the lock says that none writes
            (folder / PARTIAL / name).unlink()
        store.begin(provenance)
        yield store
        (folder / PARTIAL).rmdir()
    finally:
        os.close(descriptor)


def study_in(folder: Path) -> dict[str, Any]:
    """Return what ``study.json`` of a folder says.

    Raises
    ------
    InputError
        If there is none.
    """
    file = folder / STUDY
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError("is no folder of a study: it has no study.json", path=str(folder),
                         mend="Name what bristle study or bristle identify --each wrote") from None  # fmt: skip
    except (ValueError, OSError) as error:
        raise InputError(f"cannot be read: {error}", path=str(file)) from None
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        raise InputError("is not one that this bristle reads", path=str(file))
    return data


def _described(store: Store, provenance: Mapping[str, str]) -> dict[str, Any]:
    study = store.study
    return {
        "schema": SCHEMA, "name": study.name, "kind": study.experiment.kind, "runs": study.count, "block": study.block,
        "draws": study.sampling.count, "sampling": study.sampling.method, "sobol_indices": study.sampling.indices,
        "seed": study.seed, "causes": {cause.name: list(cause.units) for cause in study.causes},
        "grid": {target.path: list(values) for target, values in study.grid},
        "metrics": [metric.column for metric in study.metrics], "columns": store.columns,
        "described": study.described, "provenance": provenance,
    }  # fmt: skip


def _refuse_foreign(folder: Path) -> None:
    if not folder.parent.is_dir():
        raise InputError("the folder that is to hold it does not exist", path=str(folder),
                         mend=f"Make {folder.parent} first")  # fmt: skip
    if not os.path.lexists(folder):
        return
    if not folder.is_dir():
        raise InputError("is a file, not a folder", path=str(folder), mend="Name another folder")
    if (folder / STUDY).is_file():
        return
    # A study that was killed before it said what it is has left no more than these, and its first file half written.
    foreign = sorted({*os.listdir(folder)} - {LOCK, RUNS, PARTIAL}) + [
        f"{inner}/{name}" for inner in (RUNS, PARTIAL) if (folder / inner).is_dir()
        for name in sorted(os.listdir(folder / inner)) if (inner, name) != (PARTIAL, STUDY)
    ]  # fmt: skip
    if foreign:
        raise InputError(f"holds something else than a study: {', '.join(foreign[:5])}", path=str(folder),
                         mend="Name another folder")  # fmt: skip


def _lock(descriptor: int, folder: Path) -> None:
    """Take the lock of a folder, which ends with the process that has it: one that was left behind is none."""
    try:
        lock(descriptor)
    except BlockingIOError:
        holder = os.pread(descriptor, LONGEST, 0).decode(errors="replace") if hasattr(os, "pread") else ""
        raise InputError(f"another process{f' ({holder})' if holder else ''} writes there", path=str(folder),
                         mend="Wait for it to end, or name another folder") from None  # fmt: skip
    if hasattr(os, "pwrite"):
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, f"process {os.getpid()}".encode(), 0)


def refuse_another(before: Any, now: Any, folder: Path) -> None:
    """Refuse a folder that was described otherwise, told by what differs."""
    differences = list(_differences(before, now, ""))
    if differences:
        more = f", and {len(differences) - 1} more" if len(differences) > 1 else ""
        raise InputError(f"holds another study: {differences[0]}{more}", path=str(folder),
                         mend="Name another folder for this one")  # fmt: skip


def _differences(before: Any, now: Any, path: str) -> Iterator[str]:
    """Yield in words where two descriptions differ."""
    if isinstance(before, dict) and isinstance(now, dict):
        for key in {**before, **now}:
            yield from _differences(before.get(key), now.get(key), f"{path}.{key}" if path else key)
    elif before != now:
        place = path.removeprefix("study.").removeprefix("files.")
        if path.startswith("files."):
            yield f"the file of {place} has changed"
        else:
            yield f"{place} was {_quoted(before)} and is now {_quoted(now)}"


def _quoted(value: Any) -> str:
    text = "not there" if value is None else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"
