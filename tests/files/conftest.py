"""A friction model of a user's own, in a file."""

from pathlib import Path

import pytest
from tests.cli.conftest import USER_MODEL

OWN = USER_MODEL.replace(
    "directional=True)]\n",
    'directional=True)]\n    lambda_: Annotated[float, Variable("1", "a parameter named as a keyword is")] = 1.0\n',
)


@pytest.fixture
def own_model(tmp_path) -> Path:
    """The file of a user's own model."""
    path = tmp_path / "own.py"
    path.write_text(OWN)
    return path
