"""The folder of a fleet: that of a study, with the list of its logs, which may grow."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, ClassVar

from bristle.files.summary import as_json, plain
from bristle.fleet.columns import described_columns, schema_of
from bristle.fleet.plan import Fleet, LogFile
from bristle.study.store import RUNS, SCHEMA, STUDY, Store, refuse_another, study_in

__all__ = ["FleetStore"]


class FleetStore(Store):
    """The folder of a fleet while this process writes into it; `study` is the fleet with all logs that are there."""

    study: Fleet
    kind: ClassVar[str] = "fleet"

    def begin(self, provenance: Mapping[str, str]) -> None:
        """List the logs of this command behind those that the folder has, each once; refuse another fleet."""
        if self.grown.is_whole(STUDY):
            past = study_in(self.folder)
            refuse_another(past["described"], plain(self.study.described), self.folder)
            self.study = self.study.following(past["logs"])
            provenance = past["provenance"]
        self._say(self._content(provenance))
        self.grown.make(RUNS)

    def blocks_present(self) -> set[int]:
        """Return the logs that need nothing: those with a row, and those that this command does not name."""
        unnamed = {number for number, log in enumerate(self.study.logs) if not log.place}
        return super().blocks_present() | unnamed

    def _say(self, content: Mapping[str, Any]) -> None:
        text, past = as_json(content), self.grown.read(STUDY)
        if past is None or json.loads(past) != json.loads(text):
            self.grown.write(STUDY, text)

    def _content(self, provenance: Mapping[str, str]) -> dict[str, Any]:
        fleet = self.study
        return {
            "schema": SCHEMA,
            "name": fleet.name,
            "kind": fleet.kind,
            "runs": fleet.count,
            "block": 1,
            "draws": fleet.count,
            "grid": {},
            "model": fleet.model.name,
            "metrics": [quantity.column for quantity in fleet.parameters.values()],
            "columns": described_columns(fleet),
            "logs": [_listed(log) for log in fleet.logs],
            "described": fleet.described,
            "provenance": provenance,
        }

    def _array(self, values: Any, field: Any) -> Any:
        if field.name == "time_of_log":
            return self.pyarrow.array(values, type=field.type)
        return super()._array(values, field)

    def _schema(self) -> Any:
        return schema_of(self.study, self.pyarrow)


def _listed(log: LogFile) -> dict[str, Any]:
    return {"folder": log.folder, "log": log.name, "sha256": log.checksum, "time": log.time}
