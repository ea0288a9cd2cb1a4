"""The files that an experiment names: each file is read once, and its content is passed to other processes."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from bristle.core import SIZE_LIMIT, Axis, Content, InputError, Origin, content_of, located
from bristle.core.contracts import Model, make_model
from bristle.core.variable import Kind
from bristle.files.axis import read_axis
from bristle.files.components import check_keys, model_from, parameters_in, table_at
from bristle.files.experiment_text import LoopRecord, kind_of_loop, read_loop
from bristle.files.model import FITTED_TO, ModelFile, friction_from, read_model
from bristle.files.motion import axis_of_motion
from bristle.files.operator import OperatorFile, contact_over, holds_operator, read_operator
from bristle.files.permission import code_named
from bristle.files.toml import TOML_LIMIT
from bristle.files.user_model import Own, component_in, origins_of_code
from bristle.logs import Log, read_log
from bristle.logs.tables import content_of_log
from bristle.models.hysteresis import OPERATORS
from bristle.models.plants import PLANTS
from bristle.models.references import recorded


@dataclass
class Sources:
    """Axes, identified models, logs and code that the tables of an experiment refer to by file."""

    folder: Path
    allow_code: bool = False
    size_limit: int = SIZE_LIMIT
    _read: dict[tuple[Any, ...], Any] = field(default_factory=dict)
    _origins: dict[str, list[Origin]] = field(default_factory=dict)

    @property
    def origins(self) -> dict[str, tuple[Origin, ...]]:
        """Files that were read, by role."""
        return {role: tuple(dict.fromkeys(origins)) for role, origins in self._origins.items()}

    def axis(self, file: Any, path: str) -> Axis:
        """Return the axis in a file."""
        return self._once("axis", file, path, read_axis)

    def model(self, file: Any, path: str) -> ModelFile:
        """Return the identified model in a file; an operator becomes a friction model on the position."""

        def read(content: Content) -> ModelFile:
            if holds_operator(content):
                described = read_operator(content)
                table, kind = contact_over(described), described.operator.kind
                friction = friction_from(table, kind=kind, folder=self.folder, path="operator")
                return ModelFile(None, friction, {"provenance": described.provenance})
            file = read_model(content, allow_code=self.allow_code)
            self._origins.setdefault("code", []).extend(origins_of_code([file.friction.component]))
            return file

        return self._once("model", file, path, read)

    def operator(self, file: Any, path: str) -> OperatorFile:
        """Return the hysteresis operator in a file."""
        return self._once("operator", file, path, read_operator)

    def log(self, file: Any, axis: Axis | None, path: str) -> Log:
        """Return the log or the motion in a file."""

        def read(content: Content) -> Log:
            return read_log(
                content, axis_of_motion(content, axis) or axis, size_limit=self.size_limit
            )

        described_by = next((key[1] for key, value in self._read.items() if value is axis), None)
        return self._once("log", file, path, read, content_of_log, described_by)

    def friction(self, table: Any, kind: Kind, path: str) -> tuple[Model | None, Model]:
        """Return the plant (if a model file has one) and the friction model of a table."""
        entries = table_at(table, path)
        described = self.identified(table, path)
        if described is None:
            return None, friction_from(
                entries,
                kind=kind,
                folder=self.folder,
                path=path,
                read_operator=self.operator,
                read_code=self.code,
            )
        if described.friction.kind != kind:
            raise InputError(
                f"is the model of a {described.friction.kind} axis, but this axis is {kind}",
                path=f"{path}.file",
                value=entries["file"],
                mend="Name the model of an axis of the same kind",
            )
        component = described.friction.component
        values = described.friction.values | parameters_in(
            entries, component, path, beside=("file",)
        )
        return described.plant, make_model(component, values, kind=kind, validate=True, path=path)

    def identified(self, table: Any, path: str) -> ModelFile | None:
        """Return the model file that a table names; None without one."""
        file = table_at(table, path).get("file")
        is_file = isinstance(file, str) and file.endswith(".toml")
        return self.model(file, f"{path}.file") if is_file else None

    def listed(
        self, family: Literal["plant", "hysteresis"], table: Any, kind: Kind, path: str
    ) -> Model:
        """Return the plant or the operator that a table names, with its parameters."""
        return model_from(table, PLANTS if family == "plant" else OPERATORS, kind=kind, path=path)

    def own(self, table: Any, family: type[Own], path: str) -> Own | None:
        """Return the user component in the `file` of a table; None if the table has no `file`."""
        entries = table_at(table, path)
        if "file" in entries:
            return component_in(entries, family, path=path, read_code=self.code)
        return None

    def code(self, file: str, path: str) -> Content:
        """Return the code in a file that may run."""
        key = ("code", self._file(file, path))
        if key not in self._read:
            self._read[key] = code_named(file, path, folder=self.folder, allow_code=self.allow_code)
            self._origins.setdefault("code", []).append(self._read[key].origin)
        return self._read[key]

    def fitted_to(self, table: Any, path: str) -> str:
        """Return the digest of the friction that the model of a table was identified on, or "" if unknown."""
        file = table_at(table, path).get("file")
        if not isinstance(file, str) or not file.endswith(".toml"):
            return ""
        return str(self.model(file, f"{path}.file").info["provenance"].get(FITTED_TO, ""))

    def recorded(self, table: dict[str, Any], axis: Axis | None, path: str) -> Model:
        """Return the reference in a log, or a planned motion."""
        check_keys(table, ("model", "file", "axis"), path)
        file, place = table["file"], f"{path}.file"
        axis = self.axis(table["axis"], f"{path}.axis") if "axis" in table else axis
        source = self._file(file, place)
        # The loop of a log from an identification, or else a log.
        is_loop = (
            source.suffix == ".csv"
            and source.is_file()
            and kind_of_loop(content_of_log(source, limit=self.size_limit)) is not None
        )
        if is_loop:
            record = self.loop_record(file, place)
            values = {"position": record.reference, "sample_time": record.sample_time}
            return make_model(recorded, values, kind=record.kind, validate=True, path=path)
        log = self.log(file, axis, place)
        reference = log.position if log.effort is None else log.reference
        if reference is None:
            raise InputError(
                "has no reference",
                path=place,
                value=file,
                mend="Name the column of the reference under [columns] of the axis file: reference = ...",
            )
        if len(log.segments) > 1:
            raise InputError(
                f"has gaps, which split it into {len(log.segments)} parts",
                path=place,
                value=file,
                mend="Record the reference again, without gaps",
            )
        values = {"position": reference.values, "sample_time": log.sample_time}
        return make_model(recorded, values, kind=log.kind, validate=True, path=path)

    def loop_record(self, file: Any, path: str) -> LoopRecord:
        """Return the loop of a log: its motion and its disturbances."""
        return self._once("loop", file, path, read_loop, content_of_log)

    def _file(self, file: Any, path: str) -> Path:
        if not isinstance(file, str) or not file:
            raise InputError("must be the name of a file", path=path, value=file)
        return self.folder / file

    def _once(
        self,
        role: str,
        file: Any,
        path: str,
        read: Callable[..., Any],
        opened: Any = content_of,
        axis: Any = None,
    ) -> Any:
        key = (role, self._file(file, path), axis)
        if key not in self._read:
            with located(path):
                content = opened(
                    key[1], limit=self.size_limit if opened is content_of_log else TOML_LIMIT
                )
                self._read[key] = read(content)
            self._origins.setdefault("log" if role == "loop" else role, []).append(content.origin)
        return self._read[key]
