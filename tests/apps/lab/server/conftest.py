"""What several tests of the served lab need: the application within the `LIMITS` of their file, and a folder for temporary files."""

import tempfile

import pytest
from starlette.testclient import TestClient
from tests.apps.lab.browser import shown  # noqa: F401
from tests.apps.lab.server.mouse import person_at  # noqa: F401
from tests.apps.lab.server.yard import PORT, TOKEN, served

from bristle.apps.lab.server.application import application
from bristle.apps.lab.server.limits import Limits


@pytest.fixture(scope="module")
def server(request):
    """A server within the limits of a file."""
    with served(getattr(request.module, "LIMITS", Limits())) as server:
        yield server


@pytest.fixture
def app(tmp_path, request):
    return application(tmp_path, TOKEN, PORT, getattr(request.module, "LIMITS", Limits()))


@pytest.fixture
def client(app):
    with TestClient(
        app, base_url=f"http://127.0.0.1:{PORT}", headers={"x-bristle-token": TOKEN}
    ) as client:
        yield client


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """A temporary folder of this process and of others."""
    place = tmp_path / "temporary"
    place.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    return place
