"""Read binary files in a separate process.

The libraries that read them are native code. A damaged file can make such a library loop, exhaust the memory or crash.
No Python code can catch these failures: signals are handled only after the library returns. A separate process ends at a
limit of time and memory, and its caller can be interrupted. Only a line of text and plain numbers cross over, so that
no content of the file is executed here.
"""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from pkgutil import resolve_name

import numpy as np

from bristle.core.errors import InputError, shortened
from bristle.logs.table import Choice, Request, Table, damage_refused

# Of processor time, limit for a file that makes its reader loop.
SECONDS, BYTES_A_SECOND = (6.0, 20e6)
PATIENCE = 4.0  # times that, by the clock, on a machine that is busy
# Files can ask for plugins of HDF5, which are libraries: load none. One thread of linear algebra is enough.
# Ctrl-C in a terminal goes to the caller, which ends this process.
ENVIRONMENT = {"HDF5_PLUGIN_PRELOAD": "::", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def read_apart(reader: str, data: bytes, request: Request) -> Table:
    """Return the table in a binary file, read in a separate process by the function `reader`, ``module:name``."""
    head = {
        "reader": reader,
        "source": str(request.source),
        "table": request.table,
        "names": None if request.choice.names is None else sorted(request.choice.names),
        "usual": request.choice.usual,
        "limit": request.limit,
        "seconds": int(SECONDS + len(data) / BYTES_A_SECOND),
    }
    code = "from bristle.logs.apart import serve; serve()"
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", code],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ
        | ENVIRONMENT
        | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
        # A separate process group: Ctrl-C goes to the waiting program, which ends the reader.
        start_new_session=sys.platform != "win32",
        creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
    )
    out, ending = b"", None
    with process:
        try:
            out, stderr = process.communicate(
                json.dumps(head).encode() + b"\n" + data, PATIENCE * head["seconds"]
            )
        except subprocess.TimeoutExpired:
            process.kill()
            ending = "the library takes too long to read it"
        except BaseException:
            process.kill()
            raise
        else:
            code = process.returncode
            last = shortened(stderr.decode("utf-8", "replace").strip().rpartition("\n")[2], 120)
            if code == -getattr(signal, "SIGXCPU", 0) != 0:
                ending = "the library takes too long to read it"
            elif code != 0:
                ending = (
                    f"the library that reads this format crashed with signal {-code}"
                    if code < 0
                    else last
                )
    if ending is not None:
        raise InputError(
            f"is damaged, or in an unsupported format ({ending})",
            path=str(request.source),
            mend="Copy or save it again",
        )
    line, _, rest = out.partition(b"\n")
    record = json.loads(line)
    if "refused" in record:
        raise InputError(**record["refused"])
    numbers, at, columns = np.frombuffer(rest, float), 0, {}
    for name, size in record.pop("sizes").items():
        columns[name] = numbers[at : at + size].copy()
        at += size
    return Table(
        columns, **record | {name: tuple(record[name]) for name in ("notes", "tables", "names")}
    )


def serve() -> None:
    """Answer one request of `read_apart`."""
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # prints of a library must not mix with the answer
    head = json.loads(sys.stdin.buffer.readline())
    # The system ends this process at the limit, even if the caller is gone.
    with suppress(ImportError):  # missing on this system: the caller ends the process
        import resource

        most = 3 * 2**29 + 4 * head["limit"]  # of address space, in addition to the data
        for name, soft, hard in (
            ("CPU", head["seconds"], head["seconds"] + 1),
            ("AS", most, most),
            ("CORE", 0, 0),
        ):
            # Some systems have a limit but refuse to set it, or already have a smaller limit.
            with suppress(AttributeError, ValueError, OSError):
                resource.setrlimit(getattr(resource, f"RLIMIT_{name}"), (soft, hard))
    data = sys.stdin.buffer.read()
    read: Callable[..., Table] = resolve_name(head["reader"])
    choice = Choice(None if head["names"] is None else frozenset(head["names"]), head["usual"])
    try:
        with damage_refused(Path(head["source"])):
            table = read(data, Request(Path(head["source"]), head["table"], choice, head["limit"]))
    except InputError as error:
        parts = {name: getattr(error, name) for name in ("message", "path", "allowed", "mend")}
        value = error.value if isinstance(error.value, (str, int, float)) else None
        out.write(json.dumps({"refused": parts | {"value": value}}).encode() + b"\n")
    else:
        attributes = (
            "units",
            "constants",
            "sample_time",
            "notes",
            "format",
            "tables",
            "names",
            "stamps",
            "facts",
            "about",
        )
        record = {name: getattr(table, name) for name in attributes}
        sizes = {name: int(values.size) for name, values in table.columns.items()}
        out.write(json.dumps({"sizes": sizes} | record).encode() + b"\n")
        for values in table.columns.values():
            out.write(np.ascontiguousarray(values, float).data)
    out.close()
