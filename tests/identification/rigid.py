"""Identification of an axis whose coupling is known: the search for an elastic load takes most of the time of a small fit."""

import importlib
from collections.abc import Callable
from typing import Any
from unittest.mock import Mock, patch

from bristle import identification
from bristle.identification.dataset import Alignment
from bristle.identification.elasticity import Elastic

IDENTIFYING = importlib.import_module("bristle.identification.identify")


def identify(
    *arguments: Any,
    coupling: Elastic | None = None,
    alignment: Alignment | None = None,
    by: Callable = identification.identify,
    **requested: Any,
) -> Any:
    """Identify as bristle does, but without looking for an elastic load, nor for the alignment if it is given."""
    known = {"elastic_coupling": Mock(return_value=coupling)} | (
        {"alignment_of": Mock(return_value=alignment)} if alignment else {}
    )
    with patch.multiple(IDENTIFYING, **known):
        return by(*arguments, **requested)
