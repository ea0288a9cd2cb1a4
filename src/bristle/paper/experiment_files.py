"""The experiments of the paper as files: where they are, and how to have a copy to change."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from bristle.files.results import results_folder

__all__ = ["EXPERIMENTS", "write_experiments"]

EXPERIMENTS = Path(str(files("bristle.paper") / "experiments"))


def write_experiments(folder: Path, *, force: bool = False) -> list[Path]:
    """Copy the experiments of the paper into a new folder, to be read, changed and run.

    Parameters
    ----------
    folder : Path
        The folder. Its parent must exist.
    force : bool
        Whether an earlier copy is replaced, if nobody changed it.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the folder is there already, or cannot be written.
    """
    sources = sorted(source for source in EXPERIMENTS.iterdir() if source.suffix == ".toml")
    with results_folder(folder, force=force) as written:
        for source in sources:
            written.write(source.name, source.read_bytes())
    return [folder / source.name for source in sources]
