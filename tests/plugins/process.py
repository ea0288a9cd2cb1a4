"""What this process has used of the machine."""

import os
import sys
from pathlib import Path

BYTES_A_UNIT = 1 if sys.platform == "darwin" else 1024


def seconds(*, children: bool = True) -> float:
    """Return the processor time of this process, and of its children that have ended [s]."""
    used = os.times()
    own = used.user + used.system
    return own + used.children_user + used.children_system if children else own


def peak_megabytes() -> float:
    """Return the largest resident memory of this process so far [MB], 0 where the system does not tell it."""
    try:
        import resource
    except ImportError:
        return 0.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * BYTES_A_UNIT / 1e6


def resident_megabytes() -> float:
    """Return the resident memory of this process now [MB], 0 where the system does not tell it."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6
