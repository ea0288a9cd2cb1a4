"""What a model is, in a few letters: two are the same where these are."""

from __future__ import annotations

import hashlib
from typing import Any

from bristle.core.contracts import Model

__all__ = ["digest"]

LETTERS = 16
CHANCE = ("seed",)  # what differs between two runs of one thing


def digest(model: Model) -> str:
    """Return the first letters of a checksum over name and values of a model; the seed of its scatter is left out."""
    values = sorted((name, _plain(value)) for name, value in model.values.items() if name not in CHANCE)
    return hashlib.sha256(repr((model.name, model.kind, values)).encode()).hexdigest()[:LETTERS]


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value
