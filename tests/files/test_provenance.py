"""Where results come from."""

import subprocess

from bristle.files.provenance import provenance


def test_names_checksums_and_command(tmp_path):
    log = tmp_path / "log.csv"
    log.write_bytes(b"t,q\n0,1\n")
    found = provenance("bristle identify log.csv", log=log, axis=None)
    printed = subprocess.run(["sha256sum", log], capture_output=True, text=True, check=True).stdout.split()[0]
    assert found["log"] == "log.csv"
    assert found["log_sha256"] == printed
    assert found["command"] == "bristle identify log.csv"
    assert "axis" not in found
