"""Where results come from."""

import shutil
import subprocess

import pytest

from bristle.core.content import Origin, content_of
from bristle.files.summary import provenance


@pytest.mark.skipif(not shutil.which("sha256sum"), reason="needs bash and git")
def test_names_checksums_and_command(tmp_path):
    log = tmp_path / "log.csv"
    log.write_bytes(b"t,q\n0,1\n")
    content = content_of(log)
    log.write_bytes(b"another")
    result = provenance("bristle identify log.csv", log=content, axis=None, code=())
    (tmp_path / "as_read.csv").write_bytes(content.data)
    printed = subprocess.run(
        ["sha256sum", tmp_path / "as_read.csv"], capture_output=True, text=True, check=True
    ).stdout.split()[0]
    assert {name: text for name, text in result.items() if name != "bristle"} == {
        "log": "log.csv",
        "log_sha256": printed,
        "command": "bristle identify log.csv",
    }


def test_only_further_files_are_numbered_and_names_have_no_folders():
    logs = [Origin("a.csv", "1"), Origin("odd\udcff.csv", "2")]
    result = provenance("bristle", log=logs)
    assert result["log"] == "a.csv"
    assert (result["log_2"], result["log_2_sha256"]) == ("odd\\xff.csv", "2")
