"""With this module matplotlib is imported, without its remarks on the settings of its user.

These figures do not depend on them (`bristle.figures.drawing`). A setting with which the import fails raises an `InputError`.
"""

import logging
import sys
import warnings
from importlib import import_module

from bristle.core import InputError

__all__: list[str] = []

NAME = "matplotlib"


def _load() -> None:
    """Import matplotlib with the settings of its user, for figures of theirs; without remarks on them."""
    log = logging.getLogger(NAME)
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            # On folders, fonts and what it is built upon it remarks once it looks for them.
            import_module(f"{NAME}.backends.backend_svg")
    except ImportError:
        raise
    except Exception as error:  # what a file of settings can do to the import has no common type
        mend = "Correct the file matplotlibrc, or the variables MATPLOTLIBRC, MPLBACKEND and LC_ALL of the environment"
        raise InputError(f"cannot be imported with its settings here: {error}", path=NAME, mend=mend) from error
    finally:
        log.setLevel(level)


if NAME not in sys.modules:
    _load()
