"""Modules of the package that need a library which the tests do not install."""

from importlib.util import find_spec

LIBRARIES = {"bristle.apps.targets.drake": "pydrake"}
MISSING = [module for module, library in LIBRARIES.items() if find_spec(library) is None]
