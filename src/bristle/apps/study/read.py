"""Study files: an experiment, its varied values, counts, and stored metrics."""

import copy
from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from bristle.apps.study.plan import (
    BLOCK_MOST,
    SAMPLINGS,
    Metric,
    Sampling,
    Study,
    block_for,
    metrics_from,
    usual_metrics,
)
from bristle.apps.study.values import (
    Cause,
    Fitted,
    Joint,
    Target,
    columns_of,
    drawn_from,
    fitted_at,
    target_at,
)
from bristle.core import (
    SEED_MAX,
    SIZE_LIMIT,
    Experiment,
    InputError,
    Readable,
    content_of,
    did_you_mean,
    located,
    size_of,
)
from bristle.core.former import successor
from bristle.files import (
    TOML_LIMIT,
    Sources,
    check_keys,
    check_schema,
    experiment_from,
    name_of,
    read_toml,
    table_at,
    with_models,
)

KEYS = (
    "schema",
    "name",
    "experiment",
    "runs",
    "seed",
    "sampling",
    "sobol_indices",
    "block",
    "vary",
    "grid",
    "keep",
)
RUNS_MOST = 1_000_000_000
POINTS_MOST = 100_000


def read_study_file(
    path: Readable, *, allow_code: bool = False, size_limit: int | str = SIZE_LIMIT
) -> Study:
    """Return the study in a file.

    Parameters
    ----------
    path : path-like
        A study file, TOML. File names in it are relative to its folder.
    allow_code : bool
        Whether your own models, in files named by the study file, may run without earlier permission.
    size_limit : int or str
        Largest size of a log named by the study file [byte], or text such as ``"2 GB"``.

    Raises
    ------
    InputError
        If the file is not valid. The message states file, key, value and allowed values.
    """
    data, source, content = read_toml(path, path="study", what="a study file")
    with located(source):
        study = _Reader(data, source, allow_code, size_of(size_limit)).study()
    if content is None:
        return study
    return replace(study, origins={"study": (content.origin,)} | dict(study.origins))


class _Reader:
    """Parser of the content of a study file."""

    def __init__(
        self, data: dict[str, Any], source: Path, allow_code: bool, size_limit: int
    ) -> None:
        self.data = data
        self.source = source
        self.allow_code = allow_code
        self.size_limit = size_limit
        self.fitted: dict[tuple[str, str], Fitted] = {}

    def study(self) -> Study:
        """Return the study."""
        if "experiment" not in self.data:
            raise InputError(
                "is missing",
                path="experiment",
                mend='Write experiment = "rig.toml". This file may contain [friction] file = "results/model.toml"',
            )
        check_keys(self.data, KEYS, "")
        check_schema(self.data)
        tables, sources, origins = self._experiment()
        experiment = experiment_from(tables, self.source, sources)
        # One run of each variant: the runs of a study have separate seeds.
        experiment = replace(
            experiment,
            variants=tuple(
                replace(each, run=replace(each.run, seeds=1)) for each in experiment.variants
            ),
        )
        tables = {"kind": experiment.kind, **tables}
        causes = self._causes(experiment, tables)
        grid = self._grid(experiment, tables)
        self._refuse_doubles(causes, grid, experiment)
        sampling = self._sampling(causes, grid)
        origins = origins | sources.origins
        if self.fitted:
            origins["draws"] = tuple(fitted.origin for fitted in self.fitted.values())
        study = Study(
            name=name_of(self.data, self.source),
            experiment=experiment,
            tables=tables,
            sources=sources,
            seed=sampling.seed,
            sampling=sampling,
            causes=causes,
            grid=grid,
            metrics=self._metrics(experiment),
            block=1,
            described={},
            origins=origins,
        )
        if study.count > RUNS_MOST:
            raise InputError(
                "are too many, multiplied by the points of the grid",
                path="runs",
                value=study.count,
                allowed=f"up to {RUNS_MOST}",
            )
        block = block_for(study.count, experiment)
        if self.data.get("block") is not None:
            block = self._count("block", 1, BLOCK_MOST)
        files = {
            f"{role}: {origin.name}": origin.checksum
            for role, group in origins.items()
            for origin in group
        }
        # Identity of a study: its description, its files, and its software.
        described = {
            "study": {
                key: value
                for key, value in self.data.items()
                if key not in ("name", "block", "schema")
            },
            "block": block,
            "files": files,
            "points_sha256": sampling.checksum(),
            "bristle": version("bristle"),
        }
        return replace(study, block=block, described=described)

    def _count(self, key: str, least: int, most: int) -> int:
        value = self.data[key]
        if type(value) is not int or not least <= value <= most:
            raise InputError(
                "does not fit", path=key, value=value, allowed=f"a whole number, {least} to {most}"
            )
        return value

    def _experiment(self) -> tuple[dict[str, Any], Sources, dict[str, Any]]:
        """Return the tables of the experiment, the reader of the files that they name, and the source file."""
        named = self.data["experiment"]
        if not isinstance(named, str) or not named:
            raise InputError("must be the name of a file", path="experiment", value=named)
        content = content_of(
            self.source.parent / named,
            limit=TOML_LIMIT,
            path="experiment",
            what="an experiment file",
        )
        tables, source, _ = read_toml(content)
        sources = Sources(source.parent, self.allow_code, self.size_limit)
        with located(source):
            tables = with_models(tables, source, sources)
            experiment_from(tables, source, sources)
        return copy.deepcopy(tables), sources, {"experiment": (content.origin,)}

    def _causes(self, experiment: Experiment, tables: Mapping[str, Any]) -> tuple[Cause, ...]:
        causes: list[Cause] = []
        joint: dict[str, tuple[dict[str, Any], dict[str, str]]] = {}
        for key, value in table_at(self.data.get("vary", {}), "vary").items():
            path = f'vary."{key}"'
            if not isinstance(value, dict):
                raise InputError(
                    "must be a table",
                    path=path,
                    value=value,
                    mend=f'Write "{key}" = {{ normal = [mean, standard deviation] }}',
                )
            if "from" in value or "draws" in value:
                # The reader of the table refuses it unless it names two texts.
                names = (str(value.get("from")), str(value.get("draws")))
                if names not in self.fitted:
                    self.fitted[names] = fitted_at(
                        value, self.source.parent, path, allow_code=self.allow_code
                    )
                fitted = self.fitted[names]
                if fitted.folder not in joint:
                    joint[fitted.folder] = ({}, {})
                    causes.append(Joint(fitted.folder, *joint[fitted.folder]))
                for parts, more in zip(
                    joint[fitted.folder], columns_of(fitted, key, experiment, path), strict=True
                ):
                    parts |= more
            else:
                target = target_at(key, experiment, tables, path)
                causes.append(drawn_from(value, target, path))
        return tuple(causes)

    def _grid(
        self, experiment: Experiment, tables: Mapping[str, Any]
    ) -> tuple[tuple[Target, tuple[Any, ...]], ...]:
        grid = []
        points = 1
        for key, values in table_at(self.data.get("grid", {}), "grid").items():
            path = f'grid."{key}"'
            if not isinstance(values, list) or not values:
                raise InputError(
                    "must be a list of values",
                    path=path,
                    value=values,
                    mend=f'Write "{key}" = [value, value]',
                )
            target = target_at(key, experiment, tables, path)
            numbers = target.numbers(values, path)
            if len(set(numbers)) < len(numbers):
                raise InputError("has a value twice", path=path, value=values)
            grid.append((target, numbers))
            points *= len(numbers)
        if points > POINTS_MOST:
            raise InputError(f"has {points} points", path="grid", allowed=f"up to {POINTS_MOST}")
        return tuple(grid)

    def _refuse_doubles(
        self, causes: tuple[Cause, ...], grid: tuple[Any, ...], experiment: Experiment
    ) -> None:
        models = [
            model
            for variant in experiment.variants
            for model in (variant.sensor, variant.friction, variant.table)
            if model is not None
        ]
        is_random = any(
            model.values.get(name, 0.0) > 0.0 for model in models for name in ("noise", "scatter")
        )
        if not causes and not grid and not is_random:
            raise InputError(
                "varies no value, so all runs would be equal",
                path="vary",
                mend="Write [vary] or [grid], or set sensor.noise in the experiment",
            )
        paths = [path for cause in causes for path in cause.units] + [
            target.path for target, _ in grid
        ]
        for path in paths:
            if paths.count(path) > 1:
                raise InputError(
                    "varies a value twice",
                    path="vary",
                    value=path,
                    mend="Remove this value from [grid] or from [vary]",
                )

    def _sampling(self, causes: tuple[Cause, ...], grid: tuple[Any, ...]) -> Sampling:
        for key, example in (("runs", 1000), ("seed", 1)):
            if key not in self.data:
                raise InputError("is missing", path=key, mend=f"Write {key} = {example}")
        runs = self._count("runs", 1, RUNS_MOST)
        seed = self._count("seed", 0, SEED_MAX)
        method = self.data.get("sampling", SAMPLINGS[0])
        if method not in SAMPLINGS:
            raise InputError(
                "is no sampling method",
                path="sampling",
                value=method,
                allowed=", ".join(SAMPLINGS),
                mend=did_you_mean(method, SAMPLINGS),
            )
        indices = self.data.get("sobol_indices", False)
        if type(indices) is not bool:
            raise InputError(
                "does not fit", path="sobol_indices", value=indices, allowed="true or false"
            )
        if indices and (grid or not causes):
            raise InputError(
                "need values of [vary], and exclude [grid]",
                path="sobol_indices",
                mend="Move the values of [grid] to [vary] as a choice",
            )
        if (indices or method == "sobol") and runs & (runs - 1):
            below = 2 ** (runs.bit_length() - 1)
            raise InputError(
                "must be a power of two for Sobol sampling",
                path="runs",
                value=runs,
                mend=f"Write runs = {below} or {2 * below}",
            )
        return Sampling(method, seed, tuple(cause.name for cause in causes), runs, indices)

    def _metrics(self, experiment: Experiment) -> tuple[Metric, ...]:
        table = table_at(self.data.get("keep", {}), "keep")
        if "traces" in table:
            raise InputError("was removed", path="keep.traces", mend=successor("keep.traces"))
        check_keys(table, ("metrics",), "keep")
        names = table.get("metrics", list(usual_metrics(experiment)))
        if not isinstance(names, list) or not names:
            raise InputError(
                "must be a list of metrics",
                path="keep.metrics",
                value=names,
                mend=f'Write metrics = ["{usual_metrics(experiment)[0]}"]',
            )
        return metrics_from(names, experiment, "keep.metrics")
