"""pytest looks for examples only in modules whose library is installed."""

from tests.optional import MISSING

collect_ignore = [f"src/{module.replace('.', '/')}.py" for module in MISSING]
