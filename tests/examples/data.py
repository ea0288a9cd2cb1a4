"""Where measured logs lie, and how examples are run."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


def measured(*parts: str) -> Path:
    """Return a file below the folder named in BRISTLE_DATA; a test without that folder is skipped."""
    folder = os.environ.get("BRISTLE_DATA")
    if not folder:
        pytest.skip("BRISTLE_DATA does not name the folder of the measured logs")
    path = Path(folder).joinpath(*parts)
    assert path.is_file(), f"{path} is missing"
    return path


def data_of(ended):
    """Return the JSON of a command line that must have succeeded."""
    assert ended.code == 0, ended.err
    return ended.data


def printed(name, timeout=900):
    """Return what an example prints."""
    done = subprocess.run(
        [sys.executable, EXAMPLES / name],
        capture_output=True,
        text=True,
        check=False,
        timeout=timeout,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def values_of(notebook):
    """Run a notebook, and return what its cells show."""
    spec = importlib.util.spec_from_file_location(
        "thumbnails", EXAMPLES / "notebooks" / "thumbnails.py"
    )
    thumbnails = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(thumbnails)
    return thumbnails.values_of(notebook)


def loaded(name):
    """Return the module of an example."""
    spec = importlib.util.spec_from_file_location(Path(name).stem, EXAMPLES / name)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
