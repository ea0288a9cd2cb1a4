"""Identification of an axis whose coupling is known: the search for an elastic load takes most of the time of a small fit."""

import importlib
from typing import Any
from unittest.mock import patch

from bristle import identification
from bristle.identification.elasticity import Elastic

IDENTIFYING = importlib.import_module("bristle.identification.identify")


def identify(*arguments: Any, coupling: Elastic | None = None, **requested: Any) -> identification.Identification:
    """Identify as bristle does, but without looking for an elastic load: the axis is rigid unless its coupling is given."""
    with patch.object(IDENTIFYING, "elastic_coupling", return_value=coupling):
        return identification.identify(*arguments, **requested)
