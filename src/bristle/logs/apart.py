"""Binary files are read in a process of their own.

The libraries that read them are native code. A file with one flipped byte can make them loop, ask for all memory or
crash, and none of that can be caught: a signal is not even seen before they return. In a process of its own they end at
a limit of time and memory, and whoever waits for them can be interrupted. What crosses over is a line of text and plain
numbers, so nothing that a file does there becomes code here.
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

SECONDS, BYTES_A_SECOND = 6.0, 20e6  # of processor time, before a file counts as one that has no end
PATIENCE = 4.0  # times that, by the clock, on a machine that is busy
# A plugin of HDF5 is a library that a file can ask for; none is loaded. One thread of linear algebra is enough.
# Ctrl-C in a terminal goes to whoever waits, who ends it.
ENVIRONMENT = {"HDF5_PLUGIN_PRELOAD": "::", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def read_apart(reader: str, data: bytes, request: Request) -> Table:
    """Return the table in a binary file, read in a process of its own by the function `reader`, ``module:name``."""
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
        env=os.environ | ENVIRONMENT | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
        # A group of its own: Ctrl-C goes to the program that waits, and that one ends the reader.
        start_new_session=sys.platform != "win32",
        creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
    )
    out, ending = b"", None
    with process:
        try:
            out, stderr = process.communicate(json.dumps(head).encode() + b"\n" + data, PATIENCE * head["seconds"])
        except subprocess.TimeoutExpired:
            process.kill()
            ending = "takes too long"
        except BaseException:
            process.kill()
            raise
        else:
            code = process.returncode
            last = shortened(stderr.decode("utf-8", "replace").strip().rpartition("\n")[2], 120)
            if code == -getattr(signal, "SIGXCPU", 0) != 0:
                ending = "takes too long"
            elif code != 0:
                ending = f"the library that reads it ended with signal {-code}" if code < 0 else last
    if ending is not None:
        message = f"is damaged, or of a kind that is not read ({ending})"
        raise InputError(message, path=str(request.source), mend="Copy or save it again")
    line, _, rest = out.partition(b"\n")
    record = json.loads(line)
    if "refused" in record:
        raise InputError(**record["refused"])
    numbers, at, columns = np.frombuffer(rest, float), 0, {}
    for name, size in record.pop("sizes").items():
        columns[name] = numbers[at : at + size].copy()
        at += size
    return Table(columns, **record | {name: tuple(record[name]) for name in ("notes", "tables", "names")})


def serve() -> None:
    """Answer one request: the other side of `read_apart`."""
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints must not come between
    head = json.loads(sys.stdin.buffer.readline())
    # The system ends this process, should it take more, even if nobody waits any more.
    with suppress(ImportError):  # not on this system: whoever waits ends it
        import resource

        most = 3 * 2**29 + 4 * head["limit"]  # of addresses, beside what is read
        for name, soft, hard in (("CPU", head["seconds"], head["seconds"] + 1), ("AS", most, most), ("CORE", 0, 0)):
            # Some systems know a limit and do not take it, or have a smaller one already.
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
        attributes = ("units", "constants", "sample_time", "notes", "format", "tables", "names", "stamps", "facts", "about")
        record = {name: getattr(table, name) for name in attributes}
        sizes = {name: int(values.size) for name, values in table.columns.items()}
        out.write(json.dumps({"sizes": sizes} | record).encode() + b"\n")
        for values in table.columns.values():
            out.write(np.ascontiguousarray(values, float).data)
    out.close()
