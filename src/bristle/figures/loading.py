"""With this module matplotlib is imported, whatever the files and variables say that its user configures it with.

They are of no use to these figures (`bristle.figures.settings`), but matplotlib reads them as it is imported: a file in
another encoding or a backend that nobody knows ends that import.
"""

import io
import logging
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.machinery import ExtensionFileLoader
from importlib.util import find_spec, module_from_spec
from pathlib import Path
from typing import Any

__all__: list[str] = []

NAME = "matplotlib"


def _load() -> None:
    """Import matplotlib, with its user's settings if it can be, for figures of theirs; without remarks on them."""
    with _silent():
        if _settings_may_block():
            _load_without_settings()
        try:
            import_module(NAME)
        except ImportError:
            raise
        except Exception:  # noqa: BLE001  (what a file of settings can do to it has no common type)
            _forget()
            _load_without_settings()
        # On folders, fonts and what it is built upon it remarks once it looks for them.
        import_module(f"{NAME}.backends.backend_svg")


def _settings_may_block() -> bool:
    """Return whether a file of settings would be opened that is none: a pipe without a writer is waited for."""
    settings, own = os.environ.get("MATPLOTLIBRC", ""), os.environ.get("MPLCONFIGDIR", "")
    folders = [Path(), Path(settings), Path(own), Path("~/.config/matplotlib"), Path("~/.matplotlib")]
    candidates = [Path(settings), *(folder.expanduser() / "matplotlibrc" for folder in folders)]
    return any(candidate.exists() and not candidate.is_file() and not candidate.is_dir() for candidate in candidates)


@contextmanager
def _silent() -> Iterator[None]:
    log = logging.getLogger(NAME)
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        log.setLevel(level)


def _forget() -> None:
    """Remove what is left of an import that failed: its modules refer to the package that is gone."""
    for name, module in list(sys.modules.items()):
        # Compiled ones refer to nothing, and cannot be loaded twice.
        if name.startswith(f"{NAME}.") and not isinstance(getattr(module, "__loader__", None), ExtensionFileLoader):
            del sys.modules[name]


def _load_without_settings() -> None:
    """Import matplotlib with every file of settings taken for empty, and no backend asked for."""
    spec = find_spec(NAME)
    assert spec is not None
    assert spec.loader is not None
    assert spec.origin is not None
    own, module = Path(spec.origin).resolve().parent, module_from_spec(spec)

    def without_settings(file: Any, *args: Any, **kwargs: Any) -> Any:
        return open(file, *args, **kwargs) if own in Path(file).resolve().parents else io.StringIO()

    # A global name hides the built-in one from the functions of this module, and from nothing else.
    vars(module)["open"] = without_settings
    backend = os.environ.pop("MPLBACKEND", None)
    sys.modules[NAME] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[NAME]
        raise
    finally:
        vars(module).pop("open", None)
        if backend is not None:
            os.environ["MPLBACKEND"] = backend


if NAME not in sys.modules:
    _load()
