"""Names in C: of structures, and of variables that would mean something else there."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence

from bristle.exports.types import Struct

__all__ = ["RESERVED", "Names", "ascii_name"]

WORDS_OF_C = """
alignas alignof asm auto bool break case char const constexpr continue default do double else enum extern false float
for goto if inline int long nullptr register restrict return short signed sizeof static static_assert struct switch
thread_local true typedef typeof typeof_unqual union unsigned void volatile while
"""
WORDS_OF_CPP = """
and and_eq bitand bitor catch char16_t char32_t char8_t class co_await co_return co_yield compl concept const_cast
consteval constinit decltype delete dynamic_cast explicit export friend mutable namespace new noexcept not not_eq
operator or or_eq private protected public reinterpret_cast requires static_cast template this throw try typeid typename
using virtual wchar_t xor xor_eq
"""
# Macros of the headers that an export includes, beside those that MACROS finds by how they begin, and of compilers.
MACROS_BY_NAME = """
BIG_ENDIAN BYTE_ORDER DECIMAL_DIG FD_SETSIZE HUGE_VAL HUGE_VALF HUGE_VALL INFINITY LITTLE_ENDIAN MAXFLOAT MB_CUR_MAX
NAN NFDBITS NULL PDP_ENDIAN RAND_MAX WCONTINUED WEXITED WNOHANG WNOWAIT WSTOPPED WUNTRACED errno far fd_set linux
main math_errhandling near physadr quad signgam strtodf unix
"""
MACROS = re.compile(
    r"(DBL|DEC\d*|EXIT|FLT|FP|INT|INT_\w+|INT\d+|INTMAX|INTPTR|LDBL|MATH|PTRDIFF|PTHREAD|SCHED|SIG_ATOMIC|SIZE|UINT_\w+"
    r"|UINT\d+|UINTMAX|UINTPTR|WCHAR|WINT)_[A-Z0-9_]+|M_(E|LOG\w+|LN\w+|IVLN\w+|INVLN\w+|SQRT\w+|TWOPI|\w*PI(_[24])?)"
)
DEFINED = """
ABSORBED Bits root with_sign magnitude next_below is_infinite is_nan is_finite least greatest mantissa_of exponent_of
power_of_two whole_magnitude whole_least whole_greatest floor_divided floor_rest
"""
RESERVED = frozenset((WORDS_OF_C + WORDS_OF_CPP + MACROS_BY_NAME + DEFINED).split())
"""What nothing is called: keywords of C and C++, macros of a system, and what a unit defines itself."""


class Names:
    """The names of the structures of a unit, each its own: that of its class, behind its module where there are two."""

    def __init__(self, structures: Sequence[Struct], functions: Iterable[str] = ()) -> None:
        counted = Counter(kind.cls.__name__ for kind in structures)
        self.structures: dict[Struct, str] = {}
        self._functions = frozenset(functions)
        used = {*RESERVED, *self._functions}
        for kind in structures:
            first = "Several" if kind.is_plain else kind.cls.__name__
            if counted[first] > 1 and not kind.is_plain:
                first = _camel(kind.cls.__module__.rpartition(".")[2]) + first
            first = ascii_name(first)
            name, count = first, 1
            while name in used:
                count += 1
                name = f"{first}_{count}"
            used.add(name)
            self.structures[kind] = name

    def variable(self, name: str) -> str:
        """Return a name for a variable, an argument or a field: two names stay two, capitals are a difference."""
        plain = name.rstrip("_")
        if plain in RESERVED or name in self._functions or MACROS.fullmatch(plain):
            return f"{name}_"
        return f"part{name}" if name.startswith("_") else ascii_name(name)


def ascii_name(name: str) -> str:
    """Return a name of Python in letters that every language takes: others by their number."""
    return re.sub(r"\W", lambda letter: f"u{ord(letter[0]):04X}", name, flags=re.ASCII)


def _camel(module: str) -> str:
    return "Own" if module.startswith("bristle_user_") else "".join(part.capitalize() for part in module.split("_"))
