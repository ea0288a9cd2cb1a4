"""What the functions inside of an identification were called with, and what they returned."""

from collections import defaultdict
from contextlib import contextmanager
from typing import Any, NamedTuple

import pytest


class Call(NamedTuple):
    """One call of a function."""

    given: tuple
    returned: Any


@contextmanager
def watched(*places):
    """Yield the calls of functions, by name; a place is the module that calls the function, and the name of the function there."""
    calls = defaultdict(list)

    def watching(name, function):
        def called(*given, **named):
            returned = function(*given, **named)
            calls[name].append(Call(given, returned))
            return returned

        return called

    with pytest.MonkeyPatch.context() as patch:
        for module, name in places:
            patch.setattr(module, name, watching(name, getattr(module, name)))
        yield calls
