"""Structured Text, read by the grammar of tree-sitter and translated to C as strictly as the standard is read anywhere.

Independent of bristle: how text becomes a tree (words, precedence, which operand is left), from the package
``tree-sitter-iec61131-3-st``. Written here, after IEC 61131-3: what the tree means. Nothing is converted by itself,
both sides of AND and OR are computed, inputs cannot be written, an index outside of its array, a whole number that
overflows, a conversion out of range and a loop without end stop the program, and so do a division by zero, an
overflow and an invalid operation of real numbers, as they do on controllers that watch for them.
"""

import ctypes

import numpy as np
import pytest
from tests.exports.native import library

FLAGS = (
    "-std=gnu99",
    "-O0",
    "-ffp-contract=off",
    "-ftrapv",
    "-frounding-math",
    "-Wall",
    "-Wextra",
    "-Werror",
)
C_TYPES = {
    "lreal": "double",
    "real": "float",
    "dint": "int32_t",
    "lint": "int64_t",
    "bool": "bool",
    "lword": "uint64_t",
}
SECTIONS = {
    "var_input": "input",
    "var_output": "output",
    "var_in_out": "in_out",
    "var_block": "own",
}
CONVERTED = {
    "dint_to_lreal": ("dint", "lreal"),
    "lint_to_lreal": ("lint", "lreal"),
    "lreal_to_dint": ("lreal", "dint"),
    "lreal_to_lint": ("lreal", "lint"),
    "lint_to_dint": ("lint", "dint"),
    "lint_to_lword": ("lint", "lword"),
    "lword_to_lint": ("lword", "lint"),
    "dint_to_real": ("dint", "real"),
    "lint_to_real": ("lint", "real"),
    "real_to_dint": ("real", "dint"),
    "real_to_lint": ("real", "lint"),
    "real_to_lreal": ("real", "lreal"),
    "lreal_to_real": ("lreal", "real"),
}
ROOTS = {"lreal": "sqrt", "real": "sqrtf"}
HEAD = """
#define _GNU_SOURCE
#include <fenv.h>
#include <math.h>
#include <setjmp.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
static jmp_buf stopped;
static int why;
static inline void stop(int reason) { why = reason; longjmp(stopped, 1); }
static inline int64_t place(int64_t at, int64_t size) { if (at < 0 || at >= size) { stop(2); } return at; }
static inline int64_t divided(int64_t a, int64_t b) { if (b == 0) { stop(3); } return a / b; }
static inline int64_t rest(int64_t a, int64_t b) { if (b == 0) { stop(3); } return a % b; }
static inline double whole_of(double x, double most)
{
    const double cut = ROUNDED(x);
    if (!(cut >= -most && cut < most)) { stop(4); }
    return cut;
}
static inline int32_t lreal_to_dint(double x) { return (int32_t)whole_of(x, 2147483648.0); }
static inline int64_t lreal_to_lint(double x) { return (int64_t)whole_of(x, 9223372036854775808.0); }
static inline int32_t real_to_dint(float x) { return lreal_to_dint(x); }
static inline int64_t real_to_lint(float x) { return lreal_to_lint(x); }
static inline float dint_to_real(int32_t x) { return (float)x; }
static inline float lint_to_real(int64_t x) { return (float)x; }
static inline double real_to_lreal(float x) { return x; }
static inline float lreal_to_real(double x) { return (float)x; }
static inline double dint_to_lreal(int32_t x) { return x; }
static inline double lint_to_lreal(int64_t x) { return (double)x; }
static inline int32_t lint_to_dint(int64_t x) { if (x != (int32_t)x) { stop(4); } return (int32_t)x; }
static inline uint64_t lint_to_lword(int64_t x) { return (uint64_t)x; }
static inline int64_t lword_to_lint(uint64_t x) { return (int64_t)x; }
static inline void round_of(int *rounds) { if (++*rounds > 100000) { stop(5); } }
static void on_signal(int signal) { (void)signal; stop(1); }
#include <signal.h>
static int watched(void (*body)(void *), void *given)
{
    signal(SIGFPE, on_signal);
    signal(SIGABRT, on_signal);
    feclearexcept(FE_ALL_EXCEPT);
    why = 0;
    if (setjmp(stopped) == 0) { feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW); body(given); }
    fedisableexcept(FE_ALL_EXCEPT);
    sigset_t all;
    sigfillset(&all);
    sigprocmask(SIG_UNBLOCK, &all, NULL);
    return why;
}
"""
DRIVER = """
typedef struct {{ int count; const double *inputs; const int *commands; double *force; int *flags; }} Given_{name};
static void drive_{name}(void *handed)
{{
    Given_{name} *given = handed;
    const double *in = given->inputs;
    static {block} axis;
    {block}_virgin(&axis);
    for (int i = 0; i < given->count; ++i) {{
        {set}
        axis.v_restart = (given->commands[i] & 1) != 0;
        axis.v_clear = (given->commands[i] & 2) != 0;
        call_{block}(&axis);
        given->force[i] = axis.{output};
        given->flags[i] = axis.v_refused + 2 * axis.v_overflow;
    }}
}}
int run_{name}(int count, const double *inputs, const int *commands, double *force, int *flags)
{{
    Given_{name} given = {{count, inputs, commands, force, flags}};
    return watched(drive_{name}, &given);
}}
"""
TESTED = """
static void drive_{name}_selftest(void *handed)
{{
    int *found = handed;
    static {block}_selftest test;
    {block}_selftest_virgin(&test);
    for (int i = 0; i < 1000 && !test.v_done; ++i) {{
        call_{block}_selftest(&test);
    }}
    *found = test.v_done + 2 * test.v_passed;
}}
int run_{name}_selftest(int *found)
{{
    return watched(drive_{name}_selftest, found);
}}
"""


class StandardError(Exception):
    """The text is not what the standard allows, or not what is read here."""


def parsed(text):
    """Return the tree of a text; raise where the grammar does not take it."""
    # The grammar is built with a C compiler, which a user may not have.
    needed = ("tree_sitter_iec61131_3_st", "tree_sitter")
    grammar, tree_sitter = (
        pytest.importorskip(name, reason="needs the grammar of Structured Text for tree-sitter")
        for name in needed
    )
    parser = tree_sitter.Parser(tree_sitter.Language(grammar.language()))
    root = parser.parse(text.encode()).root_node
    if root.has_error:
        raise StandardError(f"the grammar refuses it: {_first_fault(root)}")
    return root


def _first_fault(node):
    for child in node.children:
        if child.type == "ERROR" or child.is_missing:
            return f"line {child.start_point[0] + 1}: {child.text.decode()[:80]!r}"
        if child.has_error:
            return _first_fault(child)
    return node.type


def words(node):
    """Return the text of a part, in small letters: capitals are no difference."""
    return node.text.decode().lower()


def named(node, kind=None):
    """Return the named parts inside a part, comments left out."""
    return [
        c for c in node.named_children if c.type != "comment" and (kind is None or c.type == kind)
    ]


class Unit:
    """A function, a function block or a program."""

    def __init__(self, node, kind):
        self.node, self.kind = node, kind
        self.name = words(node.child_by_field_name("name"))
        returns = node.child_by_field_name("return_type")
        self.returns = words(returns) if returns else None
        self.sections, self.types, self.initial = {}, {}, {}
        for section, way in SECTIONS.items():
            for block in named(node, section):
                for declaration in named(block, "variable_declaration"):
                    self._declare(declaration, way)

    def _declare(self, declaration, way):
        initial = declaration.child_by_field_name("initial_value")
        for name in declaration.children_by_field_name("names"):
            if not name.is_named:  # the comma between two names
                continue
            key = words(name)
            if key in self.types or key == self.name:
                raise StandardError(f"{self.name}: {key} is declared twice")
            self.sections[key], self.types[key] = (
                way,
                words(declaration.child_by_field_name("type")),
            )
            if initial is not None:
                self.initial[key] = initial

    def of(self, way):
        return [name for name, section in self.sections.items() if section == way]


class Translator:
    """Translates files that belong together to C."""

    def __init__(self, *texts):
        self.arrays, self.records, self.units, self.out = {}, {}, {}, []
        for text in texts:
            for node in named(parsed(text)):
                self._collect(node)

    def _collect(self, node):
        if node.type == "type_declaration":
            for definition in named(node, "type_definition"):
                self._type(definition)
            return
        kinds = {"function": "function", "function_block": "block", "program": "block"}
        kind = kinds.get(node.type.removesuffix("_declaration"))
        if node.type == "empty_statement":
            return
        if kind is None:
            raise StandardError(f"{node.type} at the top")
        unit = Unit(node, kind)
        if unit.name in self.units or unit.name in self.arrays or unit.name in self.records:
            raise StandardError(f"{unit.name} is there twice")
        self.units[unit.name] = unit
        for kind in [*unit.types.values(), *([unit.returns] if unit.returns else [])]:
            self._known(kind)
        self.out.append(self._function(unit) if unit.kind == "function" else self._block(unit))

    def _known(self, kind):
        if (
            kind not in C_TYPES
            and kind not in self.arrays
            and kind not in self.records
            and kind not in self.units
        ):
            raise StandardError(f"{kind} is not declared before it is used")

    def _type(self, definition):
        name, inside = (
            words(definition.child_by_field_name("name")),
            definition.child_by_field_name("definition"),
        )
        if name in self.arrays or name in self.records:
            raise StandardError(f"{name} is there twice")
        if inside.type == "array_type":
            span = inside.child_by_field_name("range")
            low, high = (int(words(span.child_by_field_name(end))) for end in ("lower", "upper"))
            element = words(inside.child_by_field_name("element_type"))
            assert low == 0, "arrays begin at 0 here"
            self.arrays[name] = (high + 1, element)
            self.out.append(
                f"typedef struct {{ {C_TYPES[element]} at[{high + 1}]; }} {_kind(name)};"
            )
            return
        fields = {}
        for field in named(inside, "structure_field"):
            key, kind = (
                words(field.child_by_field_name("name")),
                words(field.child_by_field_name("type")),
            )
            self._known(kind)
            if key in fields:
                raise StandardError(f"{name}.{key} is there twice")
            fields[key] = kind
        if not fields:
            raise StandardError(f"{name} holds nothing")
        self.records[name] = fields
        inner = " ".join(f"{_kind(kind)} {_c(key)};" for key, kind in fields.items())
        self.out.append(f"typedef struct {{ {inner} }} {_kind(name)};")

    def _function(self, unit):
        body = Statements(self, unit)
        values = [f"{_kind(unit.types[n])} {_c(n)}" for n in unit.of("input")]
        values += [f"{_kind(unit.types[n])} *{_c(n)}" for n in unit.of("in_out")]
        custom = [
            f"    {_kind(unit.types[n])} {_c(n)}; memset(&{_c(n)}, 0, sizeof {_c(n)});"
            for n in unit.of("own")
        ]
        result = C_TYPES[unit.returns]
        return "\n".join(
            [
                f"static {result} {_kind(unit.name)}({', '.join(values)})",
                "{",
                f"    {result} own_result = 0;",
                *custom,
                *body.lines(),
                "    goto end;",
                "end:",
                "    return own_result;",
                "}",
            ]
        )

    def _block(self, unit):
        body = Statements(self, unit)
        fields = " ".join(f"{_kind(kind)} {_c(name)};" for name, kind in unit.types.items())
        begin = [
            f"    self->{_c(name)} = {Statements(self, unit).value(node)[0]};"
            for name, node in unit.initial.items()
        ]
        begin += [
            f"    {_kind(kind)}_virgin(&self->{_c(name)});"
            for name, kind in unit.types.items()
            if kind in self.units
        ]
        return "\n".join(
            [
                f"typedef struct {{ {fields} }} {_kind(unit.name)};",
                f"static void {_kind(unit.name)}_virgin({_kind(unit.name)} *self)",
                "{",
                "    memset(self, 0, sizeof *self);",
                *begin,
                "}",
                f"static void call_{_kind(unit.name)}({_kind(unit.name)} *self)",
                "{",
                *body.lines(),
                "    goto end;",
                "end:",
                "    return;",
                "}",
            ]
        )

    def text(self):
        """Return what is C of all of it."""
        return "\n".join(self.out)


class Statements:
    """Translates the body of one unit."""

    def __init__(self, translator, unit):
        self.translator, self.unit, self.count = translator, unit, 0

    def lines(self):
        """Return the lines of the body."""
        return [
            line
            for node in self.unit.node.children_by_field_name("body")
            for line in self._of(node)
        ]

    def _fail(self, node, reason):
        raise StandardError(
            f"{self.unit.name}, line {node.start_point[0] + 1}: {reason}: {node.text.decode()[:90]}"
        )

    def _of(self, node):
        if node.type in ("empty_statement", "comment"):
            return []
        return getattr(self, f"_{node.type}")(node)

    def _inside(self, nodes):
        return [line for node in nodes for line in self._of(node)]

    def _assignment_statement(self, node):
        left, kind = self.place(node.child_by_field_name("left"), written=True)
        right, values = self.value(node.child_by_field_name("right"), kind)
        if kind != values:
            self._fail(node, f"a {values} for a {kind}")
        return [f"{left} = {right};"]

    def _if_statement(self, node):
        lines = [f"if ({self.truth(node.child_by_field_name('condition'))}) {{"]
        lines += self._inside(node.children_by_field_name("consequence"))
        ends = 1
        for clause in named(node):
            if clause.type in ("elsif_clause", "elseif_clause"):
                lines += [
                    "} else {",
                    f"if ({self.truth(clause.child_by_field_name('condition'))}) {{",
                ]
                parts = clause.children_by_field_name("body") or clause.children_by_field_name(
                    "consequence"
                )
                lines += self._inside(parts)
                ends += 1
            elif clause.type == "else_clause":
                lines += ["} else {", *self._inside(clause.children_by_field_name("body"))]
        return [*lines, *["}"] * ends]

    def _for_statement(self, node):
        counter, kind = self.place(node.child_by_field_name("control"), written=True)
        start, end = (self.value(node.child_by_field_name(part), kind) for part in ("start", "end"))
        if (
            not kind == start[1] == end[1]
            or kind not in ("dint", "lint")
            or node.child_by_field_name("step")
        ):
            self._fail(node, "a loop counts whole numbers of one type")
        self.count += 1
        last = f"last_{self.count}"
        head = f"for ({counter} = {start[0]}; {counter} <= {last}; ++{counter}) {{"
        return [
            f"{{ const {C_TYPES[kind]} {last} = {end[0]};",
            head,
            *self._inside(node.children_by_field_name("body")),
            "} }",
        ]

    def _while_statement(self, node):
        self.count += 1
        rounds = f"rounds_{self.count}"
        head = (
            f"while ({self.truth(node.child_by_field_name('condition'))}) {{ round_of(&{rounds});"
        )
        return [
            f"{{ int {rounds} = 0;",
            head,
            *self._inside(node.children_by_field_name("body")),
            "} }",
        ]

    def _exit_statement(self, node):
        return ["break;"]

    def _return_statement(self, node):
        return ["goto end;"]

    def _invocation_statement(self, node):
        call = named(node)[0]
        name = words(call.child_by_field_name("function"))
        kind = self.unit.types.get(name)
        if kind not in self.translator.units:
            self._fail(node, "only a block is called by itself")
        block, at = self.translator.units[kind], f"self->{_c(name)}"
        lines = []
        for argument in named(call.child_by_field_name("arguments")):
            key = words(argument.child_by_field_name("name"))
            if block.sections.get(key) != "input":
                self._fail(node, f"{key} is no input")
            text, values = self.value(argument.child_by_field_name("value"), block.types[key])
            if values != block.types[key]:
                self._fail(node, f"a {values} for {key}")
            lines.append(f"{at}.{_c(key)} = {text};")
        return [*lines, f"call_{_kind(kind)}(&{at});"]

    # --- where things are -----------------------------------------------------------------------------------------

    def place(self, node, *, written=False):
        """Return where something is, and its type."""
        if node.type == "identifier":
            return self._variable(node, written=written)
        if node.type == "member_access_expression":
            of, kind = self.place(node.child_by_field_name("object"), written=written)
            key = words(node.child_by_field_name("member"))
            if kind in self.translator.units:
                block = self.translator.units[kind]
                if written or block.sections.get(key) != "output":
                    self._fail(node, "only outputs of a block are seen")
                return f"{of}.{_c(key)}", block.types[key]
            if key not in self.translator.records.get(kind, {}):
                self._fail(node, f"a {kind} has no {key}")
            return f"{of}.{_c(key)}", self.translator.records[kind][key]
        if node.type == "index_expression":
            of, kind = self.place(node.child_by_field_name("object"), written=written)
            at = [c for c in node.children_by_field_name("index") if c.is_named]
            if kind not in self.translator.arrays or len(at) != 1:
                self._fail(node, f"a {kind} has no places")
            size, element = self.translator.arrays[kind]
            index, index_kind = self.value(at[0], "dint")
            if index_kind != "dint":
                self._fail(node, f"a place is no {index_kind}")
            return f"{of}.at[place({index}, {size})]", element
        self._fail(node, "is no variable")
        return None

    def _variable(self, node, *, written):
        name, unit = words(node), self.unit
        if name == unit.name and unit.returns:
            return "own_result", unit.returns
        if name not in unit.types:
            self._fail(node, "is not declared")
        if written and unit.sections[name] == "input":
            self._fail(node, "an input is written")
        if unit.kind == "block":
            return f"self->{_c(name)}", unit.types[name]
        return (f"(*{_c(name)})" if unit.sections[name] == "in_out" else _c(name)), unit.types[name]

    # --- values ---------------------------------------------------------------------------------------------------

    def truth(self, node):
        """Return a condition."""
        text, kind = self.value(node)
        if kind != "bool":
            self._fail(node, f"a {kind} is no condition")
        return text

    def value(self, node, wanted=None):
        """Return a value and its type; a whole number that is written takes the type that is wanted."""
        if node.type == "parenthesized_expression":
            text, kind = self.value(named(node)[0], wanted)
            return f"({text})", kind
        if node.type == "real_literal":
            return f"({words(node)})", "lreal"
        if node.type == "integer_literal":
            return (
                (f"INT64_C({words(node)})", "lint") if wanted == "lint" else (words(node), "dint")
            )
        if node.type == "typed_literal":
            kind, _, digits = words(node).partition("#")
            if kind not in ("lint", "real") or (kind == "real") != ("." in digits):
                self._fail(node, "is a literal that is not read here")
            return (f"INT64_C({digits})", kind) if kind == "lint" else (f"({digits}f)", kind)
        if node.type == "boolean_literal":
            return words(node), "bool"
        if node.type in ("identifier", "member_access_expression", "index_expression"):
            return self.place(node)
        return getattr(self, f"_{node.type}")(node, wanted)

    def _unary_expression(self, node, wanted):
        text, kind = self.value(node.child_by_field_name("operand"), wanted)
        operator = words(node.child_by_field_name("operator"))
        if kind not in {"not": ("bool",), "-": ("lreal", "real", "dint", "lint")}[operator]:
            self._fail(node, f"{operator} of a {kind}")
        return f"({'!' if operator == 'not' else '-'}{text})", kind

    def _binary_expression(self, node, wanted):
        operator = words(node.child_by_field_name("operator"))
        sides = [node.child_by_field_name(side) for side in ("left", "right")]
        kinds = [self.value(side, wanted)[1] for side in sides]
        inner = "lint" if "lint" in kinds else None
        (left, first), (right, second) = (self.value(side, inner) for side in sides)
        if first != second:
            self._fail(node, f"{operator} of a {first} and a {second}")
        if operator in ("and", "or", "xor"):
            if first not in ("bool", "lword"):
                self._fail(node, f"{operator} of a {first}")
            return (
                f"({left} {dict(zip(('and', 'or', 'xor'), '&|^', strict=True))[operator]} {right})",
                first,
            )
        if operator in ("=", "<>", "<", ">", "<=", ">="):
            if first not in C_TYPES or (first == "bool" and operator not in ("=", "<>")):
                self._fail(node, f"{operator} of a {first}")
            return f"({left} {({'=': '==', '<>': '!='}).get(operator, operator)} {right})", "bool"
        reals = ("lreal", "real")
        if first not in (*reals, "dint", "lint") or (operator == "mod" and first in reals):
            self._fail(node, f"{operator} of a {first}")
        if operator == "mod" or (operator == "/" and first not in reals):
            return (
                f"(({C_TYPES[first]}){'rest' if operator == 'mod' else 'divided'}({left}, {right}))",
                first,
            )
        if operator not in ("+", "-", "*", "/"):
            self._fail(node, operator)
        return f"({left} {operator} {right})", first

    def _call_expression(self, node, wanted):
        name = words(node.child_by_field_name("function"))
        values = named(node.child_by_field_name("arguments"))
        if name == "sqrt" and len(values) == 1:
            text, kind = self.value(values[0])
            if kind not in ROOTS:
                self._fail(node, f"sqrt of a {kind}")
            return f"{ROOTS[kind]}({text})", kind
        if name in CONVERTED:
            takes, gives = CONVERTED[name]
            text, kind = self.value(values[0], takes)
            if kind != takes or len(values) != 1:
                self._fail(node, f"{name} of a {kind}")
            return f"{name}({text})", gives
        function = self.translator.units.get(name)
        if function is None or function.kind != "function" or function is self.unit:
            self._fail(node, "is no function that was defined before")
        return (
            f"{_kind(name)}({', '.join(self._arguments(node, function, values))})",
            function.returns,
        )

    def _arguments(self, node, function, values):
        if any(argument.type != "named_argument" for argument in values):
            self._fail(node, "arguments are named here")
        handed = {
            words(a.child_by_field_name("name")): a.child_by_field_name("value") for a in values
        }
        expected = [*function.of("input"), *function.of("in_out")]
        if len(handed) != len(values) or set(handed) != set(expected):
            self._fail(node, f"{function.name} takes {expected}")
        texts, places = [], {}
        for key in expected:
            is_place = function.sections[key] == "in_out"
            text, kind = (
                self.place(handed[key])
                if is_place
                else self.value(handed[key], function.types[key])
            )
            if kind != function.types[key]:
                self._fail(node, f"a {kind} for {key}")
            places |= {key: text} if is_place else {}
            texts.append(f"&{text}" if is_place else text)
        result = places.pop("given_back", None)
        if result is not None and any(_overlap(result, other) for other in places.values()):
            self._fail(node, "what is given back lies in what is handed over")
        return texts


def _overlap(first, second):
    return f"{first}.".startswith(f"{second}.") or f"{second}.".startswith(f"{first}.")


def _kind(name):
    return C_TYPES.get(name, f"t_{name}")


def _c(name):
    return f"v_{name}"


class StructuredText:
    """Models, by the name of their block, each a text and that of its self-test, compiled into one library."""

    def __init__(self, models, folder, *, rounded="nearbyint", flags=(), outputs=None):
        folder.mkdir(exist_ok=True)
        self.inputs = {}
        for name, texts in models.items():
            translated = Translator(*texts)
            unit, put, self.inputs[name], width = translated.units[name], [], [], 0
            for key in unit.of("input"):
                size, _ = translated.arrays.get(unit.types[key], (0, ""))
                places = [f".at[{place}]" for place in range(size)] or [""]
                if unit.types[key] != "bool":
                    put += [
                        f"axis.{_c(key)}{place} = in[WIDTH * i + {width + at}];"
                        for at, place in enumerate(places)
                    ]
                    self.inputs[name].append(key)
                    width += len(places)
            put = " ".join(put).replace("WIDTH", str(width))
            output = _c((outputs or {}).get(name) or translated.units[name].of("output")[0])
            drivers = DRIVER.format(name=name, block=_kind(name), set=put, output=output)
            drivers += TESTED.format(name=name, block=_kind(name))
            (folder / f"{name}.c").write_text(HEAD + translated.text() + drivers)
        quiet = ("-Wno-unused-function", "-Wno-unused-but-set-variable", "-Wno-clobbered")
        sources = [f"{name}.c" for name in models]
        self._library = library(folder, *FLAGS, *flags, f"-DROUNDED={rounded}", *quiet, *sources)

    def run(self, name, x=None, dt=5e-4, commands=0, **signals):
        """Return what a block gives along its inputs, and its flags; raise where a controller would stop."""
        values = {"position": x, "period": dt, **FED_WHOLE, **signals}
        count = len(values[self.inputs[name][0]])
        columns = [np.asarray(values[key], dtype=float) for key in self.inputs[name]]
        columns = [column if column.ndim else np.full(count, column) for column in columns]
        return self.replay(name, np.column_stack(columns), commands)

    def replay(self, name, inputs, commands=0):
        """Return what a block gives for a row of inputs at each call, and its flags."""
        count, inputs = len(inputs), np.ascontiguousarray(inputs, dtype=float)
        commands = np.ascontiguousarray(
            np.broadcast_to(np.asarray(commands, dtype=np.int32), count)
        )
        force, flags = np.full(count, np.nan), np.zeros(count, dtype=np.int32)
        real, whole = ctypes.POINTER(ctypes.c_double), ctypes.POINTER(ctypes.c_int)
        why = getattr(self._library, f"run_{name}")(
            count,
            inputs.ctypes.data_as(real),
            commands.ctypes.data_as(whole),
            force.ctypes.data_as(real),
            flags.ctypes.data_as(whole),
        )
        if why:
            raise StandardError(f"{name} stops: {REASONS[why]}")
        return force, flags

    def selftest(self, name):
        """Return whether the self-test of a block has come to its end, and passed."""
        result = ctypes.c_int(0)
        why = getattr(self._library, f"run_{name}_selftest")(ctypes.byref(result))
        if why:
            raise StandardError(f"the self-test of {name} stops: {REASONS[why]}")
        return bool(result.value & 1), bool(result.value & 2)


# Inputs of a feed that is the friction.
FED_WHOLE = {"gain": 1.0, "return_distance": 0.0, "fade_time": 0.5}

REASONS = {
    1: "division by zero, overflow or an invalid operation",
    2: "a place outside of an array",
    3: "a whole number divided by zero",
    4: "a conversion out of range",
    5: "a loop without end",
}
