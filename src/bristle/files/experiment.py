"""Experiment files: a loop to simulate, its variants, and the models to identify for them.

``[identify.NAME]`` describes the fit of a model, and a table with ``identified = "NAME"`` uses that model. The model is in
a folder next to the experiment, with a digest of its inputs: bristle does not use a model with another digest.
"""

import hashlib
import json
import re
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from bristle.core import (
    SIZE_LIMIT,
    Experiment,
    InputError,
    Origin,
    Readable,
    Variant,
    content_of,
    did_you_mean,
    located,
    size_of,
)
from bristle.files.components import check_keys, check_schema, name_of, refuse_open, table_at
from bristle.files.owned import NOTE, Folder, note_in, strangers_in
from bristle.files.sources import Sources
from bristle.files.toml import TOML_LIMIT, read_toml
from bristle.files.variant import SECTIONS, Tables, merged, variant_from
from bristle.logs.tables import content_of_log

DEPENDS_ON, MODEL = "depends_on.json", "model.toml"
OPTIONS = ("model", "cutoff", "decimation", "blocks", "offset", "mass", "free", "draws", "method")
"""Options of the table for `bristle.identify`."""
IDENTIFIED = "identified"
MEND = "Run the experiment once with `bristle run`, or call bristle.prepare(file) in Python"


@dataclass(frozen=True)
class Planned:
    """A model to identify for an experiment."""

    name: str
    folder: Path
    digest: str
    logs: tuple[Path, ...]
    axis: Path | None
    excited: Variant | None
    options: Mapping[str, Any]

    @property
    def path(self) -> str:
        """Return its table in the file."""
        return f"identify.{self.name}"

    @property
    def is_current(self) -> bool:
        """Whether it was identified from its current inputs."""
        try:
            with Folder(self.folder) as folder:
                note = note_in(folder)
                names = folder.names()
                changed = [] if note is None else strangers_in(folder, note)[1]
            text = (self.folder / DEPENDS_ON).read_text("utf-8") if DEPENDS_ON in names else "{}"
        except (OSError, UnicodeDecodeError):
            return False
        if NOTE in changed:
            raise InputError(
                "is damaged or was changed",
                path=str(self.folder / NOTE),
                mend=f"Remove {self.folder} to identify the model again",
            )
        if MODEL in changed:
            raise InputError(
                "was changed after its identification",
                path=str(self.folder / MODEL),
                mend=f'To use the changed model, rename this file and name it with file = "...". Otherwise, remove {self.folder}',
            )
        return MODEL in names and DEPENDS_ON not in changed and f'"{self.digest}"' in text

    @property
    def note(self) -> tuple[str, str]:
        """Name and text of the file that lists the inputs of the model."""
        return DEPENDS_ON, json.dumps(
            {"identify": self.name, "digest": self.digest}, indent=2
        ) + "\n"


def planned_in(data: Mapping[str, Any], source: Path, sources: Sources) -> dict[str, Planned]:
    """Return the models to identify for an experiment, by name."""
    tables = table_at(data.get("identify", {}), "identify")
    return {name: _planned(name, table, data, source, sources) for name, table in tables.items()}


def with_models(data: Mapping[str, Any], source: Path, sources: Sources) -> dict[str, Any]:
    """Return the content of an experiment file, with the names of its models replaced by their files."""
    planned = planned_in(data, source, sources)
    for name in dict.fromkeys(name for _, name in _uses(data)):
        if name in planned and not planned[name].is_current:
            is_stale = planned[name].folder.exists()
            reason = (
                "was identified from other inputs than those that this file now states"
                if is_stale
                else "is not identified yet"
            )
            raise InputError(reason, path=f"identify.{name}", mend=MEND)
    learning = {model.excited.name for model in planned.values() if model.excited is not None}
    judged = {key: value for key, value in data.items() if key != "identify"}
    if "compare" in judged:
        judged["compare"] = {
            name: table
            for name, table in table_at(judged["compare"], "compare").items()
            if name not in learning
        }
    return _replaced(judged, planned, "")


def _planned(
    name: str, table: Any, data: Mapping[str, Any], source: Path, sources: Sources
) -> Planned:
    from bristle import __version__

    path = f"identify.{name}"
    check_keys(table_at(table, path), ("log", "excite", "axis", *OPTIONS), path)
    if not name.isidentifier():
        raise InputError(
            "cannot be the name of a folder", path=path, allowed="letters, digits and _"
        )
    if ("log" in table) == ("excite" in table):
        raise InputError(
            "needs a log or a simulated loop for the fit",
            path=path,
            mend='Write log = "log.csv", or excite = "NAME" to simulate the loop [compare.NAME]',
        )
    raw, origins = table.get("log", []), []
    logs = tuple(sources.folder / str(file) for file in (raw if isinstance(raw, list) else [raw]))
    axis = sources.folder / str(table["axis"]) if "axis" in table else None
    for file in logs:
        with located(f"{path}.log"):
            origins.append(content_of_log(file, limit=sources.size_limit).origin)
    if axis is not None:
        with located(f"{path}.axis"):
            origins.append(content_of(axis, limit=TOML_LIMIT).origin)
    tables, excited = {}, None
    if "excite" in table:
        tables, excited, read = _excited(str(table["excite"]), data, f"{path}.excite", sources)
        origins += read
    facts = {
        "identify": table,
        "rig": tables,
        "files": sorted(origin.checksum for origin in origins),
        "bristle": __version__,
    }
    digest = hashlib.sha256(json.dumps(facts, sort_keys=True, default=str).encode()).hexdigest()
    folder = source.parent.absolute() / f"{source.stem}_identified" / name
    return Planned(
        name,
        folder,
        digest,
        logs,
        axis,
        excited,
        {key: table[key] for key in OPTIONS if key in table},
    )


def _excited(
    name: str, data: Mapping[str, Any], path: str, sources: Sources
) -> tuple[dict[str, Any], Variant, list[Origin]]:
    """Return the tables of the excited loop, the loop, and the files that the tables name."""
    variants = table_at(data.get("compare", {}), "compare")
    if name not in variants:
        mend = did_you_mean(name, variants) or f"Describe that loop under [compare.{name}]"
        raise InputError(
            "is not a variant in this file",
            path=path,
            value=name,
            allowed=", ".join(variants),
            mend=mend,
        )
    base = {key: data[key] for key in ("kind", *SECTIONS) if key in data}
    override = table_at(variants[name], f"compare.{name}")
    tables = merged(base, override)
    for place, model in _uses(tables):
        raise InputError(
            "must not be used in this loop, because the loop runs before the identification",
            path=f"compare.{name}.{place}",
            value=model,
            mend=f'Write friction = "none" under [compare.{name}.controller.feedforward]',
        )
    own = Sources(sources.folder, sources.allow_code, sources.size_limit)
    variant = variant_from(name, Tables(tables, override, f"compare.{name}"), own)
    return tables, variant, [origin for origins in own.origins.values() for origin in origins]


def _uses(level: Any, place: str = "") -> Iterator[tuple[str, str]]:
    """Yield the place and the name of each identified model that a table uses."""
    if isinstance(level, Mapping):
        for key, value in level.items():
            if key == IDENTIFIED and isinstance(value, str):
                yield place, value
            elif not (place == "" and key == "identify"):
                yield from _uses(value, f"{place}.{key}" if place else str(key))


def _replaced(level: Any, planned: Mapping[str, Planned], place: str) -> Any:
    if not isinstance(level, Mapping):
        return level
    inner = {
        key: _replaced(value, planned, f"{place}.{key}" if place else str(key))
        for key, value in level.items()
    }
    if not isinstance(level.get(IDENTIFIED), str):  # a variant may be called so
        return inner
    name = inner.pop(IDENTIFIED)
    if name not in planned:
        raise InputError(
            "is not a model under [identify] of this file",
            path=f"{place}.{IDENTIFIED}",
            value=name,
            allowed=", ".join(planned),
            mend=did_you_mean(name, planned),
        )
    return {"file": str(planned[name].folder / MODEL), **inner}


KEYS = ("schema", "name", "kind", *SECTIONS, "compare")
# Tables of an experiment on a contact, and required tables of a loop: both kinds of files may be in one folder.
OF_CONTACTS = {
    "contact",
    "operator",
    "path",
    "torque",
    "measurement",
    "transition_branches",
    "bench",
}


def read_experiment(
    path: Readable, *, allow_code: bool = False, size_limit: int | str = SIZE_LIMIT
) -> Experiment:
    """Return the experiment described by a file.

    The file without changes is the variant ``base``. Each table ``[compare.<name>]`` adds a variant with changed
    sections. bristle merges tables key by key, but a table with its own ``model``, ``file`` or ``identified`` replaces
    the original table. An empty ``[compare.<name>]`` renames the variant ``base``. ``identified`` names a model of
    ``[identify.<name>]``, which `bristle.prepare` fits.

    Parameters
    ----------
    path : path-like
        An experiment file (TOML). Paths in it are relative to its folder.
    allow_code : bool
        Whether user models in files that it names may run without earlier permission.
    size_limit : int or str
        Limit for each log that it names [byte], or text such as ``"2 GB"``.

    Raises
    ------
    InputError
        With the file, the key, the value and the allowed values.
    """
    data, source, content = read_toml(path, path="experiment", what="an experiment file")
    sources = Sources(source.parent, allow_code, size_of(size_limit))
    with located(source):
        experiment = experiment_from(with_models(data, source, sources), source, sources)
    return replace(
        experiment,
        origins=({"experiment": (content.origin,)} if content is not None else {})
        | sources.origins,
    )


def experiment_from(data: dict[str, Any], source: Path, sources: Sources) -> Experiment:
    """Return the experiment described by the content of a file."""
    if OF_CONTACTS & data.keys() and not {"controller", "reference", "run"} & data.keys():
        named = re.fullmatch(r"fig_0*(\d+)\.toml", source.name)
        command = f"bristle paper --from {shlex.quote(str(source.parent))} --figure {named[1] if named else 'N'}"
        raise InputError(
            "is an experiment on a contact, not on a loop", mend=f"Run it with {command}"
        )
    refuse_open(data)
    check_keys(data, KEYS, "")
    check_schema(data)
    name = name_of(data, source)
    base = {key: data[key] for key in ("kind", *SECTIONS) if key in data}
    as_it_stands = variant_from("base", Tables(base), sources)
    overrides = table_at(data.get("compare", {}), "compare")
    variants = (
        [as_it_stands]
        if all(override and label != "base" for label, override in overrides.items())
        else []
    )
    for label, override in overrides.items():
        path = f"compare.{label}"
        check_keys(table_at(override, path), SECTIONS, path)
        variants.append(
            variant_from(label, Tables(merged(base, override), override, path), sources)
        )
    return Experiment(
        name=name, kind=as_it_stands.plant.kind, variants=tuple(variants), source=source
    )
