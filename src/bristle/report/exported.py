"""`export`: files of a model for a target, with effect and provenance, for the command line and the lab."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from bristle.core import Axis, Content, InputError, Model, Variable, Variant, amount, content_of
from bristle.files import SUMMARY, TOML_LIMIT, as_json, origins_of_code, provenance

if TYPE_CHECKING:
    from bristle.exports import Product, Target
    from bristle.files import Results


class ExportedModel(NamedTuple):
    """Files of an export with their content and provenance."""

    target: str
    product: Product
    name: str
    provenance: dict[str, str]
    beside: tuple[str, ...] = ()

    @property
    def summary(self) -> dict[str, Any]:
        """The contents of ``summary.json``."""
        effect = None if self.product.effect is None else self.product.effect.as_data()
        notes = [*self.product.notes, *self.beside]
        about = {"target": self.target, "model": self.name, "files": list(self.product.files)}
        error = {} if self.product.error is None else {"error": dict(self.product.error)}
        return about | {"notes": notes, "effect": effect} | error | {"provenance": self.provenance}

    def write(self, folder: Results) -> None:
        """Write the files and the summary into a folder of results."""
        for file_name, content in self.product.files.items():
            folder.write(file_name, content)
        folder.write(SUMMARY, as_json(self.summary))


def export_model_file(
    model: Path,
    to: str | Target,
    *,
    command: str,
    float32: bool = False,
    axis: Any = None,
    speed: str | None = None,
    log: Any = None,
    allow_code: bool = False,
    **options: Any,
) -> ExportedModel:
    """Return the files of a friction model or an operator for a target; further options of `files_from_text` are name, step and others."""
    from bristle.exports import Source, files_from_text, target_named
    from bristle.files import read_axis
    from bristle.logs import read_log

    target, file, beside = (
        target_named(to),
        content_of(model, limit=TOML_LIMIT),
        model.parent / "axis.toml",
    )
    plant, exported, facts = _read(file, allow_code=allow_code)
    code = origins_of_code([exported.component]) if exported.component.family == "friction" else ()
    described = (
        read_axis(beside if axis is None else axis)
        if axis is not None or beside.is_file()
        else None
    )
    recorded = None if log is None else read_log(log, described)
    source = provenance(
        command, model=file, log=recorded, code=code, target=origins_of_code([target])
    )
    fastest = facts["treatment"].get("velocity_max", 0.0)
    if speed is not None:
        fastest = amount(Variable("length/time", "largest speed", min=0.0), exclusive=True)(
            speed, "--speed", exported.kind
        )
    loop, remarks = _loop_beside(model.parent / "experiment.toml", exported, described)
    product = files_from_text(
        target,
        exported,
        Source(source, facts["uncertainty"]),
        single=float32,
        axis=described,
        speed=float(fastest),
        mass=1.0 if plant is None else float(plant.values.get("M", 1.0)),
        plant=plant,
        log=recorded,
        info=facts,
        loop=loop,
        **options,
    )
    return ExportedModel(target.name, product, exported.name, source, remarks)


def _read(file: Content, *, allow_code: bool) -> tuple[Model | None, Model, dict[str, Any]]:
    """Return plant, friction model or operator, and further facts of a model file."""
    from bristle.contract import admit
    from bristle.files import holds_operator, read_model, read_operator
    from bristle.models.hysteresis import with_constant

    if holds_operator(file):
        operator, offset, _ = read_operator(file)
        return None, with_constant(operator, offset), {"uncertainty": {}, "treatment": {}}
    plant, exported, facts = read_model(file, allow_code=allow_code)
    admit(exported)
    return plant, exported, facts


def _loop_beside(
    file: Path, model: Model, axis: Axis | None
) -> tuple[Variant | None, tuple[str, ...]]:
    """Return the loop of the experiment file in the folder of a model file, and the reason if it is unreadable."""
    from bristle.files import read_experiment

    if axis is None or axis.controller is None or not file.is_file():
        return None, ()
    try:
        variants = read_experiment(file).variants
    except InputError as error:
        return None, (f"bristle did not simulate the loop of {file.name}: {error}",)
    return next(
        (variant for variant in variants if variant.feedforward.friction == model), None
    ), ()
