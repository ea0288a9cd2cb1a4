"""From kernels to the typed tree: statements, and one function for each combination of argument types of a kernel."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from bristle.core.dispatch import implementation_of, is_dispatch
from bristle.engine.translation import tree
from bristle.engine.translation.expressions import Expressions
from bristle.engine.translation.scope import (
    NotExportableError,
    ascii_name,
    definition_of,
    free_name,
)
from bristle.engine.translation.tree import INTEGER, REAL, VOID, Array, Struct, Type, walk

PASSES = 8  # a variable changes at most from truth to whole number to real number


class Translation(Expressions):
    """Translates one kernel for arguments of these types."""

    def __init__(self, builder: Builder, kernel: Callable[..., Any], types: Sequence[Type]) -> None:
        super().__init__(builder.constants, builder.function, kernel)
        self._argument_types, self._result, self._changed, self._count = (
            tuple(types),
            None,
            False,
            0,
        )
        self._used = set[str]()

    def function(self, name: str) -> tree.Function:
        """Return the kernel as a function of this name."""
        definition = definition_of(self.kernel)
        names = [argument.arg for argument in definition.args.args]
        self._used = {node.id for node in ast.walk(definition) if isinstance(node, ast.Name)}
        self.types = dict(zip(names, self._argument_types, strict=True))
        if node := _counter_outside(definition):
            raise self.refuse(node, f"the loop variable {node.id} is read outside its loop")
        body: list[tree.Statement] = []
        for _ in range(PASSES):
            self._changed, self._count = False, 0
            body = self._block(definition.body)
            if not self._changed:
                break
        result: Type = VOID if self._result is None else self._result
        if result != VOID and not _ends(definition.body):
            raise self.refuse(definition.body[-1], "does not return a value on every path")
        parameters = [tree.Variable(self.types[name], name) for name in names]
        writes = any(
            isinstance(part, tree.Store) or (isinstance(part, tree.Call) and part.function.writes)
            for part in walk(body)
        )
        description = (ast.get_docstring(definition) or "").split("\n", 1)[0]
        return tree.Function(name, self.kernel, parameters, result, body, description, writes)

    def _block(self, statements: Iterable[ast.stmt]) -> list[tree.Statement]:
        lines: list[tree.Statement] = []
        for node in statements:
            if isinstance(node, ast.Pass) or (
                isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
            ):
                continue
            translate = getattr(self, f"_do_{type(node).__name__.lower()}", None)
            if translate is None:
                raise self.refuse(
                    node, f"{type(node).__name__} is outside the exportable subset of Python"
                )
            lines += translate(node)
        return lines

    def _do_expr(self, node: ast.Expr) -> list[tree.Statement]:
        call = self.value(node.value)
        if not isinstance(call, tree.Call):
            raise self.refuse(node, "this expression has no effect")
        return [tree.Evaluate(call)]

    def _do_return(self, node: ast.Return) -> list[tree.Statement]:
        if node.value is None:
            return [tree.Return(None)]
        value = self.value(node.value)
        common = (
            value.type if self._result is None else self.unified(self._result, value.type, node)
        )
        self._changed |= common != self._result
        self._result = common
        return [tree.Return(self.coerced(value, common, node))]

    def _do_if(self, node: ast.If) -> list[tree.Statement]:
        return [tree.If(self.truth(node.test), self._block(node.body), self._block(node.orelse))]

    def _do_while(self, node: ast.While) -> list[tree.Statement]:
        if node.orelse:
            raise self.refuse(node, "a loop must not have else")
        return [tree.While(self.truth(node.test), self._block(node.body))]

    def _do_for(self, node: ast.For) -> list[tree.Statement]:
        counts = node.iter
        if not (
            isinstance(counts, ast.Call)
            and isinstance(counts.func, ast.Name)
            and counts.func.id == "range"
        ):
            raise self.refuse(node, "a for loop must run over range(...)")
        if node.orelse or not isinstance(node.target, ast.Name) or not 1 <= len(counts.args) <= 2:
            raise self.refuse(
                node, "a for loop must have one variable, a start and a stop, and no else"
            )
        bounds = [self.value(bound) for bound in counts.args]
        if any(bound.type != INTEGER for bound in bounds):
            raise self.refuse(node, "the arguments of range must be whole numbers")
        variable = self._variable(node.target.id, INTEGER, node)
        start = bounds[0] if len(bounds) == 2 else self.value(ast.Constant(0))
        return [tree.For(variable, start, bounds[-1], self._block(node.body))]

    def _do_break(self, node: ast.Break) -> list[tree.Statement]:
        return [tree.Break()]

    def _do_continue(self, node: ast.Continue) -> list[tree.Statement]:
        return [tree.Continue()]

    def _do_assign(self, node: ast.Assign) -> list[tree.Statement]:
        if len(node.targets) != 1:
            raise self.refuse(node, "an assignment must have one target: write two lines")
        return self._assigned(node.targets[0], node.value, node)

    def _do_annassign(self, node: ast.AnnAssign) -> list[tree.Statement]:
        return [] if node.value is None else self._assigned(node.target, node.value, node)

    def _do_augassign(self, node: ast.AugAssign) -> list[tree.Statement]:
        before: Any = node.target
        loaded = ast.copy_location(
            ast.Name(before.id, ast.Load())
            if isinstance(before, ast.Name)
            else ast.Subscript(before.value, before.slice, ast.Load()),
            node,
        )
        return self._stored(
            node.target,
            self.combined(node.op, self.value(loaded), self.value(node.value), node),
            node,
        )

    def _assigned(self, target: ast.expr, value: ast.expr, node: ast.stmt) -> list[tree.Statement]:
        if not isinstance(target, ast.Tuple):
            return self._stored(target, self.value(value), node)
        if isinstance(value, ast.Tuple) and len(value.elts) == len(target.elts):
            return self._one_by_one(target.elts, value.elts, node)
        value_tuple = self.value(value)
        if not isinstance(value_tuple.type, Struct) or len(value_tuple.type.fields) != len(
            target.elts
        ):
            raise self.refuse(
                node, f"an assignment to {len(target.elts)} names needs a tuple of the same length"
            )
        statements: list[tree.Statement] = []
        if not isinstance(value_tuple, tree.Variable):
            held = self._held(value_tuple.type, node)
            statements.append(tree.Assign(held, value_tuple))
            value_tuple = tree.Variable(held.type, held.name)
        assert isinstance(value_tuple.type, Struct)
        for part, (name, kind) in zip(target.elts, value_tuple.type.fields, strict=True):
            statements += self._stored(part, tree.Field(kind, value_tuple, name), node)
        return statements

    def _one_by_one(
        self, targets: list[ast.expr], values: list[ast.expr], node: ast.stmt
    ) -> list[tree.Statement]:
        """Return a simultaneous assignment, through temporary names if a value reads an earlier target."""
        into_arrays = any(not isinstance(target, ast.Name) for target in targets)
        later = [
            {
                part.id
                for value in values[k:]
                for part in ast.walk(value)
                if isinstance(part, ast.Name)
            }
            for k in range(1, len(values) + 1)
        ]
        looked_at = any(
            isinstance(target, ast.Name) and target.id in after
            for target, after in zip(targets, later, strict=True)
        )
        translated = [self.value(value) for value in values]
        statements: list[tree.Statement] = []
        if looked_at or (
            into_arrays and any(isinstance(part, tree.Index) for part in walk(*translated))
        ):
            for place, value in enumerate(translated):
                through = self._held(value.type, node)
                statements.append(tree.Assign(through, value))
                translated[place] = tree.Variable(through.type, through.name)
        return statements + [
            step
            for target, value in zip(targets, translated, strict=True)
            for step in self._stored(target, value, node)
        ]

    def _stored(
        self, target: ast.expr, value: tree.Expression, node: ast.stmt
    ) -> list[tree.Statement]:
        if isinstance(target, ast.Name):
            if target.id == "_":
                return (
                    [tree.Evaluate(value)]
                    if isinstance(value, tree.Call) and value.function.writes
                    else []
                )
            variable = self._variable(target.id, value.type, node)
            return [tree.Assign(variable, self.coerced(value, variable.type, node))]
        if not isinstance(target, ast.Subscript):
            raise self.refuse(node, f"cannot assign to {type(target).__name__}")
        array, at = self.value(target.value), self.value(target.slice)
        if not isinstance(array.type, Array) or at.type != INTEGER:
            raise self.refuse(
                node, "an indexed assignment needs an array and a whole number as its index"
            )
        if not array.type.writable:
            raise self.refuse(node, "writes to a read-only array: only commit may write to memory")
        return [tree.Store(array, at, self.coerced(value, REAL, node))]

    def _variable(self, name: str, kind: Type, node: ast.AST) -> tree.Variable:
        if kind == VOID:
            raise self.refuse(node, f"the call assigned to {name} has no result")
        common = self.unified(self.types[name], kind, node) if name in self.types else kind
        self._changed |= self.types.get(name) != common
        self.types[name] = common
        return tree.Variable(common, name)

    def _held(self, kind: Type, node: ast.AST) -> tree.Variable:
        self._count += 1
        while f"held_{self._count}" in self._used:
            self._count += 1
        return self._variable(f"held_{self._count}", kind, node)


@cache
def _counter_outside(definition: ast.FunctionDef) -> ast.Name | None:
    """Return a use of a loop variable after its loop, where its value differs between targets."""
    loops = [node for node in ast.walk(definition) if isinstance(node, ast.For)]
    inside = {id(node) for loop in loops for node in ast.walk(loop)}
    counted = {loop.target.id for loop in loops if isinstance(loop.target, ast.Name)}
    names = (
        node
        for node in ast.walk(definition)
        if isinstance(node, ast.Name) and id(node) not in inside
    )
    return next((node for node in names if node.id in counted), None)


def _ends(body: list[ast.stmt]) -> bool:
    last = body[-1]
    if isinstance(last, ast.If):
        return bool(last.orelse) and _ends(last.body) and _ends(last.orelse)
    endless = (
        isinstance(last, ast.While)
        and isinstance(last.test, ast.Constant)
        and bool(last.test.value)
    )
    return isinstance(last, ast.Return) or (
        endless and not any(isinstance(node, ast.Break) for node in ast.walk(last))
    )


FACE = frozenset(
    (
        *(
            "begun",
            "command",
            "effort",
            "example",
            "feed",
            "force",
            "force_at",
            "force_d",
            "friction",
            "initial",
            "inputs",
            "lane",
        ),
        *(
            "load",
            "output",
            "parameters",
            "save",
            "selftest",
            "start",
            "start_d",
            "step",
            "table",
            "tangent",
            "unit",
        ),
    )
)
"""Suffixes of the names of the functions and types of an export."""
DEEPEST = 100  # nested calls


@dataclass
class Builder:
    """Builds the functions of a unit on demand."""

    constants: dict[tuple[str, float], float] = field(default_factory=dict)
    unit: tree.Unit = field(default_factory=tree.Unit)

    def __post_init__(self) -> None:
        self._built: dict[tuple[Any, ...], tree.Function] = {}
        self._open: list[tuple[Any, ...]] = []
        self._names: set[str] = set()

    def function(self, called: Callable[..., Any], types: Sequence[Type]) -> tree.Function:
        """Return a kernel, or the choice of the dispatch, for arguments of these types."""
        kernel = called
        if is_dispatch(called):
            last = types[-1]
            kernel = implementation_of(called, last.cls) if isinstance(last, Struct) else None
            if kernel is None:
                name = last.cls.__qualname__ if isinstance(last, Struct) else "its arguments"
                raise NotExportableError(called, None, f"there is no kernel for {name}")
        key = (kernel, *types)
        if key not in self._built:
            # Nested models share one kernel, with different types at each level.
            if key in self._open or len(self._open) > DEEPEST:
                raise NotExportableError(
                    kernel, None, "calls itself, but recursion is outside the subset"
                )
            definition = definition_of(kernel)
            if len(definition.args.args) != len(types):
                raise NotExportableError(
                    kernel,
                    definition,
                    f"takes {len(definition.args.args)} arguments, not {len(types)}",
                )
            # An export may have the name of a module, and its own functions have suffixes of this name.
            module, own = (
                kernel.__module__.rpartition(".")[2],
                ascii_name(kernel.__name__.lstrip("_")),
            )
            name = f"{'own' if module.startswith('bristle_user_') else module}_{own}{'_kernel' * (own in FACE)}"
            name = free_name(name, self._names)
            self._names.add(name)
            self._open.append(key)
            try:
                self._built[key] = Translation(self, kernel, types).function(name)
            finally:
                self._open.pop()
            self.unit.functions.append(self._built[key])
        return self._built[key]
