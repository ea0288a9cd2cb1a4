"""pytest looks for examples only in bridges whose library is installed."""

from importlib.util import find_spec

LIBRARIES = {"drake": "pydrake", "gymnasium": "gymnasium"}
collect_ignore = [f"src/bristle/bridges/{module}.py" for module, library in LIBRARIES.items() if find_spec(library) is None]
