"""Whether two things are the same to the last bit, whatever they are made of."""

import dataclasses
import enum
import types
from collections.abc import Mapping

import numpy as np

from bristle.core.contracts import Component


def bits_of(thing):
    """What a thing is made of, as something that ``==`` compares whole: arrays and numbers by their bits."""
    if isinstance(thing, Component):
        return Component, id(thing)
    if isinstance(thing, np.ndarray):
        return np.ndarray, thing.dtype.str, thing.shape, thing.tobytes()
    if isinstance(thing, (float, np.floating)):
        return type(thing), float(thing).hex()
    if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        return type(thing), {
            field.name: bits_of(getattr(thing, field.name)) for field in dataclasses.fields(thing)
        }
    if isinstance(thing, Mapping):
        return type(thing), [(key, bits_of(value)) for key, value in thing.items()]
    if isinstance(thing, (tuple, list)):
        return type(thing), [bits_of(field) for field in thing]
    if isinstance(thing, (types.FunctionType, enum.Enum, type)) or not hasattr(thing, "__dict__"):
        return thing
    return type(thing), {name: bits_of(value) for name, value in vars(thing).items()}
