"""Expressions of the tree as Python text, operation by operation, with identical results."""

import math
from collections.abc import Callable
from typing import Any

from bristle.core.exponent import exponent, mantissa, power_of_two
from bristle.engine.translation import tree
from bristle.engine.translation.scope import ascii_name, free_name
from bristle.engine.translation.tree import REAL, Struct

IN_PYTHON = {
    "copysign": "math.copysign",
    "floor": "math.floor",
    "isinf": "math.isinf",
    "isnan": "math.isnan",
    "sqrt": "math.sqrt",
}
PARTS = {"power_of_two": power_of_two, "mantissa": mantissa, "exponent": exponent}


class PythonText:
    """Prints expressions, and collects their kernels and classes in a `scope`."""

    def __init__(self, scope: dict[str, Any]) -> None:
        self.scope = scope

    def name_of(self, value: Callable[..., Any], name: str) -> str:
        """Return the name of a kernel or a class in the text."""
        for used, held in self.scope.items():
            if held is value:
                return used
        free = free_name(ascii_name(name), self.scope)
        self.scope[free] = value
        return free

    def plain(self, node: tree.Expression) -> str:
        """Return the text of a value without its tangent."""
        match node:
            case tree.Constant(value=float(number)) if not math.isfinite(number):
                return f"({'-' * (number < 0.0)}math.{'nan' if math.isnan(number) else 'inf'})"
            case tree.Constant():
                return repr(node.value)
            case tree.Variable():
                return node.name
            case tree.Field():
                return part_of(self.plain(node.of), node)
            case tree.Index():
                return f"{self.plain(node.array)}[{self.plain(node.at)}]"
            case tree.Negative():
                return f"(-{self.plain(node.of)})"
            case tree.Not():
                return f"(not {self.plain(node.of)})"
            case tree.Binary() | tree.Compare():
                return f"({self.plain(node.left)} {node.operator} {self.plain(node.right)})"
            case tree.Logic():
                return "(" + f" {node.operator} ".join(map(self.plain, node.parts)) + ")"
            case tree.Select():
                return f"({self.plain(node.first)} if {self.plain(node.test)} else {self.plain(node.second)})"
            case tree.Convert():
                return f"{'float' if node.type == REAL else 'int'}({self.plain(node.of)})"
            case tree.Call():
                return f"{self.kernel(node.function.source)}({', '.join(map(self.plain, node.arguments))})"
            case tree.Intrinsic():
                return self.intrinsic(node, list(map(self.plain, node.arguments)))
            case tree.Make():
                return self.tuple_text(node, list(map(self.plain, node.parts)))
        raise AssertionError(node)

    def kernel(self, source: Callable[..., Any]) -> str:
        """Return the name of a kernel."""
        return self.name_of(source, f"of_{source.__name__}")

    def intrinsic(self, node: tree.Intrinsic, values: list[str]) -> str:
        """Return the text of an operation that every target computes exactly."""
        if node.name == "size":
            return f"{values[0]}.size"
        if node.name in PARTS:
            return f"{self.name_of(PARTS[node.name], node.name)}({values[0]})"
        return f"{IN_PYTHON.get(node.name, node.name)}({', '.join(values)})"

    def tuple_text(self, node: tree.Make, values: list[str]) -> str:
        """Return the text of a tuple of these values."""
        assert isinstance(node.type, Struct)
        if node.type.is_plain:
            return f"({', '.join(values)},)"
        maker = self.name_of(node.type.cls, f"a_{node.type.cls.__name__}")
        return f"{maker}({', '.join(values)})"


def part_of(of: str, node: tree.Field) -> str:
    """Return the text of a field of a tuple."""
    assert isinstance(node.of.type, Struct)
    return (
        f"{of}[{node.of.type.place(node.name)}]" if node.of.type.is_plain else f"{of}.{node.name}"
    )
