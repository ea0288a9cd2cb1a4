"""pytest looks for examples only in modules whose library is installed, and computes with the same kernels on each x86 processor."""

import os
import platform

if platform.machine() in ("x86_64", "AMD64"):
    # OpenBLAS rounds differently on each family of processors, and fits may stop at another point. It reads this as numpy loads.
    os.environ.setdefault("OPENBLAS_CORETYPE", "Haswell")
# Before numpy is loaded: beside another worker a second thread of linear algebra does nothing but wait, on its core.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

from tests.optional import MISSING

collect_ignore = [f"src/{module.replace('.', '/')}.py" for module in MISSING]
pytest_plugins = ["tests.plugins.kernels", "tests.plugins.budget", "tests.plugins.order", "tests.plugins.skips"]
