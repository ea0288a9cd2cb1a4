"""Names in C: of structures, and of variables that would mean something else there."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from bristle.exports.types import Struct

__all__ = ["RESERVED", "Names"]

WORDS_OF_C = """
auto break case char const continue default do double else enum extern float for goto if inline int long
register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
bool true false class new delete this template operator private public near far
"""
DEFINED = """
root with_sign magnitude next_below is_infinite is_nan is_finite least greatest mantissa_of exponent_of power_of_two
whole_magnitude whole_least whole_greatest floor_divided floor_rest
"""
RESERVED = frozenset((WORDS_OF_C + DEFINED).split())
"""What a variable is not called: keywords of C and C++, macros of a system, and what a unit defines itself."""


class Names:
    """The names of the structures of a unit, each its own: that of its class, behind its module where there are two."""

    def __init__(self, structures: Sequence[Struct]) -> None:
        counted = Counter(kind.cls.__name__ for kind in structures)
        self.structures: dict[Struct, str] = {}
        used: set[str] = set()
        for kind in structures:
            first = "Several" if kind.is_plain else kind.cls.__name__
            if counted[first] > 1 and not kind.is_plain:
                first = _camel(kind.cls.__module__.rpartition(".")[2]) + first
            name, count = first, 1
            while name in used:
                count += 1
                name = f"{first}_{count}"
            used.add(name)
            self.structures[kind] = name

    def variable(self, name: str) -> str:
        """Return a name for a variable, an argument or a field."""
        if name in RESERVED:
            return f"{name}_"
        return f"part{name}" if name.startswith("_") else name


def _camel(module: str) -> str:
    return "Own" if module.startswith("bristle_user_") else "".join(part.capitalize() for part in module.split("_"))
