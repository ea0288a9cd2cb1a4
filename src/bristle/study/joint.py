"""Joint draws of a fit: whole rows of what its bootstrap found, so that its correlations are kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.content import Origin, content_of
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.experiment import Experiment
from bristle.files.arrays import read_arrays
from bristle.files.components import check_keys, key_of
from bristle.files.model import read_model
from bristle.study.target import sections_of

__all__ = ["Fitted", "columns_of", "fitted_at"]

KEYS = ("from", "draws")
KINDS = ("bootstrap",)
SECTIONS = ("plant", "friction")


@dataclass(frozen=True)
class Fitted:
    """The draws of an identification."""

    folder: str
    plant: Model | None
    friction: Model
    draws: Mapping[str, np.ndarray] = field(repr=False)
    origin: Origin

    @property
    def count(self) -> int:
        """How many draws there are."""
        return min(len(values) for values in self.draws.values())


def fitted_at(table: Mapping[str, Any], folder: Path, path: str, *, allow_code: bool = False) -> Fitted:
    """Return the draws that a table such as ``{ from = "results", draws = "bootstrap" }`` names."""
    check_keys(table, KEYS, path)
    for key in KEYS:
        if key not in table:
            raise InputError(f"needs {key}", path=path, mend='Write { from = "results", draws = "bootstrap" }')
    if table["draws"] not in KINDS:
        raise InputError("are no draws of a fit", path=f"{path}.draws", value=table["draws"], allowed=KINDS[0])
    named = table["from"]
    if not isinstance(named, str) or not named:
        raise InputError("must be the name of a folder of results", path=f"{path}.from", value=named)
    results = folder / named
    try:
        plant, friction, info = read_model(results / "model.toml", allow_code=allow_code)
        draws = read_arrays(results, "draws")
    except InputError as error:
        raise error.at(f"{path}.from") from None
    file = next((results / f"draws{end}" for end in (".parquet", ".npz") if draws), results / "model.toml")
    if not draws:
        draws = (info["bands"] or {}).get("draws", {})
    if not draws:
        raise InputError(
            "holds no draws: it was identified without intervals", path=f"{path}.from", value=named, mend="Identify again with --draws 1000"
        )
    file = file if file.is_file() else results / "draws.npz"
    return Fitted(named, plant, friction, draws, content_of(file).origin)


def columns_of(fitted: Fitted, section: str, experiment: Experiment, path: str) -> dict[str, np.ndarray]:
    """Return the draws of one section of an experiment by dotted key, in SI."""
    if section not in SECTIONS:
        raise InputError("takes no draws of a fit", path=path, allowed=" or ".join(SECTIONS))
    own = sections_of(experiment.variants[0])[section]
    drawn = fitted.friction if section == "friction" else fitted.plant
    if drawn is None or (own.name, own.kind) != (drawn.name, drawn.kind):
        raise InputError(
            f"the fit is of {'no plant' if drawn is None else f'{drawn.name}, {drawn.kind}'}, and the experiment has "
            f"{own.name}, {own.kind}",
            path=path,
            value=fitted.folder,
            mend=f'Write file = "{fitted.folder}/model.toml" under [friction] of the experiment',
        )
    columns = {
        f"{section}.{key_of(name)}": values[: fitted.count] for name, values in fitted.draws.items() if name in own.component.variables
    }
    if not columns:
        raise InputError(f"the fit drew no parameter of {own.name}", path=path, value=fitted.folder, allowed=", ".join(fitted.draws))
    return columns
