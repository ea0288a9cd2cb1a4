"""pytest looks for examples only in modules whose library is installed, and computes with the same kernels on each x86 processor."""

import tests.blas  # noqa: F401  (before numpy)
from tests.optional import MISSING

collect_ignore = [f"src/{module.replace('.', '/')}.py" for module in MISSING]
pytest_plugins = [
    "tests.plugins.kernels",
    "tests.plugins.budget",
    "tests.plugins.order",
    "tests.plugins.skips",
]
