"""Applications beside the rooms: each brings its command, its pages and its figures.

An app imports public names of rooms, and of other apps only what `pyproject.toml` lists. No room imports an app.
"""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.apps import arm, design, lab, paper, study, targets, tune

__getattr__ = loaded_from(__name__)
