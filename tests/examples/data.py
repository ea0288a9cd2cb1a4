"""Where measured logs lie."""

import os
from pathlib import Path

import pytest


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
