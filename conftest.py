"""pytest looks for examples only in modules whose library is installed, and computes with the same kernels on each x86 processor."""

import os
import platform

if platform.machine() in ("x86_64", "AMD64"):
    # OpenBLAS rounds differently on each family of processors, and fits may stop at another point. It reads this as numpy loads.
    os.environ.setdefault("OPENBLAS_CORETYPE", "Haswell")

from tests.optional import MISSING

collect_ignore = [f"src/{module.replace('.', '/')}.py" for module in MISSING]
