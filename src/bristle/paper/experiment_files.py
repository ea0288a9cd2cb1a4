"""The experiments of the paper as files: where they are, and how to have a copy to change."""

from __future__ import annotations

import shutil
from importlib.resources import files
from pathlib import Path

from bristle.core.errors import InputError

__all__ = ["EXPERIMENTS", "write_experiments"]

EXPERIMENTS = Path(str(files("bristle.paper") / "experiments"))


def write_experiments(folder: Path, *, force: bool = False) -> list[Path]:
    """Copy the experiments of the paper into a folder, to be read, changed and run.

    Parameters
    ----------
    folder : Path
        Where to; it is made where there is none.
    force : bool
        Whether files of the same name are replaced.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If a file is in the way, or the folder cannot be written.
    """
    sources = sorted(one for one in EXPERIMENTS.iterdir() if one.suffix == ".toml")
    in_the_way = [one.name for one in sources if (folder / one.name).exists()]
    if in_the_way and not force:
        raise InputError(
            f"holds {in_the_way[0]} already", path=str(folder), mend="Name another folder, or add --force to replace it"
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return [Path(shutil.copyfile(one, folder / one.name)) for one in sources]
    except OSError as error:
        raise InputError(
            f"cannot be written: {(error.strerror or str(error)).lower()}", path=str(folder), mend="Name another folder"
        ) from error
