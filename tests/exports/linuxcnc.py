"""HAL of LinuxCNC for tests: one session of a machine at a time, components installed and removed again."""

import fcntl
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest

LOCK = Path(tempfile.gettempdir()) / "linuxcnc-hal.lock"
MODULES = Path("/usr/lib/linuxcnc/modules")
NOBODY = "65534"
PATIENCE = 60.0  # [s]


def _lacking():
    if shutil.which("halcompile") is None or shutil.which("halrun") is None:
        return "needs halcompile of LinuxCNC (packages linuxcnc-uspace and linuxcnc-uspace-dev)"
    return "" if os.access(MODULES, os.W_OK) else f"cannot install a component into {MODULES}"


LACKING = _lacking()
"""Reason for which HAL cannot be run here; empty if it can."""


def in_hal(files, folder, started):
    """Return the output of a session of HAL, and the files that it wrote, by name; the component is compiled without a warning."""
    for name, content in files.items():
        (folder / name).write_text(content, encoding="ascii")
    before, installed = set(files), []
    with LOCK.open("w") as lock, tempfile.TemporaryDirectory(prefix="hal") as socket:
        fcntl.flock(lock, fcntl.LOCK_EX)
        os.chmod(socket, 0o777)
        # rtapi_app does not run as root, and is found by its socket. It inherits the outputs: files, for a pipe would stay open.
        environment = os.environ | {"RTAPI_UID": NOBODY, "RTAPI_FIFO_PATH": f"{socket}/fifo"}
        if "halcmd" not in (shown := _ran(["halcmd", "show", "comp"], folder, environment)[0]) or len(shown.split("\n")) > 5:
            pytest.skip("HAL is in use on this machine")
        try:
            for name in before:
                if name.endswith(".comp"):
                    said = "".join(_ran(["halcompile", "--compile", name], folder, environment))
                    assert "warning" not in said.lower(), said
                    installed.append(MODULES / name.replace(".comp", ".so"))
                    shutil.copy(folder / installed[-1].name, installed[-1])
            said, faults = _ran(["halrun", "-f", started], folder, environment)
        finally:
            for module in installed:
                module.unlink()
    found = {path.name: path.read_text(encoding="ascii") for path in folder.glob("*.txt") if path.name not in before}
    return found | {"stdout": said.replace("Note: Using POSIX non-realtime\n", ""), "stderr": faults}


def _ran(command, folder, environment):
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        ran = subprocess.run(
            command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=out, stderr=err, timeout=PATIENCE, check=False
        )
        out.seek(0)
        err.seek(0)
        texts = out.read(), err.read()
    assert ran.returncode == 0, f"{command}: {texts}"
    return texts
