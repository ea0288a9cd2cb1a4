"""The components of a package by name."""

import sys
from collections.abc import Iterator, Mapping
from typing import TypeVar

from bristle.core import Component, cached_property
from bristle.core.loading import places

C = TypeVar("C", bound=Component, covariant=True)


class Family(Mapping[str, C]):
    """The components that a package offers, each imported from the module of its name at first use.

    `functions` have modules of their names, and are no components.
    """

    def __init__(self, package: str, *functions: str) -> None:
        self._package = package
        self._functions = functions

    @cached_property
    def _names(self) -> dict[str, str]:
        return {
            name: name
            for name, place in places(self._package).items()
            if place == (f"{self._package}.{name}", name) and name not in self._functions
        }

    def __getitem__(self, name: str) -> C:
        return getattr(sys.modules[self._package], self._names[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
