"""Import of matplotlib, without its warnings about the settings of its user.

These figures do not depend on the settings (`bristle.report.figures.drawing`). If they break the import, an `InputError` is raised.
"""

import logging
import sys
import warnings
from importlib import import_module

from bristle.core import InputError

__all__: list[str] = []

NAME = "matplotlib"


def _load() -> None:
    """Import matplotlib with the settings of its user, for the user's figures; without warnings about them."""
    log = logging.getLogger(NAME)
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            # It warns about folders, fonts and its dependencies on their first use.
            import_module(f"{NAME}.backends.backend_svg")
    except ImportError:
        raise
    except Exception as error:  # errors from a settings file have no common type
        raise InputError(
            f"cannot be imported with the settings of this machine: {error}",
            path=NAME,
            mend="Correct the file matplotlibrc, or the variables MATPLOTLIBRC, MPLBACKEND and LC_ALL of the environment",
        ) from error
    finally:
        log.setLevel(level)


if NAME not in sys.modules:
    _load()
