"""Linear algebra with the same kernels on each x86 processor, in one thread; imported before numpy is loaded."""

import os
import platform

if platform.machine() in ("x86_64", "AMD64"):
    # OpenBLAS rounds differently on each family of processors, and fits may stop at another point. It reads this as numpy loads.
    os.environ.setdefault("OPENBLAS_CORETYPE", "Haswell")
# Beside another worker a second thread of linear algebra does nothing but wait, on its core.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
