"""Experiment files: a loop to be simulated, and variants of it side by side."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from bristle.core.content import SIZE_LIMIT, Readable, size_of
from bristle.core.errors import InputError, located
from bristle.core.experiment import Experiment
from bristle.files.components import check_keys, check_schema, refuse_open, table_at
from bristle.files.pipeline import with_models
from bristle.files.sources import Sources
from bristle.files.toml import read_toml
from bristle.files.variant import SECTIONS, Tables, merged, variant_from

KEYS = ("schema", "name", "kind", *SECTIONS, "compare")
# What an experiment on a contact has, and what a loop cannot do without: they are written in the same folder.
OF_CONTACTS = {"contact", "operator", "path", "torque", "measurement", "transition_branches", "bench"}
OF_LOOPS = {"controller", "reference", "run"}


def read_experiment(path: Readable, *, allow_code: bool = False, size_limit: int | str = SIZE_LIMIT) -> Experiment:
    """Return the experiment that a file describes.

    The file as it stands is the variant ``base``. Each table ``[compare.<name>]`` is one more, in which some sections
    differ: tables are merged key by key, but a table that names its own ``model``, ``file`` or ``identified`` takes the
    place of the one above it. An empty ``[compare.<name>]`` only gives the file as it stands another name than
    ``base``. ``identified`` names a model of ``[identify.<name>]``, which `bristle.prepare` fits.

    Parameters
    ----------
    path : path-like
        An experiment file, TOML. The files that it names are looked for beside it.
    allow_code : bool
        Whether models of a person's own, in files that it names, may run without having been allowed before.
    size_limit : int or str
        Largest log that it names [byte], or text such as ``"2 GB"``.

    Raises
    ------
    InputError
        With file, key, value and what is allowed there.
    """
    data, source, content = read_toml(path, path="experiment", what="an experiment file")
    sources = Sources(source.parent, allow_code, size_of(size_limit))
    with located(source):
        experiment = experiment_from(with_models(data, source, sources), source, sources)
    own = {"experiment": (content.origin,)} if content is not None else {}
    return replace(experiment, origins=own | sources.origins)


def experiment_from(data: dict[str, Any], source: Path, sources: Sources) -> Experiment:
    """Return the experiment that the content of a file describes."""
    _refuse_contact(data, source)
    refuse_open(data)
    check_keys(data, KEYS, "")
    check_schema(data)
    name = data.get("name", source.stem)
    if not isinstance(name, str):
        raise InputError("must be text", path="name", value=name)
    base = {key: data[key] for key in ("kind", *SECTIONS) if key in data}
    as_it_stands = variant_from("base", Tables(base), sources)
    variants = []
    for label, override in table_at(data.get("compare", {}), "compare").items():
        path = f"compare.{label}"
        check_keys(table_at(override, path), SECTIONS, path)
        variants.append(variant_from(label, Tables(merged(base, override), override, path), sources))
    named = any(not override or label == "base" for label, override in data.get("compare", {}).items())
    if not named:
        variants.insert(0, as_it_stands)
    return Experiment(name=name, kind=as_it_stands.plant.kind, variants=tuple(variants), source=source)


def _refuse_contact(data: Mapping[str, Any], source: Path) -> None:
    """Refuse an experiment on a contact, and tell what runs it: no loop is in it."""
    if not OF_CONTACTS & data.keys() or OF_LOOPS & data.keys():
        return
    named = re.fullmatch(r"fig_0*(\d+)\.toml", source.name)
    folder, figure = shlex.quote(str(source.parent)), named[1] if named else "N"
    raise InputError("is an experiment on a contact, not on a loop", mend=f"Run it with: bristle paper --from {folder} --figure {figure}")
