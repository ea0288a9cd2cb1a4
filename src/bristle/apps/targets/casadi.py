"""External functions of CasADi: a step of a friction model in C with its derivatives, for graphs of optimization and estimation."""

from dataclasses import replace
from typing import Any

from bristle.exports import Product, Request
from bristle.exports.c import FILES, CFiles
from bristle.exports.c_derivatives import derived_step
from bristle.exports.c_parts import place_of
from bristle.exports.subject import subject_of


class CasadiFiles(CFiles):
    """Files of a friction model in C, and its functions for CasADi."""

    templates = FILES | {"{}_casadi.c": "casadi/casadi.c"}

    def facts(self) -> dict[str, Any]:
        """Return the facts of the templates."""
        assert self.derived is not None
        printer = self.new_printer()
        fields = [field | {"at": at} for at, field in enumerate(self.derived.fields(printer), 1)]
        return super().facts() | {
            "fields": fields,
            "numbers": [
                f"parameters.{place_of(name, within, printer)}"
                for name, within, _ in self.derived.tuned.numbers()
            ],
            "states": 1 + len(fields) + self.subject.memory_size,
        }


def write(request: Request) -> Product:
    """Return the sources; parameters are inputs of the functions."""
    request = replace(request, tunable=True)
    derived = derived_step(subject_of(request.sampled), tunable=True)
    return Product(dict(CasadiFiles(derived.subject, request, derived=derived).files()))
